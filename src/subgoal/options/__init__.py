"""From a learned subgoal to behaviour: options and their execution."""

from subgoal.options.tabular import Option, execute, goal_option, option

__all__ = ["Option", "execute", "goal_option", "option"]
