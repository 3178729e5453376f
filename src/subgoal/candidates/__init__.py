"""Where subgoals may lie."""

from subgoal.candidates.places import epsilon_net, read_candidates
from subgoal.candidates.record import Candidates
from subgoal.candidates.states import every_state, feature_subgoals, visited, visited_and_successors

__all__ = [
    "Candidates",
    "epsilon_net",
    "every_state",
    "feature_subgoals",
    "read_candidates",
    "visited",
    "visited_and_successors",
]
