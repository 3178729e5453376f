"""From a learned subgoal to behaviour: options and their execution."""

from subgoal.options.comparison import Outcome, deviation, outcome, stretches
from subgoal.options.continuous import ContinuousOption
from subgoal.options.gym import run_in_env
from subgoal.options.learned import execute, option
from subgoal.options.tabular import Option, goal_option

__all__ = [
    "ContinuousOption",
    "Option",
    "Outcome",
    "deviation",
    "execute",
    "goal_option",
    "option",
    "outcome",
    "run_in_env",
    "stretches",
]
