"""Action prediction (thesis 4.5): what the demonstrator would do in a state, by four rules that can be compared."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
from scipy.special import log_softmax, logsumexp

from subgoal.answers.order import first_served
from subgoal.answers.subgoals import LISTED_FROM
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import PlannedActions
from subgoal.likelihood.source import Levels
from subgoal.mdp.local_world import local_world
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, positive, whole
from subgoal.runtime.errors import InputError

BANDWIDTHS = 12
"""Bandwidths tried between half the smallest and the largest distance of two observed places."""
MOST_TRIED = 1_000
"""Observations, evenly spread, on which bandwidths are tried."""
MOST_DISTANCES = 2**22
"""Distances that are held at a time."""


def predict_mixture(posterior: Posterior, states: Any) -> Floats:
    """(M, A) posterior predictive p(a | s, O) = Σ_g w_g π_g(a | s), w_g = (E[n_g | O] + ηp_g) / (N + η).

    The exact predictive of the exchangeable model: the weights do not depend on the state, the policies do. Raises
    ``InputError`` for states (M,) that do not exist and for a posterior that was not made by planning.
    """
    policies, row = policies_of(posterior, states)
    return np.asarray((policies @ _weights(posterior))[row])


def predict_literal(posterior: Posterior, states: Any) -> Floats:
    """(M, A) the printed rule (4.14), applied to the best draw: one cluster, then the policy (4.2) of its subgoal.

    The cluster is argmax_z Σ_a P(z | ẑ, ĝ, (s, a)). By (4.9) the sum is CRP(z)·Σ_a π_z(a | s) = CRP(z): it ignores the
    state, and the largest cluster is chosen everywhere. Kept for comparison; ``predict_mixture`` is what it meant.
    """
    policies, row = policies_of(posterior, states)
    size = np.bincount(posterior.best_assignment, minlength=posterior.candidates.n_candidates)
    used = np.flatnonzero(size)
    score = (size[used] * policies[:, :, used]).sum(axis=1)
    largest = used[np.argmax(np.round(score / posterior.n_observations, 12), axis=1)]
    return np.asarray(policies[np.arange(len(policies)), :, largest][row])


def predict_nearby(posterior: Posterior, states: Any, *, bandwidth: float | None = None) -> Floats:
    """(M, A) a mixture whose weights hang on the place: w_g(s) ∝ Σ_i κ(s, s_i) P(θ_i = g | O) + ηp_g.

    κ(s, s') = exp(−d²/2h²) over the distance d between the places of the states; for large h this is
    ``predict_mixture``. ``bandwidth`` h is in units of the coordinates; None takes the one of twelve, from half the
    smallest to the largest distance between observed places, that predicts each observation best from the trajectories
    it is not part of (from the other observations, if there is one trajectory only).
    """
    if bandwidth is None:
        bandwidth = best_bandwidth(posterior)
    width, seen, there = positive("bandwidth", bandwidth), posterior.demonstrations.places, _places(posterior, states)
    policies, row = policies_of(posterior, states)
    out = np.empty((len(there), policies.shape[1]))
    for block in _blocks(len(there), len(seen)):
        near = np.exp(-0.5 * (_distances(there[block], seen) / width) ** 2)
        weights = _local_weights(posterior, near)
        out[block] = [policies[u] @ weight for u, weight in zip(row[block], weights, strict=True)]
    return out


def predict_waypoints(
    posterior: Posterior, demonstrations: Demonstrations, *, dwell: int = 0, cyclic: bool = False
) -> Floats:
    """(M, A) subgoals followed as ``waypoints`` in the order in which demonstrations first served them (thesis 4.5).

    Each trajectory of ``demonstrations`` (M observations) begins with the first waypoint, goes on to the next once it
    has been there for ``dwell`` observations, and stays with the last, or begins again if ``cyclic``. Only states are
    looked at, never actions.
    """
    sequence, dwell = waypoints(posterior), whole("dwell", dwell, least=0)
    policies, row = policies_of(posterior, demonstrations.states)
    sets: Any = posterior.candidates.goal_sets
    there = np.stack([np.isin(demonstrations.states, sets[g]) for g in sequence], axis=1)
    aim = np.empty(demonstrations.n_observations, np.int64)
    for a, b in zip(demonstrations.offset[:-1], demonstrations.offset[1:], strict=True):
        at, stayed = 0, 0
        for i in range(a, b):
            for _ in range(sequence.size - 1):
                if not there[i, at] or stayed < dwell or (at == sequence.size - 1 and not cyclic):
                    break
                at, stayed = (at + 1) % sequence.size, 0
            stayed += int(there[i, at])
            aim[i] = sequence[at]
    return np.asarray(policies[row, :, aim])


def waypoints(posterior: Posterior) -> Ints:
    """Candidates with at least 1 % of the observations, in the order in which the best draw ``first_served`` them."""
    shares = posterior.expected_shares
    listed = np.flatnonzero(shares >= LISTED_FROM)
    listed = listed if listed.size else np.array([int(np.argmax(shares))])
    chances = posterior.shares[:, listed]
    return first_served(posterior.demonstrations, posterior.best_assignment, listed, shares[listed], chances)


def best_bandwidth(posterior: Posterior) -> float:
    """The bandwidth that ``predict_nearby`` takes when it is given none."""
    _coordinates(posterior)
    demos = posterior.demonstrations
    places, trajectory = demos.places, demos.trajectory
    tried_on = np.unique(np.linspace(0, len(places) - 1, MOST_TRIED).astype(np.int64))
    closest, furthest = np.inf, 0.0
    for block in _blocks(tried_on.size, len(places)):
        distance = _distances(places[tried_on[block]], places)
        furthest = max(furthest, float(distance.max()))
        closest = min(closest, float(np.where(distance > 0, distance, np.inf).min()))
    if furthest == 0:
        return 1.0
    tried = np.geomspace(closest / 2, furthest, BANDWIDTHS)
    policies, row = _log_policies(posterior, demos.states[tried_on])
    taken = policies[row, demos.actions[tried_on]]
    alone = demos.n_trajectories == 1
    scores = np.zeros(BANDWIDTHS)
    for block in _blocks(tried_on.size, len(places)):
        rows = tried_on[block]
        distance = _distances(places[rows], places)
        other = np.arange(len(places)) != rows[:, None] if alone else trajectory != trajectory[rows][:, None]
        for k, width in enumerate(tried):
            weights = _local_weights(posterior, np.exp(-0.5 * (distance / width) ** 2) * other)
            scores[k] += logsumexp(taken[block], b=weights, axis=1).sum()
    return float(tried[int(np.argmax(scores))])


def planned_source(posterior: Posterior) -> PlannedActions:
    """The planned actions that a posterior was sampled from; raises ``InputError`` for any other."""
    source = None if posterior.likelihood is None else posterior.likelihood.source
    if not isinstance(source, PlannedActions):
        raise InputError("posterior", found=f"likelihood {posterior.settings.likelihood!r}",
                         wanted="one that was sampled from planned_actions",
                         hint="subgoal.bnirl(demonstrations, mdp), or subgoal.load(path, mdp=mdp)")  # fmt: skip
    return source


def policies_of(posterior: Posterior, states: Any) -> tuple[Floats, Ints]:
    """(U, A, G) π_g(a | s) of the different states, and (M,) the row of each state."""
    table, row = _log_policies(posterior, states)
    return np.exp(table), row


def _log_policies(posterior: Posterior, states: Any) -> tuple[Floats, Ints]:
    """As ``policies_of``, log π_g(a | s)."""
    source = planned_source(posterior)
    here, row = np.unique(_checked(source, states), return_inverse=True)
    above: Floats = source.planned_at(here).action_values
    over = ~np.isfinite(above).any(axis=(1, 2))
    if over.any():
        found = f"terminal state {here[np.argmax(over)]}"
        raise InputError("states", found=found, wanted="states in which an action can be taken")
    above -= above.max(axis=1, keepdims=True)
    law: Any = posterior.likelihood.confidence if posterior.likelihood is not None else posterior.confidence
    if not isinstance(law, Levels):
        return log_softmax(above * law, axis=1), row
    levels = zip(law.confidences.tolist(), np.log(law.shares).tolist(), strict=True)
    return reduce(np.logaddexp, (log_share + log_softmax(above * alpha, axis=1) for alpha, log_share in levels)), row


def _checked(source: PlannedActions, states: Any) -> Ints:
    """(M,) existing states; one number is one state."""
    checked = np.atleast_1d(local_world(source.mdp).check("states", states))
    if checked.ndim != 1 or not checked.size:
        raise InputError("states", found=f"shape {checked.shape}", wanted="(M,), one at least")
    return checked


def _weights(posterior: Posterior) -> Floats:
    """(G,) (E[n_g | O] + ηp_g) / (N + η)."""
    n, concentration = posterior.n_observations, posterior.concentration
    prior = np.exp(posterior.candidates.log_prior)
    return np.asarray((posterior.expected_shares * n + concentration * prior) / (n + concentration))


def _local_weights(posterior: Posterior, near: Floats) -> Floats:
    """(M, G) weights for κ (M, N), each row summing to one."""
    prior = posterior.concentration * np.exp(posterior.candidates.log_prior)
    weights = near @ posterior.shares + prior
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _blocks(rows: int, columns: int) -> list[slice]:
    """Consecutive rows of a table of which no more than ``MOST_DISTANCES`` entries are held."""
    size = max(1, MOST_DISTANCES // max(columns, 1))
    return [slice(start, min(start + size, rows)) for start in range(0, rows, size)]


def _distances(first: Floats, second: Floats) -> Floats:
    return np.asarray(np.linalg.norm(first[:, None] - second[None], axis=-1))


def _places(posterior: Posterior, states: Any) -> Floats:
    """(M, d) where states lie, as in the demonstrations."""
    checked = _checked(planned_source(posterior), states)
    return np.asarray(_coordinates(posterior)[checked])


def _coordinates(posterior: Posterior) -> Floats:
    """(S, d) of the demonstrations; without them nothing is near anything."""
    coordinates = posterior.demonstrations.coordinates
    if coordinates is None:
        raise InputError("demonstrations.coordinates", found="None", wanted="where states lie, to tell what is near",
                         hint="dataclasses.replace(demonstrations, coordinates=...) before learning")  # fmt: skip
    return np.asarray(coordinates)
