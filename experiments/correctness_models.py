"""Exact moves of the models in which subgoals follow each other or groups of trajectories differ.

Weights and rows of transitions are continuous and are given here; what is drawn from a law that can be written down is
held against that law, and what moves whole candidates against the posterior that it must leave as it is.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from typing import Any
from unittest.mock import patch

import numpy as np

from experiments.correctness_moves import INVARIANT, LAW, Row, drift, five, gap, matrix, normalised, replay, tables
from subgoal.runtime.checks import Floats

hdp: Any = import_module("tests.oracles.hdp")
partitions: Any = import_module("tests.oracles.partitions")
lasting: Any = import_module("tests.exact.test_transition_persistence")
sticky: Any = import_module("tests.exact.test_transition_sticky_hmm")
grouped: Any = import_module("tests.exact.test_transition_groups")
together: Any = import_module("subgoal.partition.together")
blocks: Any = import_module("subgoal._kernels.collapsed_blocks")

PATHS = (1, 1, 1, 1), (0, 0, 1, 0), (2, 2, 2, 0), (0, 1, 0, 2)
CANDIDATES = ("generic", 3, 4), ("barred", 3, 3), ("peaked", 2, 4)
"""Table, and how many of its candidates and observations are used."""
OF_GROUPS = (0, 0, 0, 0), (1, 0, 0, 1), (1, 1, 1, 0)
SEATED = (0, 1, 1, 2), (0, 1, 2, 0)
STEPS = 4
"""Of the paths whose runs are moved."""
WAYS = {"one by one": 2**24, "by restaurants": 0}
"""How runs and tables are moved, and up to which size of their matrix that is so."""


def in_time_and_groups(steps: int = STEPS) -> Iterator[Row]:
    """Every exact move of ``Persistent``, ``StickyHMM`` and ``Grouped``."""
    yield from of_persistent_paths()
    yield from of_runs(steps)
    yield from of_sticky_paths()
    yield from of_tables_of_rows()
    yield from of_whole_candidates()
    yield from of_sites_of_groups()
    yield from of_seats()
    yield from of_tables_of_groups()


def of_persistent_paths() -> Iterator[Row]:
    """The path and its redraws given weights, drawn backward."""
    weights = np.array([0.2, 0.7, 0.1])
    for name in tables.TABLES:
        for keeps in lasting.KEEPS:
            table, model = lasting.temporal_table(name), lasting.Persistent(keep=keeps[0], keep_there=keeps[1])

            def move(table: Any = table, model: Any = model, keeps: Any = keeps) -> Any:
                drawn = lasting.steps_at(table, model, ((0, 0, 1, 2), (True, False, True, True)), *keeps)
                drawn._draw_path(weights)
                return tuple(drawn.theta.tolist()), tuple(bool(r) for r in drawn.redrawn)

            wanted = lasting.given_weights(table.dense, lasting.STARTS, weights, *keeps, lasting.ARRIVED)
            yield "Persistent", "path given weights", LAW, gap(replay.outcomes(lasting.loops, move), wanted)


def of_runs(steps: int) -> Iterator[Row]:
    """Runs of one subgoal move, given where redraws fall."""
    for keeps, (way, entries) in itertools.product(((0.6, 0.6), (0.8, 0.3)), WAYS.items()):
        table, arrived = lasting.temporal_table("generic", steps, 2), lasting.ARRIVED[:steps, :2]
        starts = tuple(start for start in lasting.STARTS if start < steps)
        model = lasting.Persistent(keep=keeps[0], keep_there=keeps[1])

        def prior_of(state: Any, keeps: Any = keeps, arrived: Any = arrived, starts: Any = starts) -> Any:
            return lasting.step_probability(state, starts, *keeps, arrived)

        def move(state: Any, table: Any = table, model: Any = model, keeps: Any = keeps) -> Any:
            drawn = lasting.steps_at(table, model, state, *keeps)
            drawn._move_runs()
            return tuple(drawn.theta.tolist()), state[1]

        law = lasting.posterior(table.dense, starts, lasting.ETA, np.exp(table.log_prior), prior_of)
        yield "Persistent", f"candidates of runs, {way}", INVARIANT, moved_apart(law, move, entries)


def of_sticky_paths() -> Iterator[Row]:
    """The path given rows of transitions, over two blocks of rows."""
    for dense in sticky.ALL.values():
        table = sticky.with_trajectories(dense, sticky.STARTS, edges=(2,))

        def move(table: Any = table) -> Any:
            walk = sticky.walk_at(table, (0, 2, 0, 1))
            sticky.given(walk)
            walk._draw_path()
            return tuple(walk.theta.tolist())

        wanted = {
            theta: sticky.fit(dense, theta) * math.prod(
                sticky.BEGIN[g] if i in sticky.STARTS else sticky.ROWS[theta[i - 1], g] for i, g in enumerate(theta)
            )
            for theta in itertools.product(range(3), repeat=4)
        }  # fmt: skip
        yield "StickyHMM", "path given rows", LAW, gap(replay.outcomes(sticky.loops, move), normalised(wanted))


def of_tables_of_rows() -> Iterator[Row]:
    """How often each candidate was drawn from β, and how often stickiness set it, given the path."""
    table = sticky.with_trajectories(tables.TABLES["generic"], (0,))
    for theta, (mass, stickiness) in itertools.product(PATHS, sticky.NUMBERS):

        def move(theta: Any = theta, mass: float = mass, stickiness: float = stickiness) -> Any:
            walk = sticky.walk_at(table, theta, mass, stickiness)
            walk._draw_tables(sticky.WEIGHTS)
            cells = [(int(j), int(g)) for j, g in np.argwhere(walk.tables)]
            return tuple((j, g, int(walk.tables[j, g]), int(walk.own[g]) if j == g else 0) for j, g in cells)

        wanted: dict[Any, float] = {}
        seatings = hdp.seatings(hdp.walk_rows(theta, (0,)), theta, mass * (1 - stickiness), mass * stickiness)
        for cells, shared, weight in seatings:
            key = tuple(sorted((3 if r == hdp.FIRST else r, g, m, w) for (r, g), (m, w) in cells.items()))
            wanted[key] = weight * math.prod(sticky.WEIGHTS[g] ** m for g, m in shared.items())
        yield "StickyHMM", "tables given the path", LAW, gap(replay.outcomes(sticky.loops, move), normalised(wanted))


def of_whole_candidates() -> Iterator[Row]:
    """A candidate in use moves with all its steps, β and rows integrated out."""
    for name, columns, length in CANDIDATES:
        dense, prior = sticky.ALL[name][:length, :columns], prior_of(columns)
        table = sticky.with_trajectories(dense, (0,), prior, edges=(1,))
        law: dict[Any, float] = {}
        for theta in itertools.product(range(columns), repeat=length):
            for _, shared, weight in hdp.seatings(hdp.walk_rows(theta, (0,)), theta, 0.8, 1.2):
                key = theta, tuple(shared[g] for g in range(columns))
                drawn = hdp.drawn_from_shared(shared, sticky.GAMMA, prior)
                law[key] = law.get(key, 0.0) + float(weight * drawn * sticky.fit(dense, theta))

        def move(state: Any, table: Any = table) -> Any:
            walk = sticky.walk_at(table, state[0], counts=state[1])
            walk._move_clusters()
            return tuple(walk.theta.tolist()), tuple(walk.shared.tolist())

        states, pi = five.vector(normalised(law))
        yield "StickyHMM", "whole candidates", INVARIANT, drift(pi, matrix(states, sticky.loops, move))


def of_sites_of_groups() -> Iterator[Row]:
    """All observations in turn, each given the others of its group, the group's weights integrated out."""
    for name in ("generic", "barred"):
        dense = grouped.ALL[name]
        table = grouped.with_trajectories(dense, grouped.STARTS, edges=(2,))
        rows = hdp.group_rows(grouped.OWN)
        law = {
            theta: hdp.chain_rule(rows, theta, grouped.MASS, 0.0, grouped.WEIGHTS) * grouped.fit(dense, theta)
            for theta in itertools.product(range(3), repeat=4)
        }

        def move(theta: Any, table: Any = table) -> Any:
            drawn = grouped.at(table, theta)
            drawn._redraw(grouped.WEIGHTS)
            return tuple(drawn.theta.tolist())

        states, pi = five.vector(normalised(law))
        yield "Grouped", "observations given β", INVARIANT, drift(pi, matrix(states, grouped.loops, move))


def of_seats() -> Iterator[Row]:
    """Seats in the restaurants of each group and candidate."""
    table = grouped.with_trajectories(tables.TABLES["generic"], grouped.STARTS)
    for theta in OF_GROUPS:

        def move(theta: Any = theta) -> Any:
            return tuple(grouped.at(table, theta)._seat(grouped.WEIGHTS)[0].tolist())

        wanted = seats_of(list(zip(grouped.OWN, theta, strict=True)))
        yield "Grouped", "seats given the candidates", LAW, gap(replay.outcomes(grouped.module, move), wanted)


def seats_of(pairs: Sequence[tuple[int, int]]) -> dict[Any, float]:
    """The law of who sits together, for observations of these groups and candidates."""
    wanted: dict[Any, float] = {}
    for labels in partitions.set_partitions(len(pairs)):
        members = partitions.blocks(labels)
        if any(len({pairs[i] for i in block}) > 1 for block in members):
            continue
        value = 1.0
        for pair, count in Counter(pairs).items():
            sizes = [len(block) for block in members if pairs[block[0]] == pair]
            alpha = grouped.MASS * grouped.WEIGHTS[pair[1]]
            value *= alpha ** len(sizes) * math.prod(math.factorial(size - 1) for size in sizes)
            value /= hdp.rising(alpha, count)
        wanted[labels] = value
    return wanted


def of_tables_of_groups() -> Iterator[Row]:
    """Given the seating, tables move as observations of the mixture do, β integrated out."""
    dense, prior = tables.TABLES["generic"][:, :2], prior_of(2)
    table = grouped.with_trajectories(dense, grouped.STARTS, prior, edges=(1,))
    for seats, (way, entries) in itertools.product(SEATED, WAYS.items()):
        law = {
            dishes: partitions.urn_probability(dishes, grouped.ETA, prior)
            * grouped.fit(dense, [dishes[t] for t in seats])
            for dishes in itertools.product(range(2), repeat=3)
        }

        def move(dishes: Any, seats: Any = seats) -> Any:
            drawn = grouped.at(table, [dishes[t] for t in seats])
            drawn._move_tables(np.array(seats), 3)
            return tuple(int(drawn.theta[seats.index(t)]) for t in range(3))

        yield "Grouped", f"candidates of tables, {way}", INVARIANT, moved_apart(law, move, entries)


def moved_apart(law: dict[Any, float], move: Callable[[Any], Any], entries: int) -> float:
    """How far one sweep over sets of observations leads away; ``entries`` decides how they are moved."""
    states, pi = five.vector(normalised(law))
    with patch.multiple(together, ENTRIES=entries, SWEEPS=1):
        return drift(pi, matrix(states, blocks, move))


def prior_of(columns: int) -> Floats:
    """The committed prior of the first candidates."""
    return np.asarray(tables.PRIOR[:columns] / tables.PRIOR[:columns].sum())
