"""Checks at the door: arrays in, validated read-only float or integer arrays out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.runtime.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """A read-only view; the caller's own array keeps its flags."""
    view = array.view()
    view.flags.writeable = False
    return view


def owned(array: NDArray[Any], given: NDArray[Any]) -> NDArray[Any]:
    """``array``, copied if the caller could still change it through ``given`` (memory maps are left where they are)."""
    base: Any = given
    while isinstance(base, np.ndarray) and not isinstance(base, np.memmap):
        if base.flags.writeable and np.may_share_memory(array, given):
            return array.copy()
        base = base.base
    return array


def copied(what: str, value: Any) -> NDArray[Any]:
    """A copy of ``value`` as an array of whatever kind. Raises ``InputError`` for rows of different lengths."""
    try:
        return np.array(value)
    except ValueError:
        raise InputError(what, found="rows of different lengths", wanted="rows of one length") from None


def real_array(what: str, value: Any, *, ndim: int | tuple[int, ...], finite: bool = True) -> Floats:
    """``value`` as a C-contiguous read-only float64 array of ``ndim`` dimensions.

    Raises ``InputError`` naming the first offending index for NaN and infinity.
    """
    try:
        given = np.asarray(value)
        if np.iscomplexobj(given):
            raise TypeError("complex")
        array = owned(np.ascontiguousarray(given, dtype=np.float64).reshape(given.shape), given)
    except (TypeError, ValueError) as problem:
        told = "rows of different lengths" if "inhomogeneous" in str(problem) else problem
        raise InputError(what, found=f"{type(value).__name__} ({told})", wanted="real numbers") from None
    wanted = (ndim,) if isinstance(ndim, int) else ndim
    if array.ndim not in wanted:
        shape = " or ".join(f"{n} dimension{'s' if n != 1 else ''}" for n in wanted)
        raise InputError(what, found=f"an array of shape {array.shape}", wanted=shape)
    if finite and not np.isfinite(array).all():
        index = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise InputError(what, where=f"index {index}", found=array[index], wanted="a finite number")
    return frozen(array)


def positive(what: str, value: Any, *, zero: bool = False) -> float:
    """``value`` as a finite float above zero (or at least zero). NaN fails."""
    wanted = "a finite number of at least 0" if zero else "a finite number above 0"
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(what, found=repr(value), wanted=wanted) from None
    if not (number >= 0 if zero else number > 0) or not np.isfinite(number):
        raise InputError(what, found=value, wanted=wanted)
    return number


def whole(what: str, value: Any, *, least: int = 1) -> int:
    """``value`` as an integer of at least ``least``; 2.0 passes, 2.5 and True do not."""
    wanted = f"a whole number of at least {least}"
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(what, found=repr(value), wanted=wanted)
    if not value >= least or abs(value) == float("inf") or value != int(value):
        raise InputError(what, found=value, wanted=wanted)
    return int(value)


def whole_numbers(what: str, value: Any, count: int) -> Ints:
    """``value`` as (count,) integers. Raises ``InputError`` naming the first that is none."""
    array = real_array(what, value, ndim=1)
    if array.shape != (count,):
        raise InputError(what, found=f"{array.size} of them", wanted=f"{count}")
    near = (array == np.trunc(array)) & (np.abs(array) < 2**53)
    if not near.all():
        k = int(np.argmin(near))
        raise InputError(what, where=f"index {k}", found=array[k], wanted="a whole number")
    return frozen(array.astype(np.int64))


def text(what: str, value: Any) -> str:
    """``value`` as a text, empty or not."""
    if not isinstance(value, str):
        raise InputError(what, found=repr(value), wanted="a text")
    return value


def flag(what: str, value: Any) -> bool:
    """``value`` as True or False; 1 and "yes" are neither."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(what, found=repr(value), wanted="True or False")
    return bool(value)


def check_offset(offset: Any, count: int) -> Ints:
    """Trajectory boundaries (D+1,): from 0 to ``count``; empty trajectories are refused."""
    array = np.asarray(offset)
    if array.ndim != 1 or array.size < 2 or array.dtype.kind not in "iu":
        raise InputError(
            "offset",
            found=f"{array.dtype} of shape {array.shape}",
            wanted="integers of shape (trajectories + 1,)",
        )
    array = np.ascontiguousarray(array, dtype=np.int64)
    if array[0] != 0 or array[-1] != count:
        raise InputError("offset", found=f"{array[0]}..{array[-1]}", wanted=f"0..{count}")
    steps = np.diff(array)
    if (steps <= 0).any():
        where = int(np.argmax(steps <= 0))
        raise InputError(
            "offset", where=f"trajectory {where}", found=f"{steps[where]} observations", wanted="at least one"
        )
    return frozen(array)
