"""A source of numbers that are already there."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from subgoal.likelihood.source import Assigned, Confidence
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False)
class FixedTable:
    """A source of numbers that are already there."""

    values: Floats
    kind: str = field(default="table", init=False)
    unit: float = field(default=1.0, init=False)

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) rows in which every candidate is equally likely."""
        return np.asarray((self.values == self.values[:, :1]).all(axis=1))

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """Rows as given; only confidence 1 is known of such a table."""
        if np.ndim(confidence) or confidence != 1.0:
            raise InputError("confidence", found=confidence, wanted="1, for a table of given numbers")
        return self.values[start:stop]

    def log_flat(self, start: int, stop: int) -> Floats:
        """Nothing is known of actions."""
        raise InputError("background", found="a table of given numbers", wanted="a likelihood that knows its actions",
                         hint="add a column of your own")  # fmt: skip

    def assigned(self, theta: Ints) -> Assigned:
        """Nothing is known of other confidences."""
        raise InputError("confidence", found="a table of given numbers", wanted="a likelihood that knows its noise",
                         hint="leave confidence as it is")  # fmt: skip

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> None:
        """No shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Nothing is known of places."""
        return np.zeros(self.values[start:stop].shape, bool)

    def distance_law(self, confidence: float) -> None:
        """Nothing is known of distances."""
