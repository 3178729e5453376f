"""Where subgoals may lie."""
