"""A local page on which goals are taught by hand: draw, see the subgoals, watch them flown."""

from subgoal.teach.limits import Limits
from subgoal.teach.server import serve

__all__ = ["Limits", "serve"]
