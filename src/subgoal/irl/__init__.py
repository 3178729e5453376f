"""Learners under the names users look for: short compositions of the other rooms."""
