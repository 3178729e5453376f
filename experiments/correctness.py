"""How right the samplers are: exact transition matrices of the shipped moves, and ranks of the truth.

The moves' Python form is run once for every outcome of every draw, on the committed tables of the tests and by their
means. A right move leaves the posterior where it is, up to rounding; the thesis's printed forms settle elsewhere. The
picture has the ranks of the truth among posterior draws for a right sampler and for Algorithm 4 as printed: flat is
right. ``correctness.md`` has both tables.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binom

from experiments.common import GREY, PALETTE, Headline, Options, run, save, sheet
from subgoal import samplers
from subgoal.runtime.checks import Floats, Ints

SIMULATIONS, QUICK_SIMULATIONS = 1_000, 96
BINS, RANKS = 16, 128
CONCENTRATIONS, QUICK_CONCENTRATIONS = (0.05, 1.0, 5.0), (1.0,)
PRINTED = {
    "alg4_literal_fresh_draw": ("line 14, a fresh subgoal for singletons", False, True),
    "alg4_literal_sum": ("(4.12), a sum over observations", True, False),
    "alg4_literal": ("both", False, False),
}
"""What is as printed; whether singletons keep their subgoal; whether likelihoods are multiplied."""
SHOWN = {"log joint": 0, "candidates in use": 2}
REVERSIBLE, INVARIANT, LAW = "|π_i P_ij − π_j P_ji|", "|πP − π|₁", "|law − stated law|"

tables: Any = import_module("tests.oracles.tables")
laws: Any = import_module("tests.exact.laws")
replay: Any = import_module("tests.exact.replay")
steps: Any = import_module("tests.exact.test_compiled_steps")
five: Any = import_module("tests.exact.test_transition_samplers")
alg4: Any = import_module("tests.exact.test_transition_alg4")
blocks: Any = import_module("tests.exact.test_transition_collapsed_blocks")
lasting: Any = import_module("tests.exact.test_transition_persistence")
calibration: Any = import_module("tests.statistical.test_calibration")

BAR = r"\|"
Row = tuple[str, str, str, float]
"""Sampler, move, what was measured, and how large it was."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The two tables, and ranks under two samplers."""
    etas = QUICK_CONCENTRATIONS if options.quick else CONCENTRATIONS
    moves = gathered(
        [
            *of_alg4(etas),
            *of_blocks(etas),
            *of_the_others(etas),
            *of_whole_sweeps(),
            *of_levels(),
            *of_weights(),
            *of_paths(),
        ]
    )
    printed = [row for name in tables.TABLES for eta in etas for row in of_printed(name, eta)]
    count = QUICK_SIMULATIONS if options.quick else SIMULATIONS
    ranks = {
        "collapsed_blocks": calibration.ranks(samplers.collapsed_blocks, count, options.seed + 1),
        "alg4_literal": calibration.ranks(samplers.alg4_literal, count, options.seed + 1),
    }
    headline = {
        "moves": moves,
        "largest_violation": max(row["largest"] for row in moves),
        "printed_forms": printed,
        "least_total_variation": {
            form: {name: min(r["total_variation"] for r in printed if (r["sampler"], r["table"]) == (form, name))
                   for name in tables.TABLES} for form in PRINTED
        },
        "simulations": count,
        "rank_p_values": {name: calibration.p_values(found) for name, found in ranks.items()},
    }  # fmt: skip
    save(options.out / "correctness.md", words(moves, printed).encode())
    return headline, picture(ranks)


def gathered(rows: list[Row]) -> list[Headline]:
    """The largest value of each move, over tables and concentrations."""
    worst: dict[tuple[str, str, str], list[float]] = {}
    for *what, value in rows:
        worst.setdefault((what[0], what[1], what[2]), []).append(value)
    return [
        {"sampler": sampler, "move": move, "measured": measured, "largest": max(values), "matrices": len(values)}
        for (sampler, move, measured), values in worst.items()
    ]  # fmt: skip


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
                step = replay.matrix(
                    states,
                    lambda s, i=i, t=table, e=eta: laws.replayed(
                        [five.collapsed, five.collapsed_blocks], lambda: five.move_redraw(i, s, t, e)
                    ),
                )
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
    modules = [five.tempered, five.collapsed_blocks]
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

            step = replay.matrix(states, lambda s, move=advance: laws.replayed(modules, lambda: move(s)))
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
            found = replay.outcomes(loops, move)
            every = itertools.product(range(3), repeat=4)
            gap = max(abs(found.get(theta, 0.0) - each[np.arange(4), theta].prod()) for theta in every)
            yield "blocked", "observations given weights", LAW, float(gap)


def of_paths() -> Iterator[Row]:
    """Persistent subgoals: the path given weights, drawn backward, against enumeration."""
    weights = np.array([0.2, 0.7, 0.1])
    for name in tables.TABLES:
        for keeps in lasting.KEEPS:
            table, model = lasting.temporal_table(name), lasting.Persistent(keep=keeps[0], keep_there=keeps[1])

            def move(table: Any = table, model: Any = model, keeps: Any = keeps) -> Any:
                drawn = lasting.steps_at(table, model, ((0, 0, 1, 2), (True, False, True, True)), *keeps)
                drawn._draw_path(weights)
                return tuple(drawn.theta.tolist()), tuple(bool(r) for r in drawn.redrawn)

            found = replay.outcomes(lasting.loops, move)
            wanted = lasting.given_weights(table.dense, lasting.STARTS, weights, *keeps, lasting.ARRIVED)
            gap = max(abs(found.get(state, 0.0) - p) for state, p in wanted.items())
            yield "Persistent", "path given weights", LAW, float(gap)


def of_printed(name: str, eta: float) -> Iterator[Headline]:
    """Where the printed forms settle."""
    table = tables.TABLES[name]
    states, pi = five.vector(tables.table_posterior(table, eta, tables.PRIOR))
    for form, (what, keeps, product) in PRINTED.items():
        reached = replay.stationary(alg4.sweep_matrix(states, table, eta, keeps, product))
        distance = float(np.abs(reached - pi).sum() / 2)
        yield {"sampler": form, "printed": what, "table": name, "eta": eta, "total_variation": distance}


def matrix(states: Any, loops: Any, move: Any) -> Floats:
    """(S, S) by replay of the draws of one module."""
    return np.asarray(replay.matrix(states, lambda s: replay.outcomes(loops, lambda: move(s))))


def drift(pi: Floats, step: Floats) -> float:
    """How far one step leads away from π."""
    return float(np.abs(pi @ step - pi).sum())


def words(moves: list[Headline], printed: list[Headline]) -> str:
    """Both tables in Markdown."""
    lines = ["| sampler | move | measured | largest | matrices |", "|---|---|---|---|---|"]
    lines += [
        f"| `{r['sampler']}` | {r['move']} | {r['measured'].replace('|', BAR)} | {r['largest']:.0e} | {r['matrices']} |"
        for r in moves
    ]
    etas = sorted({row["eta"] for row in printed})
    heads = [f"{name}, η = {eta:g}" for name in tables.TABLES for eta in etas]
    lines += ["", f"| sampler | as printed | {' | '.join(heads)} |", "|---|---|" + "---|" * len(heads)]
    for form, (what, _, _) in PRINTED.items():
        values = [f"{row['total_variation']:.3f}" for row in printed if row["sampler"] == form]
        lines.append(f"| `{form}` | {what} | {' | '.join(values)} |")
    return "\n".join(lines) + "\n"


def picture(ranks: dict[str, Ints]) -> Figure:
    """Histograms of ranks over 16 bins, with the band that 99 % of the bins of a right sampler fall in."""
    figure = sheet(9, 5.6)
    figure.suptitle("Rank of the truth among 127 posterior draws: flat is right")
    panels: Any = figure.subplots(len(ranks), len(SHOWN), sharex=True, squeeze=False)
    for row, (name, found) in zip(panels, ranks.items(), strict=True):
        low, high = (float(binom.ppf(level, len(found), 1 / BINS)) for level in (0.005, 0.995))
        for axis, (what, column) in zip(row, SHOWN.items(), strict=True):
            seen = np.bincount(found[:, column] * BINS // RANKS, minlength=BINS)
            tint = PALETTE[1] if "literal" in name else PALETTE[0]
            axis.axhspan(low, high, color=GREY, alpha=0.35, lw=0)
            axis.bar(np.arange(BINS) * 8 + 3.5, seen, width=7.2, color=tint)
            axis.set_title(f"{name}, {what}")
            axis.grid(axis="x", visible=False)
        row[0].set_ylabel("simulations")
    for axis in panels[-1]:
        axis.set_xlabel("rank, 0 to 127")
    return figure


if __name__ == "__main__":
    run("correctness", experiment)
