"""The methods of one reward beside which figures 4-2 and 4-3 put BNIRL: Abbeel and Ng's, maximum margin, Bayesian IRL.

All see the same pairs, and Manhattan features scaled to a range of one. Loss is the 0-1 policy loss under uniform ties.
Bayesian IRL is PolicyWalk over the weights of the features: independent normal priors around zero, confidence 10 as
BNIRL's, an iteration being one proposal of one weight.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.grid_worlds import CONFIDENCE
from subgoal.answers.scores import zero_one_loss
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.bayesian import anneal_reward, bayesian_irl
from subgoal.irl.expectations import optimal_policy
from subgoal.irl.max_margin import max_margin_planning
from subgoal.irl.reward_priors import Gaussian
from subgoal.irl.single_reward import SingleReward
from subgoal.mdp.grids.features import manhattan
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats

ABBEEL, MARGIN, BAYESIAN = "Abbeel-Ng", "maximum margin", "Bayesian IRL"
ITERATIONS = 400
"""Of Bayesian IRL's chain, and of the curves of all."""
STEP = 0.25
"""Of a proposal, in standard deviations of the prior."""
REGULARISER, DEVIATION = 1e-3, 1.0
"""λ of maximum margin planning and the prior's standard deviation, in reward over the range of a feature."""


@dataclass(frozen=True)
class Lengths:
    """How long Bayesian IRL runs: proposals of the chain that is drawn; sweeps and chains of the one that answers."""

    iterations: int = ITERATIONS
    draws: int = 150
    warmup: int = 100
    chains: int = 2


@dataclass(frozen=True, eq=False)
class Learned:
    """What a rival made of one set of demonstrations.

    Attributes
    ----------
    by_iteration:
        (T,) share of the pairs wrong, with the policy optimal for the reward of each iteration.
    returned:
        (S, A) the policy that the method returns.
    best:
        (S, A) of the policies it went through, the first that has fewest of the pairs wrong; for Bayesian IRL, whose
        iterations are draws and no search, ``returned``.
    solutions:
        How many times a policy for a reward was solved for.
    """

    by_iteration: Floats
    returned: Floats
    best: Floats
    solutions: int


Rival = Callable[[Demonstrations, TabularMDP, Floats, int], Learned]


def scaled_features(grid: GridWorld, anchors: Any) -> Floats:
    """(S, k) Manhattan distances (4.16) to cells (x, y) counted from zero, each with a range of one."""
    distances = manhattan(grid, anchors).astype(float)
    return np.asarray(distances / np.ptp(distances, axis=0))


def wrong(policy: Floats, demos: Demonstrations) -> float:
    """Share of the pairs that a policy (S, A) has wrong, its ties broken at random."""
    return zero_one_loss(policy[demos.states], demos.actions)


def abbeel(demos: Demonstrations, mdp: TabularMDP, features: Floats, seed: int = 0, *, policy: Any = "mixture",
           variant: Any = "max_margin") -> Learned:  # fmt: skip
    """Abbeel and Ng's quadratic program; it returns the mixture of policies that it promises something of."""
    return searched(apprenticeship(demos, mdp, features, policy=policy, variant=variant), demos, mdp)


def abbeel_both(demos: Demonstrations, mdp: TabularMDP, features: Floats, seed: int = 0) -> Learned:
    """The quadratic program, and after it the projection of the same paper: more policies to choose the best from."""
    first, second = (abbeel(demos, mdp, features, variant=each) for each in ("max_margin", "projection"))
    best = first.best if wrong(first.best, demos) <= wrong(second.best, demos) else second.best
    losses = np.concatenate([first.by_iteration, second.by_iteration])
    return Learned(losses, first.returned, best, first.solutions + second.solutions)


def margin(
    demos: Demonstrations, mdp: TabularMDP, features: Floats, seed: int = 0, *, regulariser: float = REGULARISER
) -> Learned:
    """Maximum margin planning by cutting planes, its loss in states that nobody visits."""
    return searched(max_margin_planning(demos, mdp, features, regulariser=regulariser), demos, mdp)


def bayesian(
    demos: Demonstrations, mdp: TabularMDP, features: Floats, seed: int = 0, *, deviation: float = DEVIATION,
    step: float = STEP, lengths: Lengths = Lengths(),
) -> Learned:  # fmt: skip
    """PolicyWalk: the losses of one chain's draws from its first on, and the policy of the posterior mean."""
    law: Any = {"prior": Gaussian(deviation), "confidence": CONFIDENCE, "step": step * deviation, "seed": seed}
    chain = anneal_reward(demos, mdp, features, schedule=np.ones_like, steps=lengths.iterations, **law)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        found = bayesian_irl(demos, mdp, features, draws=lengths.draws, warmup=lengths.warmup, chains=lengths.chains,
                             workers=1, **law)  # fmt: skip
    losses, _ = losses_of(chain.trace, demos, mdp)
    return Learned(losses, found.policy, found.policy, lengths.iterations)


RIVALS: dict[str, Rival] = {ABBEEL: abbeel, MARGIN: margin, BAYESIAN: bayesian}


def losses_of(trace: Floats, demos: Demonstrations, mdp: TabularMDP) -> tuple[Floats, Floats]:
    """(T,) share of the pairs wrong for each reward of a trace (T, S), and the first policy (S, A) of the least."""
    losses = np.empty(len(trace))
    policy = best = optimal_policy(mdp, trace[0])
    for t, reward in enumerate(trace):
        if t and (reward != trace[t - 1]).any():
            policy = optimal_policy(mdp, reward)
        losses[t] = wrong(policy, demos)
        if losses[t] < losses[:t].min(initial=np.inf):
            best = policy
    return losses, best


def searched(found: SingleReward, demos: Demonstrations, mdp: TabularMDP) -> Learned:
    """The losses of a search by iteration, what it returned, and the best that it went through."""
    losses, best = losses_of(found.trace, demos, mdp)
    return Learned(losses, found.policy, best, found.solutions)


def curve(learned: Learned, length: int = ITERATIONS, *, so_far: bool) -> Floats:
    """(length,) loss by iteration, the last held where the search had ended; ``so_far``: the least up to then."""
    made = learned.by_iteration[:length]
    held = np.append(made, np.full(length - made.size, made[-1]))
    return np.asarray(np.minimum.accumulate(held) if so_far else held)
