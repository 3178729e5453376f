"""How exactly demonstrators act: one of them, and several side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid

from subgoal.runtime.checks import Floats

RESOLVED = 0.5
"""Steps between test actions that the density of actions must be wide: sums of a bell curve are right to 2 % there."""
OPEN = 0.05
"""Of the largest density: with more than that at its end a range is open there."""


@dataclass(frozen=True, eq=False, repr=False)
class Expertise:
    """The posterior of α of a demonstrator who was after one goal, flat in log α beforehand.

    Attributes
    ----------
    confidence:
        Its median: nats by which an action becomes less likely that throws away a unit of value.
    interval, level:
        α below and above which (1 − level)/2 is left.
    n_observations, worth:
        Observations, and how many independent ones they count for.
    confidences, density:
        (L,) levels evenly apart in log α, and the posterior density of log α there.
    goal, goal_probability:
        The likeliest candidate, and how sure it is.
    steps_wide:
        Standard deviation of the actions of the model in steps between test actions, in the narrowest dimension;
        infinite where the density needs no test actions.
    searched:
        Range of α.
    fine_enough:
        Whether it ends where it was meant to, and not where test actions are too far apart.
    """

    confidence: float
    interval: tuple[float, float]
    level: float
    n_observations: int
    worth: float
    confidences: Floats
    density: Floats
    goal: int
    goal_probability: float
    steps_wide: float
    searched: tuple[float, float]
    fine_enough: bool

    def __repr__(self) -> str:
        return f"Expertise({self})"

    def __str__(self) -> str:
        low, high = self.interval
        told = (
            f"confidence {self.confidence:.3g}, {100 * self.level:g} % from {low:.3g} to {high:.3g} "
            f"({self.n_observations:,} observations that count as {self.worth:,.0f})"
        )
        return f"{told}; {self.warning}" if self.warning else told

    @property
    def open_below(self) -> bool:
        """Whether α may be as small as the range goes: actions cannot be told from random ones."""
        return bool(self.confidences[0] <= self.searched[0] and self.density[0] > OPEN * self.density.max())

    @property
    def open_above(self) -> bool:
        """Whether α may be as large as the range goes."""
        return bool(self.confidences[-1] >= self.searched[1] and self.density[-1] > OPEN * self.density.max())

    @property
    def warning(self) -> str:
        """What keeps the number from being believed, and what to do; nothing if nothing does."""
        said = []
        if self.open_below:
            said.append("no lower end: the actions may as well be random")
        if self.open_above and self.fine_enough:
            said.append(f"no upper end: the range ends at {self.searched[1]:.2g}")
        elif self.open_above:
            said.append(
                f"no upper end: test actions are too far apart to tell more than {self.searched[1]:.3g}. Try: "
                "ContinuousWorld(..., test_actions=action_grid(low, high, n)) with a larger n"
            )
        return "; ".join(said)


@dataclass(frozen=True, eq=False, repr=False)
class ExpertiseTable:
    """Demonstrators side by side. Printed, it is a table, the most expert first.

    Attributes
    ----------
    of:
        Expertise of each by name.
    """

    of: Mapping[str, Expertise]

    def __repr__(self) -> str:
        return f"ExpertiseTable({len(self.of)} demonstrators)"

    def __str__(self) -> str:
        order = sorted(self.of, key=lambda name: -self.of[name].confidence)
        wide = max(len(name) for name in order)
        lines = []
        for k, name in enumerate(order):
            after = order[k + 1] if k + 1 < len(order) else None
            sure = "" if after is None else f"; more expert than {after} with probability {self.more(name, after):.3f}"
            lines.append(f"{name.ljust(wide)}  {self.of[name]}{sure}")
        return "\n".join(lines)

    def more(self, one: str, other: str) -> float:
        """Probability that the first has the larger α."""
        a, b = self.of[one], self.of[other]
        below = np.interp(np.log(a.confidences), np.log(b.confidences), distribution(b.confidences, b.density))
        whole = distribution(a.confidences, a.density * below)
        return float(whole[-1])

    @property
    def more_expert(self) -> Floats:
        """(K, K) probability that the demonstrator of a row has a larger α than that of a column; ½ with oneself."""
        names = list(self.of)
        out = np.full((len(names), len(names)), 0.5)
        for i, one in enumerate(names):
            for j in range(i):
                out[i, j] = self.more(one, names[j])
                out[j, i] = 1 - out[i, j]
        return out


def distribution(levels: Floats, density: Floats) -> Floats:
    """(L,) integral of a density of log α from the first level to each."""
    return np.asarray(cumulative_trapezoid(density, np.log(levels), initial=0))


def quantiles(levels: Floats, density: Floats, chances: tuple[float, ...]) -> list[float]:
    """α below which so much of a density of log α lies."""
    return [float(x) for x in np.exp(np.interp(chances, distribution(levels, density), np.log(levels)))]
