"""The exact samplers, each a function to pass to ``subgoal.sample``; and the thesis's own forms, for comparison."""

from subgoal.partition.alg4 import alg4_corrected, alg4_literal, alg4_literal_fresh_draw, alg4_literal_sum
from subgoal.partition.collapsed_blocks import collapsed_blocks

__all__ = [
    "alg4_corrected",
    "alg4_literal",
    "alg4_literal_fresh_draw",
    "alg4_literal_sum",
    "collapsed_blocks",
]
