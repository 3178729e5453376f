"""One self-contained HTML page of a posterior."""

from subgoal.reporting.page import report

__all__ = ["report"]
