"""Groups of trajectories (an animal, a driver, a day) from their names."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Ints
from subgoal.runtime.errors import InputError


def groups_by_name(demonstrations: Demonstrations, of: str | Callable[[str], str]) -> tuple[Ints, tuple[str, ...]]:
    """(D,) number of the group of each trajectory, and the K names of the groups, sorted.

    Parameters
    ----------
    of:
        A function from the name of a trajectory to that of its group; or a regular expression that is found in every
        name, whose first bracket (all of it, if it has none) is the name of the group: ``r"^(.*)_"`` for "fox_1".

    Raises
    ------
    InputError
        A pattern that is no regular expression, a name in which it is not found, a function that gives no text.
    """
    namer = _finder(of) if isinstance(of, str) else of
    names = [_checked(namer(name), d, name) for d, name in enumerate(demonstrations.trajectory_names)]
    groups = sorted(set(names))
    number = {name: k for k, name in enumerate(groups)}
    return np.array([number[name] for name in names], np.int64), tuple(groups)


def _finder(pattern: str) -> Callable[[str], str | None]:
    try:
        expression = re.compile(pattern)
    except re.error as problem:
        raise InputError("pattern", found=f"{pattern!r} ({problem})", wanted="a regular expression") from None

    def find(name: str) -> str | None:
        match = expression.search(name)
        return match.group(1 if expression.groups else 0) if match else None

    return find


def _checked(found: object, d: int, name: str) -> str:
    if not isinstance(found, str):
        raise InputError(
            "group of a trajectory", where=f"trajectory {d}, {name!r}", found="none" if found is None else repr(found),
            wanted="a name", hint="a pattern that is found in every name of a trajectory",
        )  # fmt: skip
    return found
