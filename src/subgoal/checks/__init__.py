"""Is it right? What every sampler and every likelihood must keep to, measured on one of your own."""

from subgoal.checks.likelihood import check_likelihood
from subgoal.checks.report import Check, Report
from subgoal.checks.sampler import check_sampler

__all__ = ["Check", "Report", "check_likelihood", "check_sampler"]
