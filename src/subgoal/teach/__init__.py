"""A local page on which goals are taught by hand: draw, see the subgoals, watch them flown."""
