"""What is asked of recordings without labels: forecasts, bits, and whether the answer is the same again."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from sklearn.metrics import adjusted_rand_score, v_measure_score

import subgoal
from experiments.car_methods import marginal_modes
from experiments.car_study import Labels
from subgoal.candidates import Candidates
from subgoal.demonstrations import Demonstrations, Metric
from subgoal.demonstrations.held import time_step
from subgoal.dynamics import Dynamics, learn_dynamics
from subgoal.gaussian.factor import RegressionWarning
from subgoal.irl.gpsrl import RADIUS
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats, Ints

LEAST_SHARE = 0.05
"""Of the pairs: subgoals that serve fewer are not counted."""


def quietly(function: Callable[..., Any], *args: Any, **settings: Any) -> Any:
    """Without the warnings of short chains and of lengths that data do not tell."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        warnings.simplefilter("ignore", RegressionWarning)
        return function(*args, **settings)


@dataclass(frozen=True, eq=False)
class Settings:
    """How subgoals are learned of pairs: metric, bounds of the actions, and what ``gpsrl`` is given beside."""

    metric: Metric
    bounds: tuple[Floats, Floats]
    learning: dict[str, Any]
    radius: float = RADIUS

    def learn(self, pairs: Demonstrations, dynamics: Dynamics, seed: int) -> Posterior:
        """The subgoals of the pairs."""
        found: Posterior = quietly(
            subgoal.gpsrl, pairs, dynamics, bounds=self.bounds, metric=self.metric, radius=self.radius, seed=seed,
            **self.learning,
        )  # fmt: skip
        return found

    def cut(self, pairs: Demonstrations, dynamics: Dynamics, goals: Candidates, support: Candidates) -> Ints:
        """(N,) which of given goals each pair most probably serves, with the same dynamics, model and plans."""
        found = quietly(
            subgoal.gpsrl, pairs, dynamics, bounds=self.bounds, candidates=goals, support=support, hold=0.0, seed=0,
            **self.learning,
        )  # fmt: skip
        return marginal_modes(found)


@dataclass(frozen=True, eq=False)
class Answer:
    """Pairs, the dynamics believed in, what was learned, and the pairs as its main subgoals cut them (N,)."""

    pairs: Demonstrations
    dynamics: Dynamics
    found: Posterior
    goals: Candidates
    support: Candidates
    label: Ints

    @property
    def shares(self) -> Floats:
        """(K,) share of the pairs that each main subgoal serves."""
        return np.asarray(np.bincount(self.label, minlength=self.goals.n_candidates) / self.label.size)


def answer(pairs: Demonstrations, dynamics: Dynamics, settings: Settings, seed: int) -> Answer:
    """The main subgoals of the best draw, and the cut that they make; those that it leaves too little are dropped."""
    found = settings.learn(pairs, dynamics, seed)
    support = subgoal.epsilon_net(pairs, settings.radius, metric=settings.metric)
    goals = found.candidates.some(main_of(found.best_assignment))
    while True:
        label = settings.cut(pairs, dynamics, goals, support)
        kept = main_of(label)
        if kept.size == goals.n_candidates:
            return Answer(pairs, dynamics, found, goals, support, label)
        goals = goals.some(kept)


def main_of(label: Labels) -> Ints:
    """Those that serve at least 5 % of the pairs (N,); the one that serves most where none does."""
    used, count = np.unique(label, return_counts=True)
    main = used[count >= LEAST_SHARE * label.size]
    return np.asarray(main if main.size else used[[count.argmax()]])


def matched(a: Answer, b: Answer, metric: Metric) -> tuple[Floats, Floats]:
    """Distances (min(K, L),), sorted, between the subgoals of two answers one to one, and (K,) of those of ``a`` to
    the nearest of ``b``."""
    apart = metric.distance(a.goals.points[:, None], b.goals.points[None])
    return np.sort(apart[linear_sum_assignment(apart)]), apart.min(axis=1)


def agreement(one: Labels, other: Labels) -> dict[str, float]:
    """V-measure and adjusted Rand index of two cuts of the same pairs."""
    return {"v_measure": float(v_measure_score(one, other)), "ari": float(adjusted_rand_score(one, other))}


def forecast_error(
    learned: Demonstrations, asked: Demonstrations, *, step: float, horizon: float, told: tuple[str, ...], **how: Any
) -> tuple[Floats, Floats]:
    """Squared errors and squared changes (n, len(told)) over ``horizon`` where nothing was learned from.

    Dynamics of ``step`` learned of one recording foretell the other, one piece, from states two samples apart under
    its own commands.
    """
    model = quietly(learn_dynamics, learned, step=step, **how)
    states, actions = np.asarray(asked.states), np.asarray(asked.actions)
    every, whole = (round(span / time_step(asked)) for span in (step, horizon))
    begin = np.arange(0, len(states) - whole, 2)
    at = states[begin]
    for k in range(0, whole, every):
        held = actions[begin[:, None] + k + np.arange(every)].mean(axis=1)
        at = model(at, held, step)
    kept = [asked.names.index(name) for name in told]
    after, before = states[begin + whole][:, kept], states[begin][:, kept]
    return (at[:, kept] - after) ** 2, (after - before - (after - before).mean(axis=0)) ** 2


def planned(found: Posterior) -> dict[str, float]:
    """Residuals of the sweeps and of the Bellman equation at other states."""
    source = found.known_likelihood.source
    if not isinstance(source, GaussianProcessValues):
        raise TypeError("a posterior of gpsrl was expected")
    held_out = source.bellman_residuals()
    return {
        "sweeps": float(source.plan.residual), "mean": float(held_out.mean()), "largest": float(held_out.max()),
    }  # fmt: skip
