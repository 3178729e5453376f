"""What the experiments with the model car share: drivers, what is learned of them, and how it is judged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from sklearn.metrics import adjusted_rand_score, v_measure_score

from subgoal.continuous import held_rows, hold_actions, spread_metric
from subgoal.demonstrations import Demonstrations, Metric
from subgoal.dynamics.car import ALL_DRIVE, REAR_DRIVE, Car
from subgoal.dynamics.driver import Driven, drive
from subgoal.runtime.checks import Floats, Ints

Labels = NDArray[np.integer[Any]]
EVERY = 20
"""Samples at 100 Hz that one held action lasts: 0.2 s."""
FLOOR = np.array([0.5, 0.4, 1.0, 0.5])
"""Least differences that matter, in m/s, m/s, rad/s and m/s."""
LEAST_SHARE = 0.03
"""Of the time: subgoals that serve less are not counted."""


@dataclass(frozen=True, eq=False)
class Condition:
    """A car, how it is driven, and the friction that the planner believes in as a share of the true one."""

    car: Car
    driving: dict[str, Any]
    believed: float = 1.0

    @property
    def model(self) -> Car:
        """The car as the planner knows it."""
        return replace(self.car, friction=self.believed * self.car.friction)

    def run(self, seed: int) -> Run:
        """One driver."""
        return Run(drive(self.car, seed=seed, **self.driving), self.model)


CONDITIONS = {
    "AWD n1": Condition(ALL_DRIVE, {}),
    "AWD n2": Condition(ALL_DRIVE, {"noise": 2.0}),
    "AWD open": Condition(ALL_DRIVE, {"feedback": False}),
    "AWD shuffled": Condition(ALL_DRIVE, {"order": "shuffled"}),
    "RWD n1": Condition(REAR_DRIVE, {}),
    "RWD n1.5": Condition(REAR_DRIVE, {"noise": 1.5}),
    "RWD shuffled": Condition(REAR_DRIVE, {"order": "shuffled"}),
    "RWD friction −15 %": Condition(REAR_DRIVE, {}, believed=0.85),
}
"""All or rear wheels driven; the driver's noise; no feedback; manoeuvres in random order; a planner that is wrong."""


@dataclass(frozen=True, eq=False)
class Run:
    """A recording at 100 Hz with its script, and what is made of it."""

    driven: Driven
    model: Car

    @cached_property
    def pairs(self) -> Demonstrations:
        """A state every 0.2 s and the mean action until the next."""
        return hold_actions(self.driven.demonstrations, EVERY)

    @cached_property
    def metric(self) -> Metric:
        """In units of the spread of each dimension, or of the least difference that matters."""
        return spread_metric(np.asarray(self.driven.demonstrations.states), floor=FLOOR)

    @cached_property
    def truth(self) -> Floats:
        """(6, 4) the steady states the driver was after."""
        return np.array([place.state for place in self.driven.places.values()])

    def at_full_rate(self, label: Labels) -> Ints:
        """Labels (N,) of the pairs, held until the next."""
        return np.asarray(label[held_rows(self.driven.demonstrations, EVERY)])

    def judged(self, label: Labels, points: Floats | None = None) -> Judged:
        """Labels (N,) of the pairs against the script; ``points`` (G, 4) of the subgoals against the steady states."""
        fine, script = self.at_full_rate(label), self.driven.labels
        used, count = np.unique(label, return_counts=True)
        main = used[count >= LEAST_SHARE * label.size]
        v, ari = v_measure_score(script, fine), adjusted_rand_score(script, fine)
        if points is None:
            return Judged(len(main), float(v), float(ari), False, np.nan)
        distance = self.metric.distance(points[main][:, None], self.truth[None])
        rows, columns = linear_sum_assignment(distance)
        one_to_one = len(main) == len(self.truth) == len(set(distance.argmin(axis=1).tolist()))
        apart = float(np.sqrt((distance[rows, columns] ** 2).mean()))
        return Judged(len(main), float(v), float(ari), one_to_one, apart)


@dataclass(frozen=True)
class Judged:
    """How many subgoals serve at least 3 % of the time; V-measure and adjusted Rand index per 100 Hz step; whether each
    subgoal has a steady state of its own, and the root mean square distance to them in units of the metric."""

    subgoals: int
    v: float
    ari: float
    one_to_one: bool
    apart: float


Method = Callable[[Run, int], Judged]


def summed(rows: list[Judged]) -> dict[str, Any]:
    """Means, least values and counts over drivers."""
    v = np.array([row.v for row in rows])
    return {
        "v_measure": v.mean(), "v_measure_min": v.min(), "ari": np.mean([row.ari for row in rows]),
        "n_subgoals": [row.subgoals for row in rows], "six_of": [sum(row.subgoals == 6 for row in rows), len(rows)],
        "one_to_one_of": [sum(row.one_to_one for row in rows), len(rows)],
        "apart": float(np.max([row.apart for row in rows])),
    }  # fmt: skip
