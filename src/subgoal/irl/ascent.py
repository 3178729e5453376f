"""Weights of greatest objective, by L-BFGS with exact gradients: the search that the maximum entropy methods share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.optimize import minimize

from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import PlanningError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

OUT_OF_DOMAIN = 1e12
"""Stands for minus infinity, per observation, where values of a reward are not finite."""


class Objective(Protocol):
    """What is to be made as great as possible."""

    def __call__(self, weights: Floats) -> tuple[float, Floats]:
        """Its value and its gradient (F,); raises ``PlanningError`` where it is minus infinity."""


@dataclass(frozen=True, eq=False)
class Ascent:
    """Where a search ended.

    Attributes
    ----------
    weights, value, gradient:
        (F,) of greatest objective found, the objective there and its gradient (F,).
    outcome:
        CONVERGED where no entry of the gradient is above the tolerance times the size.
    solutions:
        Evaluations of the objective.
    trace:
        (T, F) the weights of each step, the first ones included.
    """

    weights: Floats
    value: float
    gradient: Floats
    outcome: Outcome
    solutions: int
    trace: Floats


def climb(
    objective: Objective,
    start: Floats,
    *,
    size: float,
    tolerance: float,
    most_iterations: int,
    progress: Progress | None = None,
) -> Ascent:
    """Maximise ``objective`` from ``start`` until no entry of its gradient exceeds ``tolerance`` times ``size``."""
    steps = _Steps(objective, start, size)
    with Interrupt() as interrupt, progress or Silent() as display:

        def step(weights: Any) -> None:
            steps.trace.append(weights.copy())
            display.update(len(steps.trace) - 1, most_iterations, f"gradient {steps.slope(weights):.1e}")
            if interrupt.requested:
                raise StopIteration

        options: dict[str, Any] = {"maxiter": most_iterations, "maxfun": 20 * most_iterations, "gtol": tolerance,
                                   "ftol": 0.0, "maxls": 50}  # fmt: skip
        search: Any = minimize
        found = search(steps.downhill, start, jac=True, method="L-BFGS-B", callback=step, options=options)
        interrupted = interrupt.requested
    weights = np.asarray(found.x)
    if steps.slope(weights) <= tolerance:
        outcome = Outcome.CONVERGED
    elif interrupted:
        outcome = Outcome.INTERRUPTED
    else:
        outcome = Outcome.OUT_OF_ITERATIONS if found.nit >= most_iterations else Outcome.STALLED
    value, gradient = steps.at(weights)
    return Ascent(weights, value, gradient, outcome, steps.solutions, np.array(steps.trace))


class _Steps:
    """The objective turned round, its last evaluation remembered."""

    def __init__(self, objective: Objective, start: Floats, size: float) -> None:
        self._objective, self._size = objective, size
        self.trace = [start.copy()]
        self.solutions = 0
        self._last: tuple[Floats, float, Floats] | None = None

    def at(self, weights: Floats) -> tuple[float, Floats]:
        """Value and gradient."""
        if self._last is None or not np.array_equal(self._last[0], weights):
            self.solutions += 1
            self._last = (weights.copy(), *self._objective(weights))
        return self._last[1], self._last[2]

    def slope(self, weights: Floats) -> float:
        """Largest entry of the gradient, per size."""
        return float(np.abs(self.at(weights)[1]).max() / self._size)

    def downhill(self, weights: Any) -> tuple[float, Floats]:
        """Minus objective and gradient, per size; out of the domain, a wall that leads back to the last step."""
        try:
            value, gradient = self.at(weights)
        except PlanningError:
            if len(self.trace) == 1 and np.array_equal(weights, self.trace[0]):
                raise
            back = weights - self.trace[-1]
            return OUT_OF_DOMAIN, back * (OUT_OF_DOMAIN / max(float(back @ back), 1e-300))
        return -value / self._size, -gradient / self._size
