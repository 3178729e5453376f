"""Discrete worlds: tabular decision processes, grid worlds, and planning in them."""
