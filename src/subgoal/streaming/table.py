"""The likelihood table of action comparison while rows and columns come."""

from __future__ import annotations

from bisect import insort
from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import SLOW
from subgoal.likelihood.sources import Directions, Pace
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.checks import Bools, Floats
from subgoal.streaming.growing import Growing, with_room

FIRST_ROOM = 256, 64


class GrowingTable:
    """ℓ[i, g] = log p(a_i | s_i, g) as ``action_comparison`` has it, with candidates from a greedy net; it changes.

    Attributes
    ----------
    values:
        (N or more, G or more) the table, with room for more; so many rows and columns as there are pairs and
        candidates hold numbers.
    """

    def __init__(self, metric: Metric, radius: float, confidence: float) -> None:
        self._metric, self._radius, self.confidence = metric, radius, confidence
        self._states, self._actions = Growing(metric.dimension), Growing(metric.dimension)
        self._speed, self._slow, self._points = Growing(), Growing(dtype=bool), Growing(metric.dimension)
        self._moving: list[float] = []
        self._candidates: Candidates | None = None
        self.values: Floats = np.zeros(FIRST_ROOM)

    @property
    def n_pairs(self) -> int:
        """N."""
        return len(self._states)

    @property
    def n_candidates(self) -> int:
        """G."""
        return len(self._points)

    @property
    def moves(self) -> bool:
        """Whether any pair moves."""
        return bool(self._moving)

    @property
    def candidates(self) -> Candidates:
        """The G candidates so far, in order of arrival, uniform; ``InputError`` before the first."""
        if self._candidates is None:
            self._candidates = Candidates(self._points.rows.copy(), radius=self._radius, metric=self._metric)
        return self._candidates

    @property
    def states(self) -> Floats:
        """(N, d)."""
        return self._states.rows

    @property
    def actions(self) -> Floats:
        """(N, d)."""
        return self._actions.rows

    @property
    def slow(self) -> Bools:
        """(N,) pairs that say nothing of a goal, by the median speed so far."""
        return self._slow.rows

    def offer(self, place: Floats, *, is_end: bool = False) -> None:
        """Make (d,) a candidate if it is farther than the radius from all, an end if it is none already."""
        limit = 0.0 if is_end else self._radius
        if self.n_candidates and not (self._metric.distance(self._points.rows, place) > limit).all():
            return
        self._points.extend(place[None])
        self._candidates = None
        g, n = self.n_candidates, self.n_pairs
        self.values = with_room(self.values, n, g)
        if n:
            alone = Candidates(place[None], radius=self._radius, metric=self._metric)
            self.values[:n, g - 1] = self._density(slice(0, n), alone)[:, 0]

    def add(self, state: Floats, action: Floats) -> None:
        """One more pair, (d,) and (d,); rows that the median speed now calls slow, or no longer, are written anew."""
        self._states.extend(state[None])
        self._actions.extend(action[None])
        speed = self._speeds(action[None])
        self._speed.extend(speed)
        self._slow.extend([True])
        if speed[0] > 0:
            insort(self._moving, float(speed[0]))
        self.values = with_room(self.values, self.n_pairs, self.n_candidates)
        self._judge([self.n_pairs - 1])

    def put_right(self, first: int, states: Floats, actions: Floats) -> None:
        """Pairs from row ``first`` on are (m, d) and (m, d), which is told when their trajectory is over."""
        rows = slice(first, first + len(states))
        before = (self._states.rows[rows], self._actions.rows[rows])
        changed = np.flatnonzero(((before[0] != states) | (before[1] != actions)).any(axis=1))
        if not changed.size:
            return
        self._states.rows[rows], self._actions.rows[rows] = states, actions
        self._speed.rows[rows] = self._speeds(actions)
        speed = self._speed.rows
        self._moving = sorted(speed[speed > 0].tolist())
        self._judge((first + changed).tolist())

    def retune(self, confidence: float) -> None:
        """Another α for all."""
        self.confidence = confidence
        if self.n_pairs:
            self._write(np.arange(self.n_pairs))

    def likelihood(self, demonstrations: Demonstrations, candidates: Candidates) -> LogLikelihood:
        """The table as a record, for the pairs and candidates of the records given, which are these."""
        n, g = self.n_pairs, self.n_candidates
        source = self._source(slice(0, n), self.candidates)
        record = LogLikelihood(source, self.confidence, candidates, demonstrations)
        record.hold(self.values[:n, :g].copy())
        return record

    def _judge(self, new: list[int]) -> None:
        """Say anew who is slow, and write the rows ``new`` and those of which that changed."""
        slow = self._speed.rows < SLOW * self._median
        changed = np.flatnonzero(slow != self._slow.rows)
        self._slow.rows[:] = slow
        self._write(np.union1d(changed, new))

    def _write(self, rows: Any) -> None:
        self.values[rows, : self.n_candidates] = self._density(rows, self.candidates)

    @property
    def _median(self) -> float:
        """Of the speeds above zero; infinite, so that all are slow, where there is none."""
        count = len(self._moving)
        return (self._moving[(count - 1) // 2] + self._moving[count // 2]) / 2 if count else np.inf

    def _speeds(self, actions: Floats) -> Floats:
        return np.asarray(np.linalg.norm(actions * self._metric.weights, axis=1))

    def _source(self, rows: Any, candidates: Candidates) -> Directions:
        top = self._moving[-1] if self._moving else 0.0
        pace = Pace(self._metric.weights, self._median, top, self._slow.rows[rows].copy())
        return Directions.of(self._states.rows[rows], self._actions.rows[rows], candidates, pace)

    def _density(self, rows: Any, candidates: Candidates) -> Floats:
        source = self._source(rows, candidates)
        return source.log_density(0, len(source.units), self.confidence)
