"""The study behind figures 4-1 and 4-3: known subgoals in a grid world, many runs, and what changes the answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.common import Headline
from experiments.grid_worlds import (
    CANDIDATES,
    Cell,
    Demonstrated,
    cell,
    demonstrate,
    held_out_loss,
    loss_by_sweep,
    on_top,
    posterior_of,
    share_of_labels_right,
    state,
    sweeps_to_minimum,
    table,
    world,
)
from subgoal.answers.scores import top_candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.grids.grid import GridWorld
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats
from subgoal.samplers import alg4_literal_sum, collapsed_blocks

RUNS, QUICK_RUNS = 25, 4
FIRST_LATER_LAYOUT = 100
"""Layouts from here on are for the row "other layouts": no choice was made with them in view."""
OWN, ONE, OTHER = "a layout of its own for each run", "one layout for all runs", "other layouts"


@dataclass(frozen=True)
class Setting:
    """Where a demonstrator begins, what it is after in turn, and how many times over."""

    start: Cell
    subgoals: tuple[Cell, ...]
    loops: int = 1


@dataclass(frozen=True, eq=False)
class Run:
    """One run: the world, what was shown, the likelihood, and what was learned."""

    grid: GridWorld
    shown: Demonstrated
    likelihood: LogLikelihood
    posterior: Posterior
    found: bool


def one_run(
    setting: Setting, layout: int, seed: int, *, stays: str = "every", candidates: str = "visited",
    sampler: Sampler = collapsed_blocks, quick: bool = False,
) -> Run:  # fmt: skip
    """Demonstrate, plan, sample; ``found`` is whether the true subgoals, and they alone, are on top."""
    grid = world(layout)
    shown = demonstrate(grid, setting.start, setting.subgoals, loops=setting.loops, stays=stays, seed=seed)
    places = CANDIDATES[candidates](shown.demonstrations, grid)
    likelihood = table(shown.demonstrations, grid, places)
    length = {"draws": 300, "warmup": 200, "thin": 2} if quick else {}
    posterior = posterior_of(likelihood, seed, sampler=sampler, **length)
    goals = [state(grid, goal) for goal in setting.subgoals]
    return Run(grid, shown, likelihood, posterior, on_top(posterior, goals))


def layout_of(kind: str, run: int) -> int:
    """Which layout a run of a row has."""
    return {OWN: run, ONE: 0, OTHER: FIRST_LATER_LAYOUT + run}[kind]


def study(setting: Setting, seed: int, quick: bool) -> tuple[Headline, list[Run], Floats]:
    """Main runs, their losses (R, sweeps), and the rows in which one thing is changed at a time."""
    count = QUICK_RUNS if quick else RUNS
    runs = [one_run(setting, layout_of(OWN, k), seed + k, quick=quick) for k in range(count)]
    losses = np.stack([loss_by_sweep(run.likelihood, seed + k) for k, run in enumerate(runs)])
    fresh = [
        demonstrate(run.grid, setting.start, setting.subgoals, loops=setting.loops, seed=seed + 500 + k).demonstrations
        for k, run in enumerate(runs)
    ]
    headline = {
        "runs": count,
        "runs_all_true_subgoals": sum(run.found for run in runs),
        "sweeps_to_minimum_loss": sweeps_to_minimum(losses),
        "final_loss": {"BNIRL": float(losses[:, -1].mean())},
        "held_out_loss": {
            "BNIRL": float(np.mean([held_out_loss(r.posterior, f) for r, f in zip(runs, fresh, strict=True)]))
        },
        "labels_right": float(
            np.mean([share_of_labels_right(r.likelihood, r.posterior, r.shown.served) for r in runs])
        ),
        "pairs": float(np.mean([run.shown.demonstrations.n_observations for run in runs])),
        "converged": sum(run.posterior.status.name == "CONVERGED" for run in runs),
        "subgoals": subgoal_list(runs[0], len(set(setting.subgoals)) + 2),
        "layouts": {kind: _row(setting, seed, count, kind, quick) for kind in (ONE, OTHER)},
        "stay_pairs": {"last only": _row(setting, seed, count, OWN, quick, stays="last")},
        "candidates": {
            name: _row(setting, seed, count, OWN, quick, candidates=name) for name in CANDIDATES if name != "visited"
        },
        "samplers": {"sum in (4.12), as printed": _row(setting, seed, count, OWN, True, sampler=alg4_literal_sum)},
    }
    return headline, runs, losses


def _row(setting: Setting, seed: int, count: int, kind: str, quick: bool, **changed: Any) -> Headline:
    runs = [one_run(setting, layout_of(kind, k), seed + k, quick=quick, **changed) for k in range(count)]
    return {"runs": count, "runs_all_true_subgoals": sum(run.found for run in runs)}


def subgoal_list(run: Run, count: int) -> list[Headline]:
    """Cells (counted from one) and shares of the largest candidates."""
    sets: Any = run.posterior.candidates.goal_sets
    shares = run.posterior.expected_shares
    return [
        {"cell": cell(run.grid, int(sets[g][0])), "share": float(shares[g])}
        for g in top_candidates(run.posterior, count)
        if shares[g] > 0
    ]


def true_cells(run: Run, goals: Sequence[Cell]) -> list[int]:
    """States of cells."""
    return [state(run.grid, goal) for goal in goals]
