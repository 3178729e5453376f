"""How subgoals follow each other, and what is learned with which prior: arguments of ``subgoal.sample``."""

from subgoal.likelihood.noise import NoiseLevels, OneConfidence, OwnConfidence
from subgoal.partition.groups import Grouped
from subgoal.partition.persistence import Persistent
from subgoal.partition.priors import Beta, Gamma, LogNormal
from subgoal.partition.sticky_hmm import StickyHMM

__all__ = [
    "Beta",
    "Gamma",
    "Grouped",
    "LogNormal",
    "NoiseLevels",
    "OneConfidence",
    "OwnConfidence",
    "Persistent",
    "StickyHMM",
]
