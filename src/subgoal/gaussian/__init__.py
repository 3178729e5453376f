"""Gaussian processes, and dynamic programming with them for all goals at once."""

from subgoal.gaussian.evidence import Fitted
from subgoal.gaussian.factor import RegressionWarning, SingularError, Status
from subgoal.gaussian.regression import GaussianProcess, Regression, fit

__all__ = ["Fitted", "GaussianProcess", "Regression", "RegressionWarning", "SingularError", "Status", "fit"]
