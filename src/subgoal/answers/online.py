"""Which subgoal is served now, told after every step of a recording that is still going on."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.answers.filtering import DRAWS, averaged, some_draws
from subgoal.likelihood.again import Steps
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.laws import Laws, Rows, draw_laws
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints

NOWHERE = np.empty(0, np.int64)


class OnlineFilter:
    """The filter of one trajectory, step by step; says what ``filtering`` says of the whole recording, at once.

    Unlike most things here it changes: ``step`` takes it one action on, ``restart`` to a new trajectory.

    Attributes
    ----------
    probability:
        (G,) p(candidate g is served now | actions so far, O); the rest to one is the background. None before a step.
    log_predictive:
        log p(last action | the actions before it in the trajectory, O), nats; NaN before a step.
    """

    def __init__(self, laws: Laws, steps: Steps, places: int) -> None:
        self._laws, self._steps, self._places = laws, steps, places
        self.restart()

    @classmethod
    def start(cls, posterior: Posterior, *, draws: int = DRAWS, seed: int = 0) -> OnlineFilter:
        """A filter before its first step; ``draws`` and ``seed`` as in ``filtering``.

        Raises ``InputError`` for groups, for a posterior without its likelihood and for a table of given numbers, and
        ``BudgetError`` where the action values of all states of a discrete world would need more than 4 GiB.
        """
        steps = Steps(posterior.known_likelihood)
        return cls(draw_laws(posterior, some_draws(posterior, draws), seed), steps, posterior.candidates.n_candidates)

    def restart(self) -> None:
        """Begin a new trajectory: what came before is forgotten."""
        self._entering: Floats | None = None
        self._so_far = np.zeros(self._laws.n_draws)
        self.probability: Floats | None = None
        self.log_predictive = float("nan")

    def step(self, state: Any, action: Any) -> Floats:
        """(G,) p(candidate g is served now | actions so far, this one included), and the same as ``probability``.

        Parameters
        ----------
        state, action:
            (d,) position and (k,) velocity in the units of the demonstrations, or two integers in a discrete world.

        Raises ``InputError`` for what does not fit, and for an action that no candidate allows; the filter is then
        where it was.
        """
        table = self._steps.table(state, action)
        first = np.array([self._entering is None])
        rows = Rows(table.relative_tile(*next(table.tiles())), first, *self._there(table))
        draws, size = self._laws.n_draws, table.n_candidates
        out, log_total, mean = np.empty((draws, 1, size)), np.empty((draws, 1)), np.zeros((1, self._places))
        self._laws.filter(rows, np.zeros((draws, size)) if self._entering is None else self._entering, out, log_total)
        log_total += table.log_marginal
        predictive, self._so_far = averaged(self._so_far, first, out, log_total, mean)
        self._entering, self.probability, self.log_predictive = out[:, 0], mean[0], float(predictive[0])
        return self.probability

    def _there(self, table: LogLikelihood) -> tuple[Ints, Ints]:
        """Which candidates the state is at, as ``Rows`` has it."""
        if not self._laws.minds_arrival:
            return np.zeros(2, np.int64), NOWHERE
        there = np.flatnonzero(table.source.arrived(0, 1)[0])
        return np.array([0, there.size]), there
