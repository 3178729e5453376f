"""Goals as sets of states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from subgoal.runtime.checks import Bools, Ints
from subgoal.runtime.errors import InputError


def goal_sets(goals: Any, check: Callable[[str, Any], Ints]) -> list[Ints]:
    """Each goal as its sorted states; ``check(what, states)`` refuses those that do not exist."""
    if isinstance(goals, np.ndarray) and goals.ndim == 1 and goals.dtype.kind in "iu":
        sets = list(check("goals", goals)[:, None])
    else:
        try:
            entries = list(goals)
        except TypeError:
            entries = [goals]
        for g, each in enumerate(entries):
            if not np.size(each):
                raise InputError(f"goal {g}", found="no state", wanted="at least one")
        sets = [np.unique(check(f"goal {g}", np.atleast_1d(each))) for g, each in enumerate(entries)]
    if not sets:
        raise InputError("goals", found="none", wanted="at least one")
    return sets


def membership(sets: list[Ints], n_states: int) -> tuple[Ints, Bools]:
    """(S,) row of each goal state, −1 elsewhere, and (rows, L) which lanes it is a goal of."""
    states = np.unique(np.concatenate(sets))
    mark = np.full(n_states, -1, np.int64)
    mark[states] = np.arange(states.size)
    member = np.zeros((states.size, len(sets)), bool)
    for j, members in enumerate(sets):
        member[mark[members], j] = True
    return mark, member
