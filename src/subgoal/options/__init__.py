"""From a learned subgoal to behaviour: options and their execution."""
