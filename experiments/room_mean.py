"""Whether the posterior mean is the reward to report: thesis 3.1 says that it minimises (3.4) and (3.5).

Draws of half of the chains give the rewards that are tried, draws of the other half the expectations. With two
demonstrations, rewards of at most 1 and α = 0.95 the posterior is wide, and chains get round in it.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from experiments.common import Headline
from experiments.room_worlds import demonstrate
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bayesian import anneal_reward, bayesian_irl
from subgoal.irl.reward_posterior import RewardPosterior, greedy_policy_of
from subgoal.irl.reward_priors import ThreePeaks
from subgoal.mdp.grids.rooms import MAGNITUDE, RoomWorld
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats

SHOWN, CONFIDENCE = 2, 0.95
DRAWS, WARMUP, QUICK_DRAWS, QUICK_WARMUP = 1_000, 200, 30, 10
TRIED_DRAWS, QUICK_TRIED_DRAWS, TESTED = 25, 5, 100
PRIOR = ThreePeaks.scaled(bounded=True)
MEAN, TRUTH = "posterior mean", "true reward"


def of_mean(world: RoomWorld, seed: int, quick: bool) -> Headline:
    """Expected losses of the rewards that are tried, by reward; which is least; how well the chains agree."""
    demos = first_of(demonstrate(world, seed), SHOWN)
    draws, warmup, count = (QUICK_DRAWS, QUICK_WARMUP, QUICK_TRIED_DRAWS) if quick else (DRAWS, WARMUP, TRIED_DRAWS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = bayesian_irl(
            demos, world.grid.mdp, prior=PRIOR, confidence=CONFIDENCE, chains=4, draws=draws, warmup=warmup, seed=seed,
            workers=1,
        )  # fmt: skip
    tried = rewards_of(world, demos, posterior, seed, count)
    found = {name: expected_losses(posterior, reward) for name, reward in tried.items()}
    rhat = max((each.rhat for name, each in posterior.diagnostics.items() if name.startswith("log")), default=np.nan)
    kinds = list(found[MEAN])
    return {
        "pairs": demos.n_observations,
        "status": posterior.status.name,
        "largest_rhat_of_log_densities": rhat,
        "expected": {name: row for name, row in found.items() if not name.startswith("draw")},
        "draws_tried": count,
        "best_draw": {kind: min(row[kind] for name, row in found.items() if name.startswith("draw")) for kind in kinds},
        "least": {kind: min(found, key=lambda name: found[name][kind]) for kind in kinds},
    }


def first_of(demos: Demonstrations, count: int) -> Demonstrations:
    """The first trajectories."""
    stop, final = int(demos.offset[count]), np.asarray(demos.final_states)[:count]
    return Demonstrations(
        np.asarray(demos.states)[:stop], np.asarray(demos.actions)[:stop], demos.offset[: count + 1],
        final_states=final, coordinates=demos.coordinates,
    )  # fmt: skip


def rewards_of(
    world: RoomWorld, demos: Demonstrations, posterior: RewardPosterior, seed: int, count: int
) -> dict[str, Floats]:
    """Mean, median, the draw of largest density, ``count`` draws, what cooling ends in, no reward, and the truth."""
    half = posterior.weights.shape[0] // 2
    drawn = posterior.weights[:half].reshape(-1, posterior.weights.shape[-1])
    joint = posterior.log_joint[:half].ravel()
    annealed = anneal_reward(
        demos, world.grid.mdp, prior=PRIOR, confidence=CONFIDENCE, steps=20 * drawn.shape[1], seed=seed
    )  # fmt: skip
    found: Any = annealed.reward
    some = np.linspace(0, len(drawn) - 1, count).astype(int)
    return {
        MEAN: drawn.mean(axis=0),
        "posterior median": np.median(drawn, axis=0),
        "draw of largest density": drawn[int(np.argmax(joint))],
        "annealed": found,
        "zero": np.zeros(drawn.shape[1]),
        TRUTH: world.reward / MAGNITUDE,
    } | {f"draw {k}": drawn[k] for k in some}


def expected_losses(posterior: RewardPosterior, reward: Floats) -> Headline:
    """Of a reward R̂, over the other half of the draws: ‖R − R̂‖², ‖R − R̂‖ (3.4), and (3.5) of its optimal policy."""
    law, half = posterior.law, posterior.weights.shape[0] // 2
    drawn = posterior.weights[half:].reshape(-1, posterior.weights.shape[-1])
    best = posterior.values[half:].reshape(drawn.shape)
    some = np.linspace(0, len(drawn) - 1, min(TESTED, len(drawn))).astype(int)
    apart = ((drawn - reward) ** 2).sum(axis=1)
    states, actions = law.mdp.available.shape
    policy = greedy_policy_of(law, reward)
    step = np.einsum("sa,sat->st", policy, law.mdp.matrix.toarray().reshape(states, actions, states))
    worth = np.linalg.solve(np.eye(states) - law.mdp.discount * step, drawn[some].T).T
    lost = np.maximum(best[some] - worth, 0)
    return {
        "squared": float(apart.mean()),
        "as printed (3.4)": float(np.sqrt(apart).mean()),
        "policy, p = 1": float(lost.sum(axis=1).mean()),
        "policy, p = 2": float(np.sqrt((lost**2).sum(axis=1)).mean()),
        "policy, largest": float(lost.max(axis=1).mean()),
    }
