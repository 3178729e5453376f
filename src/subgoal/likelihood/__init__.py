"""Everything that makes a table log p(action | state, subgoal)."""
