"""Where a state goes when an action is held: known models, and models learned from a recording."""
