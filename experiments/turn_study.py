"""Right turns at the wheel of the model car: three radii in one drive, or one turn held; what the experiments share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

import subgoal
from experiments.car_study import LEAST_SHARE, Labels, Run
from subgoal.continuous import ContinuousWorld, GaussianSmoother, gp_actions
from subgoal.dynamics.car import ALL_DRIVE
from subgoal.dynamics.driver import turns
from subgoal.irl.confidence_sweep import LASTING, Form
from subgoal.irl.gpsrl import CONCENTRATION
from subgoal.irl.sweep_record import Sweep
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Chain, Sampler
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream
from subgoal.samplers import alg4_corrected, annealed

STEP = 0.2
RADIUS = 0.25
"""Of the net: at the 0.35 of figure 7-6 three steady turns leave four states, one fewer than planning needs."""
SMOOTHER = GaussianSmoother(noise=0.2)
"""Twice the noise of figure 7-6: states so near each other would keep values from settling."""
LEVELS = np.array([1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 100, 300, 1000], float)
PLATEAU = (15.0, 20.0)
"""The confidences that figure 7-6 works with."""
THREE = 3


@dataclass(frozen=True)
class Method:
    """A sampler, the sweeps of a chain, what is made of the table, and the filter of candidates."""

    sampler: Sampler
    sweeps: int
    form: Form | None = None
    hold: float | None = None


METHODS = {
    "temporal": Method(LASTING, 300),
    "exchangeable": Method(annealed, 300),
    "thesis, with filter": Method(alg4_corrected, 1500, literal_maximum, 0.5),
}


@dataclass(frozen=True, eq=False)
class Turns:
    """One drive of three radii, and its tables."""

    noise: float
    seed: int

    @cached_property
    def run(self) -> Run:
        """The recording."""
        return Run(turns(ALL_DRIVE, noise=self.noise, seed=self.seed), ALL_DRIVE)

    def table(self, hold: float | None = None) -> LogLikelihood:
        """By Gaussian-process planning, candidates that cannot be held left out."""
        run = self.run
        net = subgoal.epsilon_net(run.pairs, RADIUS, metric=run.metric)
        world = ContinuousWorld(run.model, *run.model.bounds, step=STEP)
        return gp_actions(run.pairs, net, world, smoother=SMOOTHER, hold=hold)


def last_draws(table: LogLikelihood, method: Method, level: int, trials: int, seed: int) -> list[Labels]:
    """Of as many chains, as ``confidence_sweep`` has them: (N,) candidates at a level of ``LEVELS``."""
    at = table.at(float(LEVELS[level]))
    at = at if method.form is None else method.form(at)
    keep = np.zeros(method.sweeps, bool)
    keep[-1] = True
    return [
        method.sampler(Chain(at, CONCENTRATION, stream(seed, level, k)), keep).assignments[-1] for k in range(trials)
    ]


def as_sweep(counts: Any) -> Sweep:
    """Counts (L, trials over all drives) as a sweep, for its plateau."""
    return Sweep(LEVELS, np.asarray(counts), np.empty(0), {"least_share": LEAST_SHARE}, 0.0)


def of_plateau(values: Floats) -> Floats:
    """Those of (L, ...) at the confidences of figure 7-6."""
    return values[np.isin(LEVELS, PLATEAU)]
