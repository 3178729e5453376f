"""Gaussian processes, and dynamic programming with them for all goals at once."""
