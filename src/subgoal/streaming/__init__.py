"""Learning while a recording is still going on: subgoals after every point."""

from subgoal.streaming.stream import Stream, warm

__all__ = ["Stream", "warm"]
