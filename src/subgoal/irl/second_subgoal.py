"""The confidence at which a second subgoal appears: thesis 7.3.1 without a sweep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.score_test import ScoreTest, score_test
from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError

RANGE = 1e-3, 1e4
"""Of the search, in units of the likelihood's own scale."""
STEP = 1.1
"""Between levels that are looked at: a second subgoal that comes and goes within a step is not seen."""
EXACT = 1e-9
"""Relative error of the answer."""


@dataclass(frozen=True)
class SecondSubgoal:
    """Where one candidate stops being the likeliest mixture.

    Attributes
    ----------
    confidence:
        α*: below it no mixture of candidates is likelier than the best one alone. Infinite where that holds up to the
        end of the search, 0 where it does not hold at its beginning.
    best, second:
        The candidate that was best alone, and the one that is worth adding just above α*; None if there is none.
    searched:
        From which confidence to which.
    """

    confidence: float
    best: int | None
    second: int | None
    searched: tuple[float, float]

    def __str__(self) -> str:
        low, high = self.searched
        if self.confidence == math.inf:
            return f"one subgoal is enough at every confidence up to {high:.3g}"
        if self.confidence == 0:
            return f"one subgoal is not enough even at the lowest confidence, {low:.3g}"
        return (
            f"a second subgoal appears at confidence {self.confidence:.4g}: candidate {self.second} beside {self.best}"
        )


def second_subgoal(likelihood: LogLikelihood, *, low: float | None = None, high: float | None = None) -> SecondSubgoal:
    """The smallest α at which max_g (1/N) Σ_i exp(ℓ_ig(α) − ℓ_i,best(α)) > 1: no sampling, no prior, no trials.

    Above it some mixture of candidates is likelier than the best one alone, since the log likelihood of a mixture is
    concave in its weights (``optima.score_test``). A sampler needs more: a second subgoal also has to pay for the prior
    of its assignments, so that a sweep finds it at a somewhat higher α.

    Parameters
    ----------
    likelihood:
        A table that knows other confidences.
    low, high:
        Ends of the search, in steps of 10 %, and then to nine digits; by default 10⁻³ and 10⁴ times its unit.

    Raises
    ------
    InputError
        A table of given numbers; ends that are not above zero or not in order.
    """
    if not isinstance(likelihood, LogLikelihood):
        raise InputError("likelihood", found=type(likelihood).__name__, wanted="a LogLikelihood")
    ends = _ends(likelihood, low, high)
    levels = np.geomspace(*ends, max(2, math.ceil(math.log(ends[1] / ends[0]) / math.log(STEP)) + 1)).tolist()
    below = None
    for level in levels:
        test = score_test(likelihood.at(level))
        if not test.one_suffices:
            return _between(likelihood, below, (level, test), ends)
        below = level, test
    return SecondSubgoal(math.inf, test.best, None, ends)


Tested = tuple[float, ScoreTest]


def _between(
    likelihood: LogLikelihood, below: Tested | None, above: Tested, ends: tuple[float, float]
) -> SecondSubgoal:
    """Halve the step between a level at which one is enough and one at which it is not."""
    if below is None:
        return SecondSubgoal(0.0, above[1].best, int(above[1].log_ratio.argmax()), ends)
    while above[0] > below[0] * (1 + EXACT):
        middle = math.sqrt(below[0] * above[0])
        test = score_test(likelihood.at(middle))
        below, above = ((middle, test), above) if test.one_suffices else (below, (middle, test))
    return SecondSubgoal(above[0], above[1].best, int(above[1].log_ratio.argmax()), ends)


def _ends(likelihood: LogLikelihood, low: Any, high: Any) -> tuple[float, float]:
    unit = likelihood.source.unit
    start = positive("low", RANGE[0] * unit if low is None else low)
    stop = positive("high", RANGE[1] * unit if high is None else high)
    if not start < stop:
        raise InputError("low and high", found=f"{start:g} and {stop:g}", wanted="one below the other")
    return start, stop
