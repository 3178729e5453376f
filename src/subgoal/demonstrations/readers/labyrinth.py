"""Walks of mice in the binary labyrinth of Rosenberg et al. (eLife 2021)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.columns import numbers
from subgoal.demonstrations.readers.csv import table
from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.layout import find_layout
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Ints
from subgoal.runtime.errors import InputError, ReadError, data_row

EXIT = 127
"""The node outside the labyrinth; 0 is the first junction, and n leads to 2n + 1 and 2n + 2."""
LEFT, RIGHT, BACK = 0, 1, 2
"""Actions: to 2n + 1, to 2n + 2, towards the exit."""


def read_labyrinth(path: Any, session: str | None = None, group: str | None = None) -> Demonstrations:
    """Read visits of nodes (columns session, bout, step, node, frame_in_bout) as a discrete demonstration.

    Each bout of a session is a trajectory "session/bout": states are nodes 0 to 126, actions 0 (to 2n + 1), 1 (to
    2n + 2) and 2 (back), the final state is the last node of the bout, ``truncated`` where that is not the exit
    127. Times are frames within the bout. Bouts of one visit are dropped and counted. ``session`` picks one mouse;
    ``group="session"`` makes each a group.

    Raises ``ReadError`` for an unknown session, a node that does not exist, visits out of order, and a step that
    no corridor of the labyrinth allows, naming the row; ``InputError`` for another group.
    """
    if group not in (None, "session"):
        raise InputError("group", found=repr(group), wanted="'session', the only column that can be one here")
    path = plain_file(path)
    layout = find_layout(path)
    wanted = ("session", "bout", "step", "node", "frame_in_bout")
    absent = [name for name in wanted if layout.names.count(name) != 1]
    if absent:
        raise ReadError(str(path), where=f"column {absent[0]!r}", found=f"columns {layout.names}", wanted="it once")
    columns = table(path, layout, wanted, text=("session",))
    names = np.array([str(name) for name in columns["session"]])
    if session is not None and session not in names:
        raise ReadError(str(path), where="session", found=repr(session), wanted=f"one of {sorted(set(names.tolist()))}")
    rows = np.flatnonzero(names == session) if session is not None else np.arange(len(names))
    whole = {name: _integers(path, name, columns[name])[rows] for name in wanted[1:]}
    walks = _walks(path, names[rows], whole, rows)
    if group is None:
        return walks
    return replace(walks, groups=tuple(name.rsplit("/", 1)[0] for name in walks.trajectory_names))


def _walks(path: Path, names: Any, whole: dict[str, Ints], rows: Ints) -> Demonstrations:
    bout, node = whole["bout"], whole["node"]
    fresh = np.append(True, (names[1:] != names[:-1]) | (bout[1:] != bout[:-1]))
    if len(rows) == 0:
        raise ReadError(str(path), found="no visit", wanted="at least two")
    _check(path, node, whole["step"], fresh, rows)
    starts = np.flatnonzero(fresh)
    labels = [f"{names[k]}/{bout[k]}" for k in starts]
    if len(set(labels)) != len(labels):
        raise ReadError(str(path), found="a bout in two places", wanted="the visits of a bout together")
    lengths = np.diff(np.append(starts, len(rows)))
    long = lengths > 1
    if not long.any():
        raise ReadError(str(path), found="bouts of one visit only", wanted="at least two visits in a bout")
    moves = np.flatnonzero(~fresh) - 1
    final = node[(starts + lengths - 1)[long]]
    return Demonstrations(
        states=node[moves],
        actions=_actions(path, node[moves], node[moves + 1], rows[moves]),
        offset=np.append(0, np.cumsum(lengths[long] - 1)),
        times=whole["frame_in_bout"][moves].astype(np.float64),
        final_states=final,
        truncated=final != EXIT,
        names=("node",),
        trajectory_names=tuple(label for label, kept in zip(labels, long, strict=True) if kept),
        time_unit="frame",
        source=source_of(path).noting(bouts_of_one_visit_dropped=int((~long).sum())),
    )


def _actions(path: Path, here: Ints, there: Ints, rows: Ints) -> Ints:
    """Action of each move; a child of a node at the lowest level, 127 and above, does not exist."""
    actions = np.full(len(here), -1)
    actions[(there == 2 * here + 1) & (there < EXIT) & (here < EXIT)] = LEFT
    actions[(there == 2 * here + 2) & (there < EXIT) & (here < EXIT)] = RIGHT
    actions[np.where(here == 0, there == EXIT, (there == (here - 1) // 2) & (here < EXIT))] = BACK
    if (actions < 0).any():
        k = int(np.argmax(actions < 0))
        raise ReadError(
            str(path), where=data_row(rows[k]), found=f"a step from {here[k]} to {there[k]}", wanted="a corridor"
        )
    return actions


def _check(path: Path, node: Ints, step: Ints, fresh: Any, rows: Ints) -> None:
    for what, bad in (
        ("node", (node < 0) | (node > EXIT)),
        ("step", np.append(False, np.diff(step) != 1) & ~fresh),
    ):
        if bad.any():
            k = int(np.argmax(bad))
            value = node[k] if what == "node" else step[k]
            raise ReadError(
                str(path), where=f"column {what!r}, {data_row(rows[k])}", found=int(value),
                wanted="0 to 127" if what == "node" else "the step after the one before",
            )  # fmt: skip


def _integers(path: Path, name: str, column: Any) -> Ints:
    values = numbers(path, name, column)
    bad = ~((values == np.floor(values)) & (np.abs(values) < 2**53))
    if bad.any():
        row = int(np.argmax(bad))
        raise ReadError(
            str(path), where=f"column {name!r}, {data_row(row)}", found=values[row], wanted="a whole number"
        )
    return values.astype(np.int64)
