"""Versioned files without pickle: posteriors and checkpoints."""
