"""Exact transition matrices of the exchangeable samplers: the worst that each move does to the posterior."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np

from subgoal import samplers
from subgoal.runtime.checks import Floats

REVERSIBLE, INVARIANT, LAW = "|π_i P_ij − π_j P_ji|", "|πP − π|₁", "|law − stated law|"
Row = tuple[str, str, str, float]
"""Sampler, move, what was measured, and how large it was."""

tables: Any = import_module("tests.oracles.tables")
laws: Any = import_module("tests.exact.laws")
replay: Any = import_module("tests.exact.replay")
steps: Any = import_module("tests.exact.test_compiled_steps")
five: Any = import_module("tests.exact.test_transition_samplers")
alg4: Any = import_module("tests.exact.test_transition_alg4")
blocks: Any = import_module("tests.exact.test_transition_collapsed_blocks")


def exchangeable(etas: tuple[float, ...]) -> Iterator[Row]:
    """Every move of every sampler of the exchangeable model."""
    yield from of_alg4(etas)
    yield from of_blocks(etas)
    yield from of_lots()
    yield from of_the_others(etas)
    yield from of_whole_sweeps()
    yield from of_levels()
    yield from of_weights()


def of_alg4(etas: tuple[float, ...]) -> Iterator[Row]:
    """Sites and dishes on pairs of a partition and its subgoals; whole sweeps."""
    for table in tables.TABLES.values():
        for eta in etas:
            states, pi = five.vector(tables.table_posterior(table, eta, tables.PRIOR))
            sweep = np.eye(len(states))
            for i in range(len(table)):
                step = matrix(states, alg4.loops, lambda s, i=i, t=table, e=eta: alg4.move_site(i, s, t, e, True))
                yield "alg4_corrected", "one observation", REVERSIBLE, five.imbalance(pi, step)
                sweep = sweep @ step
            step = matrix(states, alg4.loops, lambda s, t=table: alg4.move_dishes(s, t, True))
            yield "alg4_corrected", "subgoals of all tables", REVERSIBLE, five.imbalance(pi, step)
            yield "alg4_corrected", "whole sweep", INVARIANT, drift(pi, sweep @ step)


def of_blocks(etas: tuple[float, ...]) -> Iterator[Row]:
    """Moves of whole clusters."""
    for table in tables.TABLES.values():
        for eta in etas:
            states, pi = five.vector(tables.assignment_posterior(table, eta, tables.PRIOR))
            step = matrix(states, blocks.loops, lambda s, t=table, e=eta: blocks.move_all_blocks(s, t, tables.PRIOR, e))
            yield "collapsed_blocks", "candidates of all clusters", INVARIANT, drift(pi, step)


def of_the_others(etas: tuple[float, ...]) -> Iterator[Row]:
    """Sites of ``collapsed`` (also those of ``collapsed_blocks``), sites of clusters, splits and merges; swaps."""
    for table in laws.WITH_WALLS.values():
        for eta in etas:
            states, pi = five.vector(tables.assignment_posterior(table, eta, tables.PRIOR))
            for i in range(len(table)):
                step = matrix(states, five.collapsed, lambda s, i=i, t=table, e=eta: five.move_redraw(i, s, t, e))
                yield "collapsed, collapsed_blocks", "one observation", REVERSIBLE, five.imbalance(pi, step)
            states, pi = five.vector(laws.partition_posterior(table, eta, tables.PRIOR))
            for i in range(len(table)):
                step = matrix(
                    states, five.cluster_collapsed,
                    lambda s, i=i, t=table, e=eta: five.Clusters(s, t).rows(i, i + 1, t, e),
                )  # fmt: skip
                yield "cluster_collapsed", "one observation", REVERSIBLE, five.imbalance(pi, step)
            step = matrix(states, five.split_merge, lambda s, t=table, e=eta: five.move_pair(s, t, e))
            yield "split_merge", "split or merge", REVERSIBLE, five.imbalance(pi, step)


def of_whole_sweeps() -> Iterator[Row]:
    """Shipped sweeps of three observations and two candidates; of two observations for ``split_merge``."""
    eta, prior = 1.3, steps.SMALL_PRIOR
    for table in laws.WITH_WALLS.values():
        for sampler, rows in ((samplers.collapsed, 3), (samplers.split_merge, 2)):
            small = table[:rows, :2]
            states, pi = five.vector(tables.assignment_posterior(small, eta, prior))
            likelihood = steps.likelihood_of(small, prior)
            step = replay.matrix(states, lambda s, a=sampler, t=likelihood: laws.sweep_law(a, s, t, eta))
            yield sampler.__name__, "whole sweep", INVARIANT, drift(pi, step)
    for table in tables.TABLES.values():
        small = table[:3, :2]
        states, pi = five.vector(tables.assignment_posterior(small, eta, prior))
        step = matrix(states, blocks.loops, lambda s, t=small: blocks.sweep(s, t, prior, eta))
        yield "collapsed_blocks", "whole sweep", INVARIANT, drift(pi, step)


def of_levels() -> Iterator[Row]:
    """``tempered``: a sweep of each level for its own law, and exchanges of two neighbours of three."""
    eta, prior, powers = 1.3, steps.SMALL_PRIOR, five.POWERS
    for table in laws.WITH_WALLS.values():
        small = table[:3, :2]
        likelihood = steps.likelihood_of(small, prior)
        scaled, ratios = five.levels_of(likelihood, likelihood.dense, likelihood.relative, powers)
        levels = [five.vector(tables.assignment_posterior(beta * small, eta, prior)) for beta in powers]
        for level, (states, pi) in enumerate(levels):

            def advance(theta: Any, given: Any = (scaled[level], ratios[level], likelihood.edges)) -> Any:
                drawn = np.array(theta, np.int32)
                five.tempered.advance(*given, prior, np.log(prior), eta, drawn, np.zeros((1, 2)), None)
                return tuple(drawn.tolist())

            step = matrix(states, five.tempered, advance)
            yield "tempered", "sweep of one level", INVARIANT, drift(pi, step)
        together = list(itertools.product(levels[0][0], repeat=3))
        place = {theta: k for k, theta in enumerate(levels[0][0])}
        joint = np.array([np.prod([levels[a][1][place[theta]] for a, theta in enumerate(s)]) for s in together])
        for a in (0, 1):
            step = matrix(together, five.tempered, lambda s, a=a, t=small: exchanged(a, s, t, powers))
            yield "tempered", "exchange of two levels", REVERSIBLE, five.imbalance(joint, step)


def exchanged(a: int, state: Any, table: Floats, powers: Any) -> Any:
    """Levels after the exchange of levels a and a + 1 was tried."""
    theta = np.array(state, np.int32)
    fits = np.array([table[np.arange(len(table)), level].sum() for level in theta])
    five.tempered.swap(a, np.array(powers), fits, theta, np.zeros(2), None)
    return tuple(tuple(level) for level in theta.tolist())


def of_weights() -> Iterator[Row]:
    """``blocked``: observations given the weights of the candidates, each on its own."""
    loops, prior = five.blocked, tables.PRIOR
    for table in laws.WITH_WALLS.values():
        for weights in five.WEIGHTS.values():
            log_weights, reach, in_order, tail = np.array(weights), np.zeros(3), np.zeros(3), np.zeros(4)
            order = np.zeros(3, np.int64)
            loops.by_reach(log_weights, prior, reach, order, in_order, tail)

            def move(table: Any = table, given: Any = (log_weights, order, in_order, tail)) -> Any:
                theta = np.zeros(4, np.int32)
                loops.assign_rows(0, table, five.relative_of(table, prior), *given, theta, np.zeros(3), 0.0, None)
                return tuple(theta.tolist())

            each = table + log_weights
            each = np.exp(each - each.max(axis=1, keepdims=True))
            each /= each.sum(axis=1, keepdims=True)
            wanted = {s: float(each[np.arange(4), s].prod()) for s in itertools.product(range(3), repeat=4)}
            yield "blocked", "observations given weights", LAW, gap(replay.outcomes(loops, move), wanted)


def of_lots() -> Iterator[Row]:
    """Whether clusters move in a sweep of ``collapsed_blocks``: in one of four, by lot."""
    found = replay.outcomes(blocks.loops, lambda: bool(blocks.loops.clusters_move(np.zeros(2), None)))
    yield "collapsed_blocks", "whether clusters move in a sweep", LAW, gap(found, {True: 0.25, False: 0.75})


def matrix(states: Any, loops: Any, move: Any) -> Floats:
    """(S, S) by replay of the draws of one module."""
    return np.asarray(replay.matrix(states, lambda s: replay.outcomes(loops, lambda: move(s))))


def drift(pi: Floats, step: Floats) -> float:
    """How far one step leads away from π."""
    return float(np.abs(pi @ step - pi).sum())


def gap(found: dict[Any, float], wanted: dict[Any, float]) -> float:
    """Largest difference of two laws in any state."""
    return float(np.max([abs(found.get(state, 0.0) - wanted.get(state, 0.0)) for state in {**found, **wanted}]))


def normalised(law: dict[Any, float]) -> dict[Any, float]:
    """The law that is proportional to it."""
    total = sum(law.values())
    return {state: float(value / total) for state, value in law.items()}
