"""What every room needs: typed errors, checks at the door, seed streams, progress, executor."""
