"""Table 4.1: what BNIRL and its rivals cost on the example of figure 4-2, and the two cases that close thesis 4.7.4.

Seconds are of this machine and of compiled code; what can be compared with the thesis are ratios to BNIRL's, and how
many plans (policies solved for, O(MDP)) each needs. Start and iteration are told apart by timing searches of two
lengths; the start of the rivals has their first iteration in it. Iterations to converge are those until the mean loss
over the runs is at its minimum: of the best policy so far for the two searches, of the current draw for the two
samplers. Bayesian IRL is timed twice: with a plan solved for at each step, as its authors and the thesis have it, and
with the library's low-rank updates, which give the same chain.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.costs_picture import picture
from experiments.extreme_cases import extreme_cases
from experiments.fig_4_2 import CHOSEN_CONFIDENCE
from experiments.grid_worlds import CONFIDENCE, loss_by_sweep, posterior_of, sweeps_to_minimum
from experiments.linear_world import Shown, shown
from experiments.rivals import ABBEEL, BAYESIAN, DEVIATION, MARGIN, REGULARISER, STEP, curve, losses_of, searched
from subgoal.candidates import visited
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.bayesian import anneal_reward
from subgoal.irl.expectations import optimal_policy
from subgoal.irl.max_margin import max_margin_planning
from subgoal.irl.reward_priors import Gaussian
from subgoal.irl.single_reward import SingleReward
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.runtime.checks import Floats

RUNS, QUICK_RUNS = 25, 2
BNIRL, UPDATED = "BNIRL", "Bayesian IRL, low-rank updates"
THESIS = {
    BNIRL: (15.3, 0.21, 10, 17.4), ABBEEL: (0.42, 1.65, 10, 16.9), MARGIN: (0.41, 1.16, 20, 23.6),
    BAYESIAN: (0.56, 3.27, 105, 344.0),
}  # fmt: skip
"""Seconds to start, seconds per iteration, iterations to converge, seconds in all."""
COLUMNS = ("start", "iteration", "iterations", "total")
SHORT, LONG, STEPS = 50, 550, 400
"""Sweeps or steps of the two chains that are timed, and steps of Bayesian IRL's chain."""
Measured = tuple[float, float, Floats, int]
"""Seconds to start and per iteration, loss by iteration, and plans that the whole search solved for (or before it)."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Costs of all methods in all runs, and the closing cases."""
    count = QUICK_RUNS if options.quick else RUNS
    cases = [shown(options.seed + k) for k in range(count)]
    for measure in METHODS.values():
        measure(cases[0], options.seed, True)
    rows = [
        row_of(name, [measure(case, options.seed + k, options.quick) for k, case in enumerate(cases)])
        for name, measure in METHODS.items()
    ]
    headline = {
        "runs": count,
        "rows": with_ratios(rows),
        "confidence": {BNIRL: CHOSEN_CONFIDENCE, BAYESIAN: CONFIDENCE},
        "closing_cases": extreme_cases(options.seed, quick=options.quick),
    }
    return headline, picture(headline)


def row_of(name: str, measured: list[Measured]) -> Headline:
    """Means over the runs; plans to convergence are those before the first iteration, and one for each after it."""
    start, each = (float(np.mean([m[k] for m in measured])) for k in (0, 1))
    iterations = sweeps_to_minimum(np.stack([m[2] for m in measured]))
    whole = float(np.mean([m[3] for m in measured]))
    left = iterations if name == BNIRL else iterations - 1
    return {
        "method": name, "start": start, "iteration": each, "iterations": iterations, "total": start + left * each,
        "plans": whole if name in (BNIRL, UPDATED) else float(iterations), "plans_of_the_whole_search": whole,
    }  # fmt: skip


def with_ratios(rows: list[Headline]) -> list[Headline]:
    """Each column over that of BNIRL, here and in the thesis."""
    first = rows[0]
    for row in rows:
        row["over_bnirl"] = {column: row[column] / first[column] for column in COLUMNS}
        told = THESIS.get(row["method"])
        row["thesis"] = dict(zip(COLUMNS, told, strict=True)) if told else None
        row["thesis_over_bnirl"] = (
            {c: t / b for c, t, b in zip(COLUMNS, told, THESIS[BNIRL], strict=True)} if told else None
        )
    return rows


def timed(make: Callable[[], Any]) -> tuple[float, Any]:
    """Seconds, and what was made."""
    begin = time.perf_counter()
    made = make()
    return time.perf_counter() - begin, made


def bnirl(case: Shown, seed: int, quick: bool) -> Measured:
    """Start: plans for all candidates. Iteration: a sweep of one chain."""
    start, likelihood = timed(partial(
        planned_actions, case.demonstrations, visited(case.demonstrations), case.grid.mdp, confidence=CHOSEN_CONFIDENCE
    ))  # fmt: skip
    chain: Any = {"chains": 1, "warmup": 0, "thin": 1}
    short, long = (timed(partial(posterior_of, likelihood, seed, draws=n, **chain))[0] for n in (SHORT, LONG))
    losses = loss_by_sweep(likelihood, seed)
    return start, max(long - short, 0.0) / (LONG - SHORT), losses, likelihood.n_candidates


def _search(learn: Callable[..., SingleReward]) -> Callable[[Shown, int, bool], Measured]:
    """Start: a search of one iteration. Iteration: the rest of the whole search, over its length."""

    def measure(case: Shown, seed: int, quick: bool) -> Measured:
        given = (case.demonstrations, case.grid.mdp, case.features)
        short, _ = timed(lambda: learn(*given, most_iterations=1))
        long, found = timed(lambda: learn(*given))
        each = (long - short) / (found.iterations - 1) if found.iterations > 1 else short
        learned = searched(found, case.demonstrations, case.grid.mdp)
        return short, each, curve(learned, STEPS, so_far=True), found.solutions

    return measure


def abbeel(*given: Any, **settings: Any) -> SingleReward:
    """As in figure 4-2."""
    return apprenticeship(*given, **settings)


def margin(*given: Any, **settings: Any) -> SingleReward:
    """As in figure 4-2."""
    return max_margin_planning(*given, regulariser=REGULARISER, **settings)


def chain_of(case: Shown, seed: int, steps: int) -> SingleReward:
    """PolicyWalk over the weights of the features."""
    return anneal_reward(
        case.demonstrations, case.grid.mdp, case.features, prior=Gaussian(DEVIATION), confidence=CONFIDENCE,
        step=STEP * DEVIATION, schedule=np.ones_like, steps=steps, seed=seed,
    )  # fmt: skip


def updated(case: Shown, seed: int, quick: bool) -> Measured:
    """Start: the inverse and a chain of one step. Iteration: a step with low-rank updates."""
    start, _ = timed(lambda: chain_of(case, seed, 1))
    seconds, chain = timed(lambda: chain_of(case, seed, 60 if quick else STEPS))
    losses = _held(losses_of(chain.trace, case.demonstrations, case.grid.mdp)[0])
    return start, max(seconds - start, 0.0) / (chain.iterations - 1), losses, 0


def replanned(case: Shown, seed: int, quick: bool) -> Measured:
    """Start: one plan. Iteration: a plan for the reward of the step, solved from nothing."""
    steps = 60 if quick else STEPS
    chain = chain_of(case, seed, steps)
    some = chain.trace[:: max(steps // 20, 1)]
    start, _ = timed(lambda: optimal_policy(case.grid.mdp, chain.trace[0]))
    seconds, _ = timed(lambda: [optimal_policy(case.grid.mdp, reward) for reward in some])
    losses = _held(losses_of(chain.trace, case.demonstrations, case.grid.mdp)[0])
    return start, seconds / len(some), losses, steps + 1


def _held(losses: Floats) -> Floats:
    return np.append(losses, np.full(STEPS - losses.size, losses[-1]))


METHODS: dict[str, Callable[[Shown, int, bool], Measured]] = {
    BNIRL: bnirl,
    ABBEEL: _search(abbeel),
    MARGIN: _search(margin),
    BAYESIAN: replanned,
    UPDATED: updated,
}

if __name__ == "__main__":
    run("table_4_1", experiment)
