"""What figure 4-2 lets be chosen, on worlds of which it reports nothing else: by loss on fresh demonstrations.

The thesis gives neither the confidence of BNIRL nor the regulariser of maximum margin planning nor the prior of
Bayesian IRL, and does not say which of their policies it scores.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from experiments.common import Headline
from experiments.grid_worlds import held_out_loss, posterior_of
from experiments.linear_world import PAIRS, Shown, shown
from experiments.rivals import ABBEEL, BAYESIAN, MARGIN, Learned, Lengths, abbeel, abbeel_both, bayesian, margin, wrong
from subgoal.answers.predictions import predict_nearby
from subgoal.answers.scores import assignment_loss, zero_one_loss
from subgoal.candidates import visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.posterior.posterior import Posterior

FIRST, RUNS, QUICK_RUNS = 100, 12, 1
CONFIDENCES, REGULARISERS, DEVIATIONS = (10.0, 100.0, 1_000.0, 10_000.0), (0.1, 0.01, 0.001), (1.0, 3.0)
BNIRL, BOTH = "BNIRL", "both"
Scored = dict[str, tuple[float, float]]
"""Pairs wrong in sample and held out, by name of the policy."""


def tried(quick: bool) -> Headline:
    """For each method and setting: mean pairs wrong of 75 over the runs, in sample and held out, by policy scored."""
    cases = [shown(FIRST + k) for k in range(QUICK_RUNS if quick else RUNS)]
    rows: dict[str, list[Headline]] = {}
    for name, setting, score in _trials(quick):
        scores = [score(case, FIRST + k) for k, case in enumerate(cases)]
        for policy in scores[0]:
            means = np.mean([each[policy] for each in scores], axis=0)
            rows.setdefault(name, []).append({**setting, "policy": policy, "in_sample": means[0], "held_out": means[1]})
    return {"runs": len(cases), "rows": rows, "chosen": {name: least(table) for name, table in rows.items()}}


def nearby_loss(posterior: Posterior, demos: Demonstrations) -> float:
    """Share of pairs wrong that are predicted from the subgoals served nearby.

    Near certainty, a bandwidth tried for them may give some action no probability in floating point.
    """
    with np.errstate(divide="ignore"):
        return zero_one_loss(predict_nearby(posterior, demos.states), demos.actions)


def least(table: list[Headline]) -> Headline:
    """The row of least held-out loss, of equal ones that of least loss in sample."""
    return min(table, key=lambda row: (row["held_out"], row["in_sample"]))


def _trials(quick: bool) -> list[tuple[str, Headline, Callable[[Shown, int], Scored]]]:
    trials: list[Any] = [(BNIRL, {"confidence": c}, partial(_bnirl, confidence=c)) for c in CONFIDENCES]
    trials += [(ABBEEL, {"variant": v}, partial(_abbeel, variant=v)) for v in ("max_margin", "projection", BOTH)]
    trials += [(MARGIN, {"regulariser": r}, partial(_margin, regulariser=r)) for r in REGULARISERS]
    lengths = Lengths(1, 20, 10, 1) if quick else Lengths(1, 100, 50, 1)
    return trials + [(BAYESIAN, {"deviation": d}, partial(_bayesian, deviation=d, lengths=lengths)) for d in DEVIATIONS]


def _bnirl(case: Shown, seed: int, *, confidence: float) -> Scored:
    likelihood = planned_actions(
        case.demonstrations, visited(case.demonstrations), case.grid.mdp, confidence=confidence
    )
    posterior = posterior_of(likelihood, seed, draws=300, warmup=200, thin=2)
    explained = assignment_loss(likelihood, posterior.best_assignment)
    return {
        "weights of the whole": (explained, PAIRS * held_out_loss(posterior, case.fresh)),
        "weights nearby": (explained, PAIRS * nearby_loss(posterior, case.fresh)),
    }


def _abbeel(case: Shown, seed: int, *, variant: str) -> Scored:
    given = (case.demonstrations, case.grid.mdp, case.features, seed)
    if variant == BOTH:
        return {"best iteration": _losses(case, abbeel_both(*given).best)}
    mixture = abbeel(*given, variant=variant)
    last = abbeel(*given, variant=variant, policy="greedy")
    return _scored(case, mixture) | {"last": _losses(case, last.returned)}


def _margin(case: Shown, seed: int, *, regulariser: float) -> Scored:
    return _scored(case, margin(case.demonstrations, case.grid.mdp, case.features, seed, regulariser=regulariser))


def _bayesian(case: Shown, seed: int, *, deviation: float, lengths: Lengths) -> Scored:
    found = bayesian(case.demonstrations, case.grid.mdp, case.features, seed, deviation=deviation, lengths=lengths)
    return {"returned": _losses(case, found.returned)}


def _scored(case: Shown, found: Learned) -> Scored:
    return {"returned": _losses(case, found.returned), "best iteration": _losses(case, found.best)}


def _losses(case: Shown, policy: Any) -> tuple[float, float]:
    return PAIRS * wrong(policy, case.demonstrations), PAIRS * wrong(policy, case.fresh)
