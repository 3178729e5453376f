"""One self-contained HTML page of a posterior."""

from subgoal.report.page import report

__all__ = ["report"]
