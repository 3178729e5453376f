"""Ways to cut a drive into manoeuvres: GPSRL in three forms, an oracle, and four that plan nothing."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from sklearn.cluster import KMeans
from sklearn.mixture import BayesianGaussianMixture

import subgoal
from experiments.car_study import Judged, Run
from subgoal.candidates import Candidates
from subgoal.continuous import ContinuousWorld, gp_actions
from subgoal.irl.gpsrl import RADIUS
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.models import Persistent
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats, Ints
from subgoal.samplers import alg4_corrected

STEP, DWELL = 0.2, 4.0
KEEP = math.exp(-STEP / DWELL)
THESIS_CONFIDENCE = 25.0
"""α of thesis 7.3, for a reward of 1 in every step."""
THESIS_HOLD = 0.5
SCALES = (0.075, 0.15, 0.3, 0.6)
"""Of proximity, in units of the metric."""
SWEEPS: dict[str, Any] = {"chains": 2, "warmup": 50, "draws": 50, "thin": 1}
COMPONENTS = 15


def temporal(run: Run, seed: int) -> tuple[Judged, Posterior]:
    """GPSRL with subgoals that persist: 100 sweeps in each of two chains, the best draw."""
    found = _quietly(subgoal.gpsrl, run.pairs, run.model, metric=run.metric, seed=seed, **SWEEPS)
    return run.judged(found.best_assignment, found.candidates.points), found


def exchangeable(run: Run, seed: int) -> Judged:
    """GPSRL in which order says nothing, α = 30: annealed chains, the most probable subgoal of each pair."""
    found = _quietly(
        subgoal.gpsrl, run.pairs, run.model, metric=run.metric, seed=seed, dwell=0, chains=2, warmup=75, draws=75,
        thin=1,
    )  # fmt: skip
    return run.judged(marginal_modes(found), found.candidates.points)


def thesis(run: Run, seed: int, hold: float = 0.0) -> Judged:
    """Thesis 6.2 to 6.5: (6.2) with its maximum, one cluster to begin with, 200 sweeps, η = 0.001, α = 25 (r = 1)."""
    net = subgoal.epsilon_net(run.pairs, RADIUS, metric=run.metric)
    world = ContinuousWorld(run.model, *run.model.bounds, step=STEP)
    try:
        table = gp_actions(run.pairs, net, world, confidence=THESIS_CONFIDENCE / (1 - world.discount), hold=hold)
    except subgoal.SubgoalError:
        return run.judged(np.zeros(run.pairs.n_observations, np.int64))
    found = _quietly(
        subgoal.sample, literal_maximum(table), concentration=0.001, sampler=alg4_corrected, chains=1, warmup=100,
        draws=100, thin=1, seed=seed,
    )  # fmt: skip
    return run.judged(marginal_modes(found), table.candidates.points)


def thesis_with_filter(run: Run, seed: int) -> Judged:
    """The same, candidates that cannot be held left out."""
    return thesis(run, seed, THESIS_HOLD)


def oracle(run: Run, seed: int) -> Judged:
    """The temporal form with only the six candidates nearest to the true steady states."""
    net = subgoal.epsilon_net(run.pairs, RADIUS, metric=run.metric)
    nearest = np.unique(run.metric.distance(net.points[:, None], run.truth[None]).argmin(axis=0))
    found = _quietly(
        subgoal.gpsrl, run.pairs, run.model, candidates=net.some(nearest), support=net, hold=0.0, seed=seed, **SWEEPS
    )
    return run.judged(found.best_assignment, found.candidates.points)


def k_means(run: Run, seed: int, parts: str) -> Judged:
    """Clusters of states, actions or both, their number given: no goals, no plans, no time."""
    label = KMeans(6, n_init=20, random_state=seed).fit_predict(_features(run, parts))
    return run.judged(label)


def gaussian_mixture(run: Run, seed: int) -> Judged:
    """A Dirichlet-process mixture of Gaussians over states and actions, its number of clusters not given."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        label = BayesianGaussianMixture(
            n_components=COMPONENTS, weight_concentration_prior_type="dirichlet_process",
            weight_concentration_prior=1.0, max_iter=300, n_init=1, random_state=seed,
        ).fit_predict(_features(run, "states and actions"))  # fmt: skip
    return run.judged(label)


def proximity(run: Run, seed: int, parts: str, scale: float) -> Judged:
    """The same temporal model with a Gaussian about each candidate pair in place of plans."""
    features = _features(run, parts)
    d = features.shape[1]
    net = subgoal.epsilon_net(subgoal.Demonstrations.from_arrays(features, features), RADIUS)
    square = ((features[:, None] - net.points[None]) ** 2).sum(axis=2)
    log_density = -square / (2 * scale**2) - d * math.log(scale * math.sqrt(2 * math.pi))
    table = subgoal.LogLikelihood.from_table(
        log_density, candidates=Candidates(points=net.points), demonstrations=replace(run.pairs)
    )
    found = _quietly(subgoal.sample, table, concentration=0.001, model=Persistent(keep=KEEP), seed=seed, **SWEEPS)
    return run.judged(found.best_assignment)


def marginal_modes(posterior: Posterior) -> Ints:
    """(N,) the most probable candidate of each pair on its own: the best joint draw of the exchangeable model would
    rather have one subgoal too few, as every further one costs N times the entropy of the shares."""
    return np.asarray(np.asarray(posterior.shares.todense()).argmax(axis=1))


def _features(run: Run, parts: str) -> Floats:
    """(N, ...) states in units of the metric, actions in units of half their range, or both."""
    states = np.asarray(run.pairs.states) * run.metric.weights
    low, high = run.model.bounds
    actions = np.asarray(run.pairs.actions) / ((high - low) / 2)
    return {"states": states, "actions": actions}.get(parts, np.hstack([states, actions]))


def _quietly(function: Any, *given: Any, **named: Any) -> Posterior:
    """A hundred sweeps find the subgoals; they are too few to pass the gate, which is not what is asked here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        found: Posterior = function(*given, **named)
    return found
