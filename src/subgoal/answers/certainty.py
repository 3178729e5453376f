"""How sure one answer is: the ball of partitions around it, the gap of the best draw, chances of boundaries."""

from subgoal.answers.best_draw import BestDraw, best_draw
from subgoal.answers.credible_ball import CredibleBall, credible_ball
from subgoal.answers.partition import PointPartition, variation_of_information
from subgoal.answers.segments import boundaries

__all__ = [
    "BestDraw",
    "CredibleBall",
    "PointPartition",
    "best_draw",
    "boundaries",
    "credible_ball",
    "variation_of_information",
]
