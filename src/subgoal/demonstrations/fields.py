"""What the fields of the records may hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from subgoal.runtime.checks import Floats, Ints, frozen, owned, real_array
from subgoal.runtime.errors import InputError

UNIT = 1e-6
"""So far from 1 may the norm of a unit quaternion be."""
CONTINUE = "continue_quaternions makes them so"


def values_of(what: str, value: Any) -> Any:
    """Integers (N,) as int64, anything else as float (N, k)."""
    array = np.asarray(value)
    if array.size == 0:
        raise InputError(what, found="no observations", wanted="at least one")
    if array.dtype.kind in "iu" and array.ndim == 1:
        return frozen(owned(np.ascontiguousarray(array, dtype=np.int64), array))
    if array.ndim == 1:
        array = array[:, None]
    return real_array(what, array, ndim=2)


def coordinates_of(value: Any, states: Any, final: Any) -> Floats:
    """(S, d) with a row for every state there is."""
    if states.ndim != 1:
        raise InputError("coordinates", found="coordinates beside positions", wanted="None: positions are coordinates")
    coordinates = real_array("coordinates", value, ndim=2)
    for what, values in (("states", states), ("final_states", final)):
        outside = (values < 0) | (values >= len(coordinates))
        if outside.any():
            k = int(np.argmax(outside))
            wanted = f"a state of 0 to {len(coordinates) - 1}, as there are coordinates"
            raise InputError(what, where=f"index {k}", found=int(values[k]), wanted=wanted)
    return coordinates


def same_length(what: str, array: Any, count: int) -> None:
    """Raise ``InputError`` unless ``array`` has ``count`` rows."""
    if len(array) != count:
        raise InputError(what, found=f"{len(array)} rows", wanted=f"{count} rows")


def labels_of(what: str, given: Sequence[str], count: int, prefix: str) -> tuple[str, ...]:
    """``count`` labels, numbered after ``prefix`` where none are given; ``InputError`` for another number of them."""
    if not given:
        return tuple(f"{prefix}{k}" for k in range(count))
    if len(given) != count:
        raise InputError(what, found=f"{len(given)} labels", wanted=f"{count}")
    return tuple(str(label) for label in given)


def group_labels(given: Any, count: int) -> tuple[str, ...]:
    """A name for each trajectory, or none at all."""
    if isinstance(given, str):
        raise InputError("groups", found=repr(given), wanted=f"{count} names, one for each trajectory")
    return labels_of("groups", tuple(given), count, "") if len(given) else ()


def set_fields(record: Any, **values: Any) -> None:
    """Set fields of a frozen record while it is made."""
    for name, value in values.items():
        object.__setattr__(record, name, value)


def check_period(given: Any, count: int) -> tuple[float, ...]:
    """``count`` lengths above 0, or none at all. Raises ``InputError`` for anything else."""
    period = real_array("period", given, ndim=1, finite=False)
    if period.size not in (0, count) or not (period > 0).all():
        raise InputError("period", found=list(period), wanted=f"{count} numbers above 0, or none")
    return tuple(period.tolist())


def check_quaternion(at: Any, positions: Floats, offset: Ints) -> None:
    """Raise ``InputError`` unless columns ``at`` to ``at`` + 3 hold unit quaternions of continuous sign."""
    if at is None:
        return
    wanted = f"a column from 0 to {positions.shape[1] - 4}, the first of four"
    if isinstance(at, bool) or not isinstance(at, int) or not 0 <= at <= positions.shape[1] - 4:
        raise InputError("quaternion", found=repr(at), wanted=wanted)
    four, inside = positions[:, at : at + 4], np.ones(len(positions), bool)
    inside[offset[:-1]] = False
    norm = np.linalg.norm(four, axis=1)
    alone, turned = np.abs(norm - 1) > UNIT, inside & (np.einsum("ij,ij->i", four, np.roll(four, 1, axis=0)) < -UNIT)
    if alone.any():
        row = int(np.argmax(alone))
        raise InputError("quaternion", where=f"row {row}", found=f"norm {norm[row]:.6g}", wanted="1", hint=CONTINUE)
    if turned.any():
        raise InputError(
            "quaternion", where=f"row {int(np.argmax(turned))}", found="the other sign of nearly the same rotation",
            wanted="signs that continue along a trajectory", hint=CONTINUE,
        )  # fmt: skip
