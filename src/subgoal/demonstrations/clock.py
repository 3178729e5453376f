"""Rows with times, in any order, made into trajectories whose times increase."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.records import Source
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError, ReadError, data_row

ROUNDING = 1e-6
"""Times this share of the usual step apart are one time."""
CLOCKS = ("refuse", "sort", "split", "drop")


def check_clock(clock: Any) -> None:
    """Raise ``InputError`` unless ``clock`` is one of the four ways to treat a clock that jumps back."""
    if clock not in CLOCKS:
        raise InputError("clock", found=repr(clock), wanted=" or ".join(map(repr, CLOCKS)))


def drop_duplicate_times(times: Floats, group: Ints) -> NDArray[np.bool_]:
    """(M,) False for a row whose time is that of the row before it in the same group, but for rounding."""
    keep = np.ones(len(times), bool)
    steps, same = np.abs(np.diff(times)), group[1:] == group[:-1]
    usual = np.median(steps[same & (steps > 0)]) if (same & (steps > 0)).any() else 0.0
    keep[1:] = (steps > ROUNDING * usual) | ~same
    return keep


def order_rows(
    times: Floats, group: Ints, source: Source, clock: str, where: Ints | None = None
) -> tuple[Ints, Ints, Source]:
    """Bring interleaved trajectories apart and treat clocks that jump back.

    Parameters
    ----------
    times, group:
        (M,) time and trajectory number of each row, in the order of the file.
    clock:
        "refuse" raises where the time of a trajectory goes back; "sort" orders the rows by time; "split" starts a
        new trajectory there; "drop" drops the rows that are not later than all before them. Rows that repeat the
        time of the row before are dropped and counted in every case.
    where:
        (M,) rows of the file for messages, from 0; 0 to M − 1 if not given.

    Returns
    -------
    Rows in their new order (K,), a number that changes where a trajectory is split (K,; all 0 unless it is), and the
    source with its counts.
    """
    check_clock(clock)
    rows = np.argsort(group, kind="stable")
    rows, source = _without_repeats(rows, times, group, source)
    back = _goes_back(times[rows], group[rows])
    piece = np.zeros(len(rows), np.int64)
    if not back.any():
        return rows, piece, source
    if clock == "refuse":
        _refuse(times, rows, int(np.argmax(back)), int(back.sum()), where)
    if clock == "drop":
        late = _later_than_all_before(times[rows], group[rows])
        source = source.noting(samples_of_a_clock_that_jumped_back_dropped=int((~late).sum()))
        return rows[late], piece[late], source
    if clock == "split":
        source = source.noting(trajectories_split_where_the_clock_jumped_back=int(back.sum()))
        return rows, np.cumsum(back), source
    source = source.noting(places_where_the_clock_jumped_back_sorted=int(back.sum()))
    rows, source = _without_repeats(rows[np.lexsort((times[rows], group[rows]))], times, group, source)
    return rows, np.zeros(len(rows), np.int64), source


def _without_repeats(rows: Ints, times: Floats, group: Ints, source: Source) -> tuple[Ints, Source]:
    fresh = drop_duplicate_times(times[rows], group[rows])
    return rows[fresh], source.noting(samples_of_repeated_time_dropped=int((~fresh).sum()))


def _goes_back(times: Floats, group: Ints) -> NDArray[np.bool_]:
    back = np.zeros(len(times), bool)
    back[1:] = (np.diff(times) < 0) & (np.diff(group) == 0)
    return back


def _later_than_all_before(times: Floats, group: Ints) -> NDArray[np.bool_]:
    late = np.empty(len(times), bool)
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    for start, end in zip(starts, [*starts[1:], len(times)], strict=True):
        highest = np.maximum.accumulate(times[start:end])
        late[start] = True
        late[start + 1 : end] = times[start + 1 : end] > highest[:-1]
    return late


def _refuse(times: Floats, rows: Ints, first: int, count: int, where: Ints | None) -> None:
    row = rows[first] if where is None else where[rows[first]]
    raise ReadError(
        "times", where=f"{data_row(row)} ({count} such place{'s' if count > 1 else ''})",
        found=f"{times[rows[first]]:.10g} after {times[rows[first - 1]]:.10g}",
        wanted="times that do not go back within a trajectory",
        hint="clock='sort' orders the rows, 'split' starts a new trajectory there, 'drop' drops the late rows; "
        "or name the column that tells trajectories apart with trajectory=",
    )  # fmt: skip
