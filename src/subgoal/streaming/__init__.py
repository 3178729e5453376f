"""Learning while a recording is still going on: subgoals after every point."""
