"""Bayesian nonparametric reward learning from demonstration."""

__version__ = "0.1.0"
