"""Figure 5-3: what learning costs and how well it fits, from a hundred states to a thousand million (thesis 5.2.1).

From a world and a demonstration to learned subgoals, planning and sampling (or Abbeel and Ng's search) together.
Demonstrations go from one random cell to another, so far at most that actions still differ in the likelihood.
Candidates are the states on the way. Every planner is asked for the same: no log probability wrong by more than 0.01
nats. Seconds are of the processor for what runs in one thread, and by the clock for what runs in two (``load`` is that
of the machine, which others may use). In large worlds plain value iteration is timed on a few candidates and scaled up
to all of them; its loss is not known there.
"""

from __future__ import annotations

import os
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.large_grids import CONFIDENCE, FARTHEST, FLAT, Case, draw
from experiments.large_methods import (
    ABBEEL,
    ABBEEL_RTDP,
    EXACT,
    METHODS,
    MOST_STATES,
    PARALLEL,
    RTDP,
    SAMPLING,
    SWEEPS,
    TOLERANCE,
    Measured,
)
from experiments.large_picture import picture

DRAWS: dict[str, dict[int, int]] = {
    SWEEPS: {2: 30, 3: 30, 4: 3, 5: 2, 6: 1},
    EXACT: {2: 30, 3: 30, 4: 30, 5: 5, 6: 2},
    RTDP: {2: 30, 3: 30, 4: 30, 5: 5, 6: 3, 7: 3, 8: 3, 9: 3},
    PARALLEL: {2: 30, 3: 30, 4: 30, 5: 5, 6: 3, 7: 3, 8: 3, 9: 3},
    ABBEEL: {2: 30, 3: 30, 4: 3},
    ABBEEL_RTDP: {2: 30, 3: 30, 4: 3, 5: 2, 6: 1, 7: 1, 8: 1, 9: 1},
}
"""Draws by method and power of ten: the first of the same draws for all methods."""
QUICK: dict[str, dict[int, int]] = {
    SWEEPS: {3: 2}, EXACT: {3: 2}, RTDP: {3: 2, 6: 1}, PARALLEL: {3: 2, 6: 1}, ABBEEL: {3: 2}, ABBEEL_RTDP: {3: 2},
}  # fmt: skip
SCALED = {5: 3, 6: 1}
"""Candidates that plain value iteration is timed on, where not on all."""
QUICK_CANDIDATES = {6: 20}
LEAST_RATIO = 10.0


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every method on its draws, size by size."""
    draws = QUICK if options.quick else DRAWS
    few = QUICK_CANDIDATES if options.quick else {}
    warm_up(options.seed)
    rows = []
    for power in sorted({power for counts in draws.values() for power in counts}):
        count = max(counts.get(power, 0) for counts in draws.values())
        cases = [draw(power, options.seed * 1000 + k) for k in range(count)]
        for name, counts in draws.items():
            if power in counts:
                most = (SCALED if name == SWEEPS else few).get(power)
                rows.append(row_of(name, power, [METHODS[name](case, most) for case in cases[: counts[power]]], cases))
    headline: Headline = {
        "rows": rows,
        "load": os.getloadavg()[0],
        "confidence": CONFIDENCE,
        "tolerance_of_an_action_value": TOLERANCE,
        "sampling": SAMPLING,
        "farthest_goal_in_cells": FARTHEST,
        "nats_beyond": FLAT,
        "states_of_an_envelope_at_most, Abbeel-Ng": MOST_STATES,
        "value_iteration_over_rtdp": ratios(rows, SWEEPS),
        "one_thread_over_two_by_the_clock": by_the_clock(rows),
        "first_passage_over_rtdp": ratios(rows, EXACT),
        "crossover_with_first_passage_in_states": crossover(rows),
    }
    wanted = [ratio for states, ratio in headline["value_iteration_over_rtdp"] if states >= 9_000]
    headline["met"] = bool(wanted) and min(wanted) >= LEAST_RATIO
    return headline, picture(headline)


def warm_up(seed: int) -> None:
    """Compiled loops are compiled before they are timed."""
    case = draw(2, seed)
    for method in METHODS.values():
        method(case, None)


def row_of(name: str, power: int, measured: list[Measured], cases: list[Case]) -> Headline:
    """Means over the draws; the largest of the gaps; seconds of each draw beside them."""
    seen = cases[: len(measured)]

    def every(field: str) -> list[Any]:
        return [getattr(each, field) for each in measured]

    return {
        "cells": 10**power,
        "states": float(np.mean([case.n_states for case in seen])),
        "method": name,
        "seconds": float(np.mean(every("seconds"))),
        "planning_seconds": mean(every("planning_seconds")),
        "wall_seconds": float(np.mean(every("wall_seconds"))),
        "loss": mean(every("loss")),
        "loss_of_the_middle": mean(every("loss_of_the_middle")),
        "gap": largest(every("gap")),
        "value_bound": largest(every("value_bound")),
        "states_inside": largest(every("inside")),
        "budget_reached": sum(every("budget_reached")),
        "draws": len(measured),
        "pairs": float(np.mean([len(case.actions) for case in seen])),
        "candidates": float(np.mean(every("candidates"))),
        "scaled_from_candidates": largest(every("scaled_from")),
        "seconds_of_each": every("seconds"),
    }


def mean(values: list[Any]) -> float | None:
    """None where any is not known."""
    return None if None in values else float(np.mean(values))


def largest(values: list[Any]) -> Any:
    """None where any is not known."""
    return None if None in values else max(values)


def ratios(rows: list[Headline], slower: str) -> list[tuple[float, float]]:
    """(states, seconds of a method over those of RTDP) by size, over the draws that both have."""
    found = []
    for row in rows:
        same = [other for other in rows if other["method"] == RTDP and other["cells"] == row["cells"]]
        if row["method"] == slower and same:
            count = min(row["draws"], same[0]["draws"])
            ratio = sum(row["seconds_of_each"][:count]) / sum(same[0]["seconds_of_each"][:count])
            found.append((row["states"], ratio))
    return found


def by_the_clock(rows: list[Headline]) -> list[tuple[float, float]]:
    """(states, wall seconds of RTDP in one thread over those in two) by size."""
    wall = {(row["method"], row["cells"]): row["wall_seconds"] for row in rows}
    return [
        (row["states"], row["wall_seconds"] / wall[PARALLEL, row["cells"]]) for row in rows if row["method"] == RTDP
    ]


def crossover(rows: list[Headline]) -> float | None:
    """States from which RTDP is faster than first passage on the whole world, between two sizes by a power law."""
    told = ratios(rows, EXACT)
    for (few, low), (many, high) in pairwise(told):
        if low <= 1 < high:
            share = -np.log(low) / (np.log(high) - np.log(low))
            return float(np.exp(np.log(few) + share * (np.log(many) - np.log(few))))
    return None


if __name__ == "__main__":
    run("fig_5_3", experiment)
