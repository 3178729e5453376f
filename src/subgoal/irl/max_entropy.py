"""One reward by maximum entropy: of soft planners (Ziebart 2010), and of whole trajectories (Ziebart 2008)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.ascent import Ascent, climb
from subgoal.irl.causal_objective import CausalObjective
from subgoal.irl.single_reward import SingleReward, check_features, shown, told, undetermined_directions
from subgoal.irl.trajectory_objective import TrajectoryObjective
from subgoal.mdp.planners.soft import soft_value_iteration
from subgoal.mdp.tabular import TabularMDP, check_discount
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, frozen, positive, whole
from subgoal.runtime.errors import InputError, PlanningError
from subgoal.runtime.progress import Progress

CausalKind = Literal["likelihood", "feature_matching"]
CAUSAL = "Ziebart, B. D. (2010). Modeling Purposeful Adaptive Behavior with the Principle of Maximum Causal Entropy"
TRAJECTORIES = (
    "Ziebart, B. D., Maas, A., Bagnell, J. A., Dey, A. K. (2008). Maximum Entropy Inverse Reinforcement Learning"
)
CERTAIN = 1e-3
"""Nats an observation below which the demonstrations are nearly all that the policy would do."""

UNATTAINABLE = (
    "no policy visits what was shown as often, by the luck of few trajectories, so that weights grow without bound; l2 "
    "above 0 keeps them finite, and the likelihood has no such trouble"
)
CHOSEN_OUTCOMES = (
    "outcomes are uncertain here, and this method lets the demonstrator choose them; max_causal_entropy does not"
)


def max_causal_entropy(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    objective: CausalKind = "likelihood",
    l2: float = 0.0,
    tolerance: float = 1e-6,
    most_iterations: int = 1_000,
    progress: Progress | None = None,
) -> SingleReward:
    """The reward R = Φw of which a soft planner at temperature 1, who sees no further than it acts, does as was shown.

    π(a | s) = exp(Q(s, a) − V(s)) over an infinite horizon, with the discount of the world throughout; at another
    temperature the weights are that many times as large.

    Parameters
    ----------
    demonstrations, mdp:
        States (N,) and actions (N,), and the world they are of.
    features:
        (S, F) Φ; None is a reward for each state.
    objective:
        "likelihood": Σ_i log π(a_i | s_i). Every pair counts alike, in any order; it may have several local maxima.
        "feature_matching": Σ w·μ_E − V(s_0) over trajectories, the dual of greatest causal entropy, which matches
        discounted visits: a pair at time t counts γ^t. Concave where trajectories end in terminal states; a trajectory
        that was cut off is taken up by the model, so that single pairs give the likelihood. Given enough data of such a
        planner both find its policy. The first is the default: it wastes no pair, and is what models are compared by.
    l2:
        J has the term −l2 |w|²/2: a Gaussian prior of variance 1/l2. At 0, where the demonstrator never errs, larger
        weights are always better, and the tolerance says when to stop.
    tolerance:
        Largest entry of the gradient per observation (per discounted observation when matching features).
    most_iterations, progress:
        Steps of L-BFGS at most; told the steps and the gradient. Ctrl-C gives back what was found so far.

    Raises
    ------
    InputError
        No observations, impossible steps, NaN in the features, an unknown objective; at discount 1, where no reward
        of these features has finite soft values at the start: one that costs in every step.
    """
    pairs, table = shown(demonstrations, mdp), check_features(features, mdp)
    penalty = positive("l2", l2, zero=True)
    if objective not in ("likelihood", "feature_matching"):
        raise InputError("objective", found=repr(objective), wanted="'likelihood' or 'feature_matching'")
    build = CausalObjective.likelihood if objective == "likelihood" else CausalObjective.feature_matching
    search = build(pairs, mdp, table, penalty)
    found = climb(
        search, _first_weights(mdp, table), size=search.size, tolerance=positive("tolerance", tolerance),
        most_iterations=whole("most_iterations", most_iterations), progress=progress,
    )  # fmt: skip
    policy = soft_value_iteration(
        mdp, table @ found.weights, tolerance=0.0, initial=None if search.plan is None else search.plan.value,
        allow_unconverged=True,
    ).policy  # fmt: skip
    notes = []
    if objective == "likelihood":
        notes += _certain(found.value / search.size, penalty)
    elif not pairs.ordered:
        notes.append("no trajectory has two pairs, so that feature matching is the likelihood")
    elif found.outcome is not Outcome.CONVERGED and found.value > 0:
        notes.append(UNATTAINABLE)
    method = f"maximum causal entropy, {objective.replace('_', ' ')}"
    return _made(method, CAUSAL, policy, table, found, undetermined_directions(table, mdp), notes)


def max_entropy(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    discount: float = 1.0,
    l2: float = 0.0,
    tolerance: float = 1e-6,
    most_iterations: int = 1_000,
    progress: Progress | None = None,
) -> SingleReward:
    """The reward R = Φw under which whole trajectories like those shown are likely: P(ζ) ∝ exp(Σ_t γ^t R(s_t)) Π P.

    The original of 2008: each trajectory is compared with all others of its length from its first state. Where actions
    have certain outcomes that is maximum causal entropy over a finite horizon. Elsewhere it lets the demonstrator
    choose the outcomes too, as if luck went by reward: such a model takes risks that no planner would. The objective is
    concave (but for last states that are not known).

    Parameters
    ----------
    demonstrations, mdp, features, l2, tolerance, most_iterations, progress:
        As in ``max_causal_entropy``; pairs must be in order. Ctrl-C likewise.
    discount:
        γ of the sum over a trajectory: 1, as in the paper, whatever the discount of the world is.

    Returns
    -------
    ``policy`` is how often the model takes each action in a state, over trajectories like those shown; where they never
    come, all actions alike. ``solutions`` counts passes over all trajectories.

    Raises
    ------
    InputError
        As ``max_causal_entropy``; and pairs without order, whose trajectories are not known.
    BudgetError
        Trajectories too long for a table over time and states.
    """
    pairs, table = shown(demonstrations, mdp), check_features(features, mdp)
    if not pairs.ordered:
        raise InputError(
            "demonstrations", found="trajectories of one pair each", wanted="pairs in order: whole trajectories are "
            "compared", hint="max_causal_entropy, which takes pairs in any order",
        )  # fmt: skip
    gamma = check_discount(discount)
    search = TrajectoryObjective(pairs, mdp, table, gamma, positive("l2", l2, zero=True))
    found = climb(
        search, np.zeros(table.shape[1]), size=search.size, tolerance=positive("tolerance", tolerance),
        most_iterations=whole("most_iterations", most_iterations), progress=progress,
    )  # fmt: skip
    policy, notes = _action_shares(search, mdp, table @ found.weights)
    if ((mdp.probability > 0) & (mdp.probability < 1)).any():
        notes.append(CHOSEN_OUTCOMES)
    return _made("maximum entropy", TRAJECTORIES, policy, table, found, undetermined_directions(table), notes)


def _first_weights(mdp: TabularMDP, features: Floats) -> Floats:
    """Zero; at discount 1 those that make each step cost more than its entropy is worth."""
    if mdp.discount < 1:
        return np.zeros(features.shape[1])
    cost = np.where(mdp.terminal, 0.0, 1.0 + np.log(mdp.n_actions))
    weights = np.asarray(np.linalg.lstsq(features, -cost, rcond=None)[0])
    try:
        soft_value_iteration(mdp, features @ weights)
    except PlanningError:
        wanted = "below 1, or features of which one can be a cost in every step"
        raise InputError("discount", found=1.0, wanted=wanted) from None
    return weights


def _certain(nats: float, l2: float) -> list[str]:
    """A note where weights grow without bound."""
    if l2 > 0 or nats < -CERTAIN:
        return []
    return ["the demonstrator hardly errs, so that larger weights are always better; l2 above 0 keeps them finite"]


def _action_shares(search: TrajectoryObjective, mdp: TabularMDP, reward: Floats) -> tuple[Floats, list[str]]:
    """(S, A) how often the model takes each action, and notes on states without, and on last states."""
    pairs = search.expected(reward)[2]
    total = pairs.sum(axis=1)
    never = ~(total > 0) & ~mdp.terminal
    even = mdp.available / np.maximum(mdp.available.sum(axis=1, keepdims=True), 1)
    policy = np.where((total > 0)[:, None], pairs / np.where(total > 0, total, 1.0)[:, None], even)
    notes = []
    if never.any():
        notes.append(
            f"in {int(never.sum())} states, where trajectories like those shown never are, all actions are alike"
        )
    if not search.recorded.all():
        count = int((~search.recorded).sum())
        notes.append(f"the last state of {count} trajectories is not known, and was summed over")
    return policy, notes


def _made(
    method: str, reference: str, policy: Floats, features: Floats, found: Ascent, directions: Floats,
    notes: list[str],
) -> SingleReward:  # fmt: skip
    return SingleReward(
        method=method, reference=reference, policy=frozen(policy), reward=frozen(features @ found.weights),
        weights=frozen(found.weights), outcome=found.outcome, iterations=len(found.trace) - 1,
        solutions=found.solutions, trace=frozen(found.trace @ features.T), undetermined=frozen(directions),
        notes=(*told(directions), *notes),
    )  # fmt: skip
