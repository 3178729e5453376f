"""How right the samplers are: exact transition matrices of the shipped moves, and ranks of the truth.

The moves' Python form is run once for every outcome of every draw, on the committed tables of the tests and by their
means. A right move leaves the posterior where it is, up to rounding; the thesis's printed forms settle elsewhere. The
picture has the ranks of the truth among posterior draws for a right sampler and for Algorithm 4 as printed: flat is
right. ``correctness.md`` has both tables.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binom

from experiments.common import GREY, PALETTE, Headline, Options, run, save, sheet
from experiments.correctness_models import STEPS, in_time_and_groups
from experiments.correctness_moves import Row, alg4, exchangeable, five, replay, tables
from subgoal import samplers
from subgoal.runtime.checks import Ints

SIMULATIONS, QUICK_SIMULATIONS = 1_000, 96
BINS, RANKS = 16, 128
CONCENTRATIONS, QUICK_CONCENTRATIONS = (0.05, 1.0, 5.0), (1.0,)
QUICK_TABLES, QUICK_STEPS = 1, 3
"""Tables on which the printed forms are run to where they settle; steps of the paths whose runs are moved."""
PRINTED = {
    "alg4_literal_fresh_draw": ("line 14, a fresh subgoal for singletons", False, True),
    "alg4_literal_sum": ("(4.12), a sum over observations", True, False),
    "alg4_literal": ("both", False, False),
}
"""What is as printed; whether singletons keep their subgoal; whether likelihoods are multiplied."""
SHOWN = {"log joint": 0, "candidates in use": 2}
VIOLATION = 0.02
"""Total variation from the posterior below which a printed form hardly shows."""

calibration: Any = import_module("tests.statistical.test_calibration")

BAR = r"\|"


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The two tables, and ranks under two samplers."""
    etas = QUICK_CONCENTRATIONS if options.quick else CONCENTRATIONS
    shown = list(tables.TABLES)[: QUICK_TABLES if options.quick else None]
    moves = gathered([*exchangeable(etas), *in_time_and_groups(QUICK_STEPS if options.quick else STEPS)])
    printed = [row for name in shown for eta in etas for row in of_printed(name, eta)]
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
                   for name in shown} for form in PRINTED
        },
        "hardly_wrong": [row for row in printed if row["total_variation"] < VIOLATION],
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


def of_printed(name: str, eta: float) -> Iterator[Headline]:
    """Where the printed forms settle."""
    table = tables.TABLES[name]
    states, pi = five.vector(tables.table_posterior(table, eta, tables.PRIOR))
    for form, (what, keeps, product) in PRINTED.items():
        reached = replay.stationary(alg4.sweep_matrix(states, table, eta, keeps, product))
        distance = float(np.abs(reached - pi).sum() / 2)
        yield {"sampler": form, "printed": what, "table": name, "eta": eta, "total_variation": distance}


def words(moves: list[Headline], printed: list[Headline]) -> str:
    """Both tables in Markdown."""
    lines = ["| sampler | move | measured | largest | matrices |", "|---|---|---|---|---|"]
    for r in moves:
        measured, largest = r["measured"].replace("|", BAR), small(r["largest"])
        lines.append(f"| `{r['sampler']}` | {r['move']} | {measured} | {largest} | {r['matrices']} |")
    heads = list(dict.fromkeys(f"{row['table']}, η = {row['eta']:g}" for row in printed))
    lines += ["", f"| sampler | as printed | {' | '.join(heads)} |", "|---|---|" + "---|" * len(heads)]
    for form, (what, _, _) in PRINTED.items():
        values = [f"{row['total_variation']:.3f}" for row in printed if row["sampler"] == form]
        lines.append(f"| `{form}` | {what} | {' | '.join(values)} |")
    return "\n".join(lines) + "\n"


def small(value: float) -> str:
    """One digit and its power of ten."""
    return f"{value:.0e}" if value else "0"


def picture(ranks: dict[str, Ints]) -> Figure:
    """Histograms of ranks over 16 bins, with the band that 99 % of the bins of a right sampler fall in."""
    figure = sheet(9, 5.6)
    figure.suptitle("Rank of the truth among 127 posterior draws: flat for a right sampler")
    panels: Any = figure.subplots(len(ranks), len(SHOWN), sharex=True, squeeze=False)
    for row, (name, found) in zip(panels, ranks.items(), strict=True):
        low, high = (float(binom.ppf(level, len(found), 1 / BINS)) for level in (0.005, 0.995))
        for axis, (what, column) in zip(row, SHOWN.items(), strict=True):
            seen = np.bincount(found[:, column] * BINS // RANKS, minlength=BINS)
            tint, told = (PALETTE[1], "as printed: wrong") if "literal" in name else (PALETTE[0], "right")
            axis.axhspan(low, high, color=GREY, alpha=0.35, lw=0)
            axis.bar(np.arange(BINS) * 8 + 3.5, seen, width=7.2, color=tint)
            axis.set_title(f"{name} ({told}), {what}")
            axis.grid(axis="x", visible=False)
        row[0].set_ylabel("simulations")
    for axis in panels[-1]:
        axis.set_xlabel("rank, 0 to 127 (grey: 99 % of the bars of a right sampler)")
    return figure


if __name__ == "__main__":
    run("correctness", experiment)
