"""The two cases that close thesis 4.7.4: few pairs and many subgoals; much data and one reward."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from experiments import fig_4_3
from experiments.common import Headline
from experiments.grid_worlds import cell, demonstrate, posterior_of, table, world
from experiments.linear_world import shown
from experiments.rivals import BAYESIAN, RIVALS, STEP, Lengths, bayesian, scaled_features, wrong
from subgoal.answers.scores import assignment_loss
from subgoal.candidates import visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.grid import GridWorld
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

RUNS, QUICK_RUNS = 5, 1
SUBGOALS, SWEEPS = 8, 100
WALKS, STEPS = 100, 50
QUICK_WALKS = 20
FEW, MUCH = "few pairs, many subgoals", "much data, one reward"
STEP_OF = {FEW: fig_4_3.STEP, MUCH: STEP}
PROPOSALS, QUICK_PROPOSALS = 400, 32


def extreme_cases(seed: int, *, quick: bool) -> dict[str, Headline]:
    """Pairs, and for each method plans, seconds and the share of pairs wrong in sample, means over the runs."""
    count = QUICK_RUNS if quick else RUNS
    walks = QUICK_WALKS if quick else WALKS
    much = [shown(seed + k, demonstrations=walks, steps=STEPS) for k in range(count)]
    given = {
        FEW: [few_pairs(seed + k) for k in range(count)],
        MUCH: [(case.grid, case.demonstrations, case.features) for case in much],
    }
    return {
        name: {
            "pairs": float(np.mean([demos.n_observations for _, demos, _ in cases])),
            "true_reward_wrong": float(np.mean([case.floor / case.demonstrations.n_observations for case in much]))
            if name == MUCH
            else None,
            "methods": _means([costs(*case, seed + k, quick, STEP_OF[name]) for k, case in enumerate(cases)]),
        }
        for name, cases in given.items()
    }


def few_pairs(seed: int) -> tuple[GridWorld, Demonstrations, Floats]:
    """One walk past eight random subgoals, and distances to each of them."""
    grid = world(seed)
    places = stream(seed, 43).choice(grid.n_states, SUBGOALS + 1, replace=False)
    cells = [cell(grid, int(place)) for place in places]
    walk = demonstrate(grid, cells[0], cells[1:], seed=seed).demonstrations
    return grid, walk, scaled_features(grid, [(x - 1, y - 1) for x, y in cells[1:]])


def costs(
    grid: GridWorld, demos: Demonstrations, features: Floats, seed: int, quick: bool, step: float
) -> dict[str, Headline]:
    """BNIRL for 100 sweeps of one chain; the searches to their own end; Bayesian IRL for 400 proposals."""
    begin = time.perf_counter()
    likelihood = table(demos, grid, visited(demos))
    posterior = posterior_of(likelihood, seed, chains=1, warmup=0, thin=1, draws=SWEEPS)
    seconds = time.perf_counter() - begin
    explained = assignment_loss(likelihood, posterior.best_assignment) / demos.n_observations
    made = {"BNIRL": {"plans": likelihood.n_candidates, "seconds": seconds, "wrong": explained}}
    proposals = QUICK_PROPOSALS if quick else PROPOSALS
    for name, rival in RIVALS.items():
        half = proposals // features.shape[1] // 2
        more: Any = {"step": step, "lengths": Lengths(1, half, half, 1)} if rival is bayesian else {}
        begin = time.perf_counter()
        found = rival(demos, grid.mdp, features, seed, **more)
        seconds = time.perf_counter() - begin
        plans = proposals if name == BAYESIAN else found.solutions
        made[name] = {"plans": plans, "seconds": seconds, "wrong": wrong(found.best, demos)}
    return made


def _means(runs: list[dict[str, Headline]]) -> dict[str, Headline]:
    return {
        name: {key: float(np.mean([each[name][key] for each in runs])) for key in ("plans", "seconds", "wrong")}
        for name in runs[0]
    }
