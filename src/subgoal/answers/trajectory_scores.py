"""Scores of whole trajectories: their mean per decision, its error, and how two models differ on the same ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from subgoal.runtime.checks import Floats, Ints, positive
from subgoal.runtime.errors import InputError

INTERVAL = 0.95


class Difference(NamedTuple):
    """Bits per decision of one model less those of another on the same trajectories; above 0 the first is better.

    ``interval`` is Student's, over the trajectories, for their mean difference.
    """

    bits_per_decision: float
    standard_error: float
    interval: tuple[float, float]


@dataclass(frozen=True, eq=False, repr=False)
class TrajectoryScores:
    """How well each trajectory was foretold by what did not see it.

    Attributes
    ----------
    log_predictive:
        (D,) log probability (density, where actions are continuous) of all actions of each trajectory, nats.
    decisions:
        (D,) observations of each.
    """

    log_predictive: Floats
    decisions: Ints

    def __repr__(self) -> str:
        told = f"{self.bits_per_decision:.3f} ± {self.standard_error:.3f} bits per decision"
        return f"{type(self).__name__}({told}, {self.decisions.size} trajectories)"

    @property
    def bits_per_decision(self) -> float:
        """Mean log₂ predictive probability over all decisions."""
        return float(self.log_predictive.sum() / self.decisions.sum() / np.log(2))

    @property
    def standard_error(self) -> float:
        """Of ``bits_per_decision``, over trajectories; NaN for one."""
        return standard_error(self.log_predictive, self.decisions) / float(np.log(2))

    def difference(self, other: TrajectoryScores, *, probability: float = INTERVAL) -> Difference:
        """By how much this is better than ``other`` on the same trajectories, pair by pair.

        What trajectories have in common cancels. Trajectories share most of what they are foretold from, which the
        error does not know of: with few of them it is too small. Raises ``InputError`` for other trajectories.
        """
        from scipy.stats import t as student

        if not np.array_equal(self.decisions, other.decisions):
            raise InputError("other", found=f"{other.decisions.size} trajectories of other lengths",
                             wanted="scores of the same trajectories")  # fmt: skip
        share = positive("probability", probability)
        if share >= 1:
            raise InputError("probability", found=share, wanted="above 0 and below 1")
        gained = self.log_predictive - other.log_predictive
        mean = float(gained.sum() / self.decisions.sum() / np.log(2))
        error = standard_error(gained, self.decisions) / float(np.log(2))
        reach = float(student.ppf(0.5 + share / 2, max(gained.size - 1, 1))) * error
        return Difference(mean, error, (mean - reach, mean + reach))


def standard_error(total: Floats, decisions: Ints) -> float:
    """Of Σ total / Σ decisions over independent trajectories: a ratio, to first order; NaN for one trajectory."""
    count = total.size
    if count < 2:
        return float("nan")
    residual = total - decisions * (total.sum() / decisions.sum())
    return float(np.sqrt(count / (count - 1) * (residual @ residual)) / decisions.sum())
