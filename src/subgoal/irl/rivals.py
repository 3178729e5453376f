"""Ways to foretell actions in a discrete world, each fitted to some demonstrations: what ``compare`` compares."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from subgoal.answers.filtering import filtering
from subgoal.answers.predictions import policies_of, predict_mixture
from subgoal.answers.subgoals import MERGE_RADII, subgoals
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.bayesian import bayesian_irl
from subgoal.irl.bnirl import bnirl
from subgoal.irl.cloning import behaviour_cloning, contexts, counted
from subgoal.irl.max_entropy import max_causal_entropy
from subgoal.irl.max_margin import max_margin_planning
from subgoal.irl.reward_priors import Gaussian
from subgoal.irl.single_reward import SingleReward
from subgoal.mdp.planners.policy import uniform_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.models import Persistent
from subgoal.partition.outcome import Outcome
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError

Foretold = Callable[[Demonstrations], Floats]
"""From N pairs, of which only states and earlier actions may be looked at, to (N, A) probabilities of the action."""
LEAST_ERROR = 1e-4
SAMPLING: dict[str, Any] = {"draws": 300, "warmup": 300, "thin": 2}
REWARD_PRIOR, REWARD_STEP, L2 = Gaussian(2.0), 1.0, 0.1
"""In nats of action values: of Bayesian and of maximum entropy IRL, one reward for each state."""
HALF_DIAGONAL = 2**-0.5
"""Of a square of side one: no place in a cell is further from its centre."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A rival after its fit: how it foretells, how large it is (so many of a unit), and whether it converged."""

    foretell: Foretold
    size: float = 0.0
    unit: str = ""
    converged: bool = True
    notes: tuple[str, ...] = field(default_factory=tuple)


Rival = Callable[[Demonstrations, TabularMDP, int], Fitted]


def chance(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """All legal actions alike."""
    return _by_state(uniform_policy(mdp.available), 0, "")


def cloning(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """The first-order Markov chain p(a | s)."""
    found = behaviour_cloning(demonstrations, mdp)
    return _by_state(found.policy, _counted_cells(demonstrations), "states", notes=found.notes)


def second_order(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """The second-order chain p(a | s before, s), its Dirichlet prior centred on the first-order one, of weight 1."""
    base = behaviour_cloning(demonstrations, mdp).policy

    def foretell(asked: Demonstrations) -> Floats:
        seen = counted(demonstrations, asked, shape=mdp.available.shape)
        return np.asarray((seen + base[asked.states]) / (seen.sum(axis=1, keepdims=True) + 1))

    return Fitted(foretell, np.unique(contexts(demonstrations, mdp.n_states)).size, "state pairs")


def subgoal_mixture(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """BNIRL (thesis 4), exchangeable."""
    posterior = _quietly(bnirl, demonstrations, mdp, seed=seed, **SAMPLING)
    return _by_subgoals(posterior, mdp, lambda asked: predict_mixture(posterior, asked.states))


def lasting_subgoals(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """BNIRL with subgoals that last, their persistence learned."""
    posterior = lasting_posterior(demonstrations, mdp, seed)

    def foretell(asked: Demonstrations) -> Floats:
        """The filter before each action: what it says after it, the action taken out again, mixed over policies."""
        filtered = filtering(posterior, asked, seed=seed)
        policies, row = policies_of(posterior, asked.states)
        taken = policies[row, np.asarray(asked.actions)]
        before = filtered.probability / np.maximum(taken, np.finfo(float).tiny)
        before *= np.exp(filtered.log_predictive)[:, None]
        table = np.einsum("nag,ng->na", policies[row], before / before.sum(axis=1, keepdims=True))
        return np.asarray(table / table.sum(axis=1, keepdims=True))

    return _by_subgoals(posterior, mdp, foretell)


def lasting_posterior(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Posterior:
    """The fit of ``lasting_subgoals``."""
    posterior: Posterior = _quietly(bnirl, demonstrations, mdp, seed=seed, model=Persistent(), **SAMPLING)
    return posterior


def merge_radius(demonstrations: Demonstrations, mdp: TabularMDP) -> float:
    """Within which states are counted, and shown, as one subgoal, in units of the coordinates; 0 without these.

    As for the places of ``subgoal.learn``, 5 times the distance within which every position has a candidate: of square
    cells, whose side is the shortest step of the world, half the diagonal. On a grid these are 3.5 cells.
    """
    places = demonstrations.coordinates
    if places is None:
        return 0.0
    after = mdp.matrix.tocoo()
    steps = np.linalg.norm(places[after.row // mdp.n_actions] - places[after.col], axis=1)
    moved = steps[steps > 0]
    return float(MERGE_RADII * HALF_DIAGONAL * moved.min()) if moved.size else 0.0


def bayesian(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """Bayesian IRL, a reward for each state that was shown, zero elsewhere: its predictive distribution."""
    seen = np.isin(np.arange(mdp.n_states), demonstrations.states).astype(float)
    found = _quietly(
        bayesian_irl, demonstrations, mdp, prior=REWARD_PRIOR, confidence=1.0, step=REWARD_STEP, relevance=seen,
        draws=100, warmup=100, seed=seed,
    )  # fmt: skip
    return _by_state(found.predictive, int(seen.sum()), "rewards", converged=found.status is Status.CONVERGED)


def maximum_entropy(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """Maximum causal entropy IRL, one reward for each state."""
    return _of_reward(max_causal_entropy(demonstrations, mdp, l2=L2))


def matched_features(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """Abbeel and Ng's mixture of policies, with the share of errors that suits the training pairs."""
    return _erring(apprenticeship(demonstrations, mdp, most_iterations=30), demonstrations, mdp)


def largest_margin(demonstrations: Demonstrations, mdp: TabularMDP, seed: int) -> Fitted:
    """Maximum-margin planning, with the share of errors that suits the training pairs."""
    return _erring(max_margin_planning(demonstrations, mdp), demonstrations, mdp)


RIVALS: dict[str, tuple[str, Rival]] = {
    "chance": ("chance", chance),
    "cloning": ("behavioural cloning", cloning),
    "markov": ("second-order Markov chain", second_order),
    "bnirl": ("BNIRL", subgoal_mixture),
    "bnirl-persistent": ("BNIRL, lasting subgoals", lasting_subgoals),
    "bayesian": ("Bayesian IRL", bayesian),
    "entropy": ("maximum causal entropy", maximum_entropy),
    "apprenticeship": ("apprenticeship (Abbeel-Ng)", matched_features),
    "margin": ("maximum-margin planning", largest_margin),
}
FLOORS = ("chance", "cloning", "markov")
SEVERAL, SINGLE = ("bnirl", "bnirl-persistent"), ("bayesian", "entropy", "apprenticeship", "margin")
"""Accounts with several subgoals, and with one reward."""


def fitted(name: str, made: Any, mdp: TabularMDP) -> Fitted:
    """What a rival gave, where it is a policy (S, A) or has one; raises ``InputError`` for anything else."""
    if isinstance(made, Fitted):
        return made
    if isinstance(made, SingleReward):
        return _of_reward(made)
    policy = np.asarray(made)
    if policy.shape != mdp.available.shape or policy.dtype.kind not in "fiu":
        found = f"shape {policy.shape}" if policy.shape else type(made).__name__
        wanted = f"a Fitted, a SingleReward or a policy of shape {mdp.available.shape}"
        raise InputError(f"what {name} gave", found=found, wanted=wanted)
    return _by_state(policy, 0, "")


def error_rate(policy: Floats, demonstrations: Demonstrations, mdp: TabularMDP) -> float:
    """ε that makes the pairs likeliest under (1 − ε)·π(a | s) + ε/|A(s)|, at least 1e-4."""
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions)
    own, even = policy[states, actions], 1 / mdp.available.sum(axis=1)[states]

    def unlikeliness(share: float) -> float:
        return -float(np.log((1 - share) * own + share * even).sum())

    return float(minimize_scalar(unlikeliness, bounds=(LEAST_ERROR, 1.0), method="bounded").x)


def _erring(found: SingleReward, demonstrations: Demonstrations, mdp: TabularMDP) -> Fitted:
    share = error_rate(found.policy, demonstrations, mdp)
    policy = (1 - share) * found.policy + share * uniform_policy(mdp.available)
    return _of_reward(found, policy, (f"errs in {share:.1%} of its actions",))


def _of_reward(found: SingleReward, policy: Floats | None = None, notes: tuple[str, ...] = ()) -> Fitted:
    count = 0 if found.weights is None else len(found.weights)
    chosen = found.policy if policy is None else policy
    done = found.outcome is Outcome.CONVERGED
    return _by_state(chosen, count, "rewards", converged=done, notes=notes)


def _by_state(policy: Floats, size: float, unit: str, *, converged: bool = True, notes: tuple[str, ...] = ()) -> Fitted:
    return Fitted(lambda asked: np.asarray(policy[asked.states]), size, unit, converged, notes)


def _by_subgoals(posterior: Posterior, mdp: TabularMDP, foretell: Foretold) -> Fitted:
    found = subgoals(posterior, merge_radius=merge_radius(posterior.demonstrations, mdp))
    return Fitted(foretell, found.n_subgoals, "subgoals", posterior.status is Status.CONVERGED)


def _counted_cells(demonstrations: Demonstrations) -> int:
    return int(np.unique(np.asarray(demonstrations.states)).size)


def _quietly(make: Callable[..., Any], *args: Any, **settings: Any) -> Any:
    """What has not converged is told in the table."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return make(*args, **settings)
