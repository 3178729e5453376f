"""Planning: any reward by the general planners, all subgoals at once by first passage; policies and rewards."""
