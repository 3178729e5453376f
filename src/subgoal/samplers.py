"""The exact samplers, each a function to pass to ``subgoal.sample``; and the thesis's own forms, for comparison.

All but the ``alg4_literal`` forms draw from the same posterior; they differ in how fast.
``split_merge`` and ``tempered`` need a table that is held whole.

* ``collapsed_blocks``: one observation at a time, then whole clusters change their candidate.
* ``collapsed``: one observation at a time only; the plainest, against which the others are held.
* ``blocked``: the weights of the candidates, then all observations given them.
* ``cluster_collapsed``: a partition of the observations, the candidate of each cluster summed out.
* ``split_merge``: ``collapsed_blocks`` with proposals to split a cluster in two or to make one of two.
* ``tempered``: ``collapsed_blocks`` at four powers of the likelihood, exchanging states; ``Tempering`` has others.
* ``alg4_corrected``: Algorithm 4 of the thesis with its two errors mended.
"""

from subgoal.partition.alg4 import alg4_corrected, alg4_literal, alg4_literal_fresh_draw, alg4_literal_sum
from subgoal.partition.annealed import Annealed as Annealed
from subgoal.partition.annealed import annealed
from subgoal.partition.blocked import blocked
from subgoal.partition.cluster_collapsed import cluster_collapsed
from subgoal.partition.collapsed import collapsed
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.split_merge import split_merge
from subgoal.partition.tempered import Tempering as Tempering
from subgoal.partition.tempered import tempered

__all__ = [
    "alg4_corrected",
    "alg4_literal",
    "alg4_literal_fresh_draw",
    "alg4_literal_sum",
    "annealed",
    "blocked",
    "cluster_collapsed",
    "collapsed",
    "collapsed_blocks",
    "split_merge",
    "tempered",
]
