"""Named columns of one table to a Recording: what CSV, Parquet and NPZ have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.clock import check_clock, order_rows
from subgoal.demonstrations.readers.grouping import group_of_each, numbered
from subgoal.demonstrations.recordings import piece_names
from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.checks import Floats, Ints, positive
from subgoal.runtime.errors import InputError, ReadError, data_row

TIME_NAMES = ("t", "time", "timestamp")
TRAJECTORY_NAMES = (
    "id", "track", "track_id", "trajectory", "trajectory_id", "traj_id", "particle", "agent_id", "ped_id", "animal",
)  # fmt: skip
OTHER_NAMES = (
    "", "index", "frame", "frame_id", "frame_number", "step", "group", "name", "label", "type", "class", "likelihood",
)  # fmt: skip
"""Not proposed as places."""
MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "<na>", "-nan", "nat"})
"""Cells that mean "no value", in lower case."""


@dataclass(frozen=True)
class Choice:
    """Which columns mean what; see ``read_csv`` for the options."""

    position: tuple[str, ...]
    time: str | None = None
    trajectory: str | None = None
    action: tuple[str, ...] = ()
    likelihood: str | None = None
    group: str | None = None

    @property
    def all(self) -> tuple[str, ...]:
        """Every column that is needed, each once."""
        single = [n for n in (self.time, self.trajectory, self.likelihood, self.group) if n is not None]
        return tuple(dict.fromkeys([*self.position, *self.action, *single]))


@dataclass(frozen=True)
class Treatment:
    """What to do with the columns; see ``read_csv`` for the options. Checked when made."""

    scale: float = 1.0
    units: str = ""
    time_scale: float = 1.0
    clock: str = "refuse"
    min_likelihood: float = 0.6
    rate: float | None = None

    def __post_init__(self) -> None:
        check_clock(self.clock)
        positive("scale", self.scale)
        positive("time_scale", self.time_scale)
        positive("min_likelihood", self.min_likelihood, zero=True)
        if self.rate is not None:
            positive("rate", self.rate)


def choose(
    path: Any, found: Sequence[str], position: Any, time: Any, trajectory: Any, action: Any, likelihood: Any, group: Any
) -> Choice:
    """The columns the caller named, or x, y (z), t, time or timestamp, and id, track or the like where they are there.

    The column of the group is not taken for that of the trajectory unless it is named for both.
    Raises ``ReadError`` listing the columns found when one is missing or ambiguous.
    """
    lower = {name.lower(): name for name in reversed(found)}
    if position is None:
        if "x" not in lower or "y" not in lower:
            raise ReadError(
                str(path),
                found=_listed(found),
                wanted="columns x and y, or to be told",
                hint=_advice(found, (time, trajectory, likelihood, group)),
            )
        position = [lower[n] for n in "xyz" if n in lower]
    if time is None:
        time = next((lower[n] for n in TIME_NAMES if n in lower), None)
    if trajectory is None:
        taken = {*column_names("position", position), _name("group", group)}
        trajectory = next((lower[n] for n in TRAJECTORY_NAMES if n in lower and lower[n] not in taken), None)
    choice = Choice(
        column_names("position", position),
        _name("time", time),
        _name("trajectory", trajectory),
        () if action is None else column_names("action", action),
        _name("likelihood", likelihood),
        _name("group", group),
    )
    for name in choice.all:
        if found.count(name) != 1:
            told = f"{found.count(name)} columns of that name" if name in found else _listed(found)
            raise ReadError(str(path), where=f"column {name!r}", found=told, wanted="one such column")
    return choice


def numbers(path: Any, name: str, column: Any) -> Floats:
    """A column as floats, NaN where a cell is empty. Raises ``ReadError`` naming the first row that is no number."""
    import pandas as pd

    kind = pd.Series(column).dtype
    if kind.kind in "mMc":
        raise ReadError(str(path), where=f"column {name!r}", found=str(kind), wanted="real numbers")
    try:
        values = pd.to_numeric(pd.Series(column), errors="coerce").to_numpy(np.float64, na_value=np.nan)
    except OverflowError:
        values = np.array([_float(cell) for cell in column])
    if np.asarray(column).dtype.kind not in "iufb":
        cells = pd.Series(column)
        bad = np.isnan(values) & ~_empty(cells)
        if bad.any():
            row = int(np.argmax(bad))
            cell = str(cells.iloc[row])[:40]
            raise ReadError(
                str(path), where=f"column {name!r}, {data_row(row)}", found=repr(cell), wanted="a number",
                hint="decimal=','" if "," in cell and "." not in cell else None,
            )  # fmt: skip
    if np.isinf(values).any():
        row = int(np.argmax(np.isinf(values)))
        raise ReadError(
            str(path), where=f"column {name!r}, {data_row(row)}", found=values[row], wanted="a finite number"
        )
    return np.asarray(values)


def _float(cell: Any) -> float:
    """The number in a cell, infinite where it is an integer beyond all floats, NaN where it is none."""
    try:
        return float(cell)
    except OverflowError:
        return np.inf
    except (TypeError, ValueError):
        return np.nan


def _empty(cells: Any) -> NDArray[np.bool_]:
    """(M,) which cells of a pandas Series mean "no value"."""
    text = cells.astype(str).str.strip().str.lower()
    return np.asarray((cells.isna() | text.isin(MISSING)).to_numpy(bool))


def seconds(path: Any, name: str, column: Any) -> Floats:
    """A time column as numbers: as they are, or seconds since the earliest of its ISO 8601 timestamps."""
    import pandas as pd

    series = pd.Series(column)
    if series.dtype.kind != "M":
        try:
            return numbers(path, name, column)
        except ReadError as problem:
            if not series.dropna().map(lambda cell: isinstance(cell, str)).any():
                raise
            stamps = pd.to_datetime(series, errors="coerce", format="ISO8601", utc=True)
            bad = stamps.isna().to_numpy(bool) & ~_empty(series)
            if bad.any():
                row = int(np.argmax(bad))
                raise ReadError(
                    str(path), where=f"column {name!r}, {data_row(row)}", found=repr(str(series.iloc[row])[:40]),
                    wanted="a number, or a timestamp such as 2024-05-01T12:00:00.25",
                ) from problem  # fmt: skip
            series = stamps
    return np.asarray((series - series.min()).dt.total_seconds().to_numpy(np.float64, na_value=np.nan))


def assemble(path: Any, columns: dict[str, Any], choice: Choice, how: Treatment, source: Source) -> Recording:
    """A Recording from the columns (each (M,)) that ``choice`` names, treated as ``how`` says."""
    places = _matrix(path, columns, choice.position)
    actions = _matrix(path, columns, choice.action) if choice.action else None
    group, labels = _groups(columns, choice.trajectory, len(places))
    times, unit = _times(path, columns, choice, how, group)
    bad: dict[str, Any] = {
        "rows_without_a_trajectory_dropped": group < 0,
        "rows_without_a_position_dropped": np.isnan(places).any(axis=1),
        "rows_without_a_time_dropped": np.isnan(times),
        "rows_of_low_likelihood_dropped": _unlikely(path, columns, choice, how),
        "rows_without_an_action_dropped": None if actions is None else np.isnan(actions).any(axis=1),
    }
    row, source = _complete(len(places), bad, source)
    if not len(row):
        raise ReadError(str(path), found=source.told("no complete row", "no row of data"), wanted="at least one")
    of_each = []
    if choice.group is not None:
        own = columns[choice.group]
        of_each = group_of_each(path, choice.group, own, rows=row, trajectory=group, labels=labels)
    order, piece, source = order_rows(times[row], group[row], source, how.clock, where=row)
    row = row[order]
    starts = np.flatnonzero((np.diff(group[row], prepend=-1) != 0) | (np.diff(piece, prepend=0) != 0))
    present, parent = np.unique(group[row][starts], return_inverse=True)
    with np.errstate(over="ignore"):
        scaled = places[row] * how.scale
    return Recording(
        positions=scaled, times=times[row], offset=np.append(starts, len(row)), names=choice.position,
        units=how.units, trajectory_names=piece_names([labels[g] for g in present], parent)[0], time_unit=unit,
        source=source, actions=None if actions is None else actions[row],
        groups=tuple(of_each[g] for g in group[row][starts]) if of_each else (),
    )  # fmt: skip


def _matrix(path: Any, columns: dict[str, Any], names: Sequence[str]) -> Floats:
    return np.stack([numbers(path, name, columns[name]) for name in names], axis=1)


def _groups(columns: dict[str, Any], trajectory: str | None, count: int) -> tuple[Ints, list[str]]:
    """Trajectory number of each row in order of first appearance (−1 where it is missing), and their labels."""
    if trajectory is None:
        return np.zeros(count, np.int64), ["T0"]
    return numbered(columns[trajectory])


def _times(path: Any, columns: dict[str, Any], choice: Choice, how: Treatment, group: Ints) -> tuple[Floats, str]:
    """Times of the rows and their unit; without a time column, the number of the row in its trajectory over rate."""
    if choice.time is not None:
        with np.errstate(over="ignore"):
            return seconds(path, choice.time, columns[choice.time]) * how.time_scale, "s"
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-2) != 0)
    index = np.empty(len(group))
    index[order] = np.arange(len(group)) - np.repeat(starts, np.diff(np.append(starts, len(group))))
    return (index, "sample") if how.rate is None else (index / how.rate, "s")


def _unlikely(path: Any, columns: dict[str, Any], choice: Choice, how: Treatment) -> NDArray[np.bool_] | None:
    if choice.likelihood is None:
        return None
    return ~(numbers(path, choice.likelihood, columns[choice.likelihood]) >= how.min_likelihood)


def _complete(count: int, bad: dict[str, Any], source: Source) -> tuple[Ints, Source]:
    """Rows free of every fault, and the source with each dropped row counted under its first fault."""
    keep = np.ones(count, bool)
    for reason, faulty in bad.items():
        if faulty is not None:
            source = source.noting(**{reason: int((keep & faulty).sum())})
            keep &= ~faulty
    return np.flatnonzero(keep), source


def _listed(found: Sequence[str]) -> str:
    shown = ", ".join(repr(name) for name in found[:30])
    return f"columns {shown}" + (" and more" if len(found) > 30 else "")


def _advice(found: Sequence[str], taken: Sequence[Any]) -> str:
    """Two columns that may hold the place: those whose names differ by x and y, or else the first two that are free."""
    if all(name.isdigit() for name in found):
        free = list(found[1:] if len(found) > 2 else found)
    else:
        free = [name for name in found if name.lower() not in (*TIME_NAMES, *TRAJECTORY_NAMES, *OTHER_NAMES)]
    free = [name for name in free if name not in taken]
    pairs = [[a, b] for a in free for b in free if a != b and a.lower().replace("x", "y") == b.lower()]
    pair = pairs[0] if pairs else free[:2]
    told = f"position={pair!r}" if len(pair) == 2 else "position="
    return f"{told} (the columns that hold the place)"


def _name(what: str, given: Any) -> str | None:
    """One column, by name or by number."""
    if given is None or isinstance(given, str):
        return given
    if isinstance(given, (int, np.integer)) and not isinstance(given, bool):
        return str(given)
    raise InputError(what, found=repr(given), wanted="the name of a column")


def column_names(what: str, given: Any) -> tuple[str, ...]:
    """One column or several, each once. Raises ``InputError`` for anything else."""
    listed = [given] if isinstance(given, str) else given
    if not isinstance(listed, Sequence) or not listed:
        raise InputError(what, found=repr(given), wanted="names of columns, such as ['x', 'y']")
    names = tuple(str(_name(what, name)) for name in listed)
    if len(set(names)) != len(names) or "None" in names:
        raise InputError(what, found=repr(given), wanted="names of different columns")
    return names
