"""``Stream``: the subgoals of a recording that is still going on, learned anew after every point."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.answers.segments import OTHER, Segments, segments
from subgoal.answers.subgoals import MERGE_RADII, Subgoals, subgoals
from subgoal.candidates import Candidates
from subgoal.demonstrations.angles import wrapped
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import DEFAULT_CONFIDENCE
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats, positive, text, whole
from subgoal.runtime.errors import InputError
from subgoal.streaming.chains import KEPT, Chains
from subgoal.streaming.door import checked_confidence, checked_sample, columns, fitting
from subgoal.streaming.draws import Target, drawn, of_late
from subgoal.streaming.growing import Growing
from subgoal.streaming.table import GrowingTable
from subgoal.streaming.track import Pairs, Track
from subgoal.streaming.trajectories import Trajectories

DRAWS, WARMUP, THIN = 500, 100, 2
"""Of ``posterior``: the chains are where the data have brought them."""


class Stream:
    """Subgoals while a recording is going on: the posterior of ``subgoal.sample``, kept up with every sample.

    Unlike most things here it changes: every method but ``demonstrations``, ``candidates`` and ``likelihood`` moves it
    on, and it is for one thread at a time. Two streams told the same in the same order with the same ``seed`` say the
    same. One that is given something wrong raises ``InputError`` and is as it was.

    Parameters
    ----------
    dimension:
        Columns of a place d; or give their ``names``.
    radius:
        ε above 0, in units of the metric: a place farther than this from all candidates becomes one, as it comes.
    confidence, concentration:
        α of (5.1) and η of (2.8), both above 0.
    rate:
        Samples per ``time_unit`` to resample to, on the fly; None leaves them as they are.
    window:
        Samples that a velocity spans, after resampling, at least 2: from w//2 before to w − w//2 after.
    max_gap:
        Two samples farther apart than this many ``time_unit`` are of different pieces of a trajectory; None never cuts.
    metric:
        Weights and periods of the dimensions. What wraps goes the shorter way round, and lies from 0 to its period, or
        around 0 once a coordinate below 0 came, as ``demonstrate`` has it.
    units, time_unit:
        Of places and times, for tables and pictures.
    source:
        Where the samples come from, in words.
    chains, seed:
        Chain k depends on the data, on what was asked when, on ``seed`` and on k alone.
    """

    def __init__(
        self,
        dimension: int | None = None,
        *,
        names: Sequence[str] = (),
        radius: float,
        confidence: float = DEFAULT_CONFIDENCE,
        concentration: float = 1.0,
        rate: float | None = 20.0,
        window: int = 2,
        max_gap: float | None = None,
        metric: Metric | None = None,
        units: str = "",
        time_unit: str = "s",
        source: str = "stream",
        chains: int = 4,
        seed: int = 0,
    ) -> None:
        self._names, d = columns(dimension, names)
        self._units, self._time_unit = text("units", units), text("time_unit", time_unit)
        self._metric = fitting(metric, d)
        self._radius, self._seed = positive("radius", radius), whole("seed", seed, least=0)
        self._concentration = positive("concentration", concentration)
        self._table = GrowingTable(self._metric, self._radius, checked_confidence(confidence))
        self._chains = Chains(whole("chains", chains), self._seed)
        self._rate = None if rate is None else positive("rate", rate)
        self._window = whole("window", window, least=2)
        self._times = Growing()
        self._max_gap = np.inf if max_gap is None else positive("max_gap", max_gap)
        self._trajectories, self._lowest = Trajectories(text("source", source)), np.full(d, np.inf)
        self._track = self._new_track()
        self._at = 0
        self._record: tuple[int, LogLikelihood] | None = None

    def __repr__(self) -> str:
        told = f"{self.n_pairs} pairs of ({', '.join(self._names)})"
        return f"Stream({told}, {self._table.n_candidates} candidates, {self._chains.count} chains)"

    @property
    def n_pairs(self) -> int:
        """Pairs so far, N: those that no later sample can change."""
        return self._table.n_pairs

    @property
    def confidence(self) -> float:
        """α."""
        return self._table.confidence

    @property
    def concentration(self) -> float:
        """η."""
        return self._concentration

    def add(self, time: float, place: Any) -> int:
        """Take one sample, a time and a place (d,); returns the number of new pairs.

        Raises ``InputError`` for what is no finite number, another number of columns, a time that is not after the
        last one of the trajectory, and a gap of more than 1,000 resampling times.
        """
        when, where, is_cut = checked_sample(time, place, self._track, self._metric, self._names, self._max_gap)
        known = self._at
        if is_cut:
            end = self._finish()
            self._trajectories.cut(self._at, end)
        self._take(self._track.add(when, where))
        return self._at - known

    def lift(self, *, name: str | None = None) -> int:
        """End the trajectory: its last pairs are final, its end is a candidate; returns the number of new pairs.

        The next sample begins another. ``name`` is that of the trajectory, else "T" and its number. One of one
        sample, or too short for one step of resampling, is dropped, and counted.
        """
        known = self._at
        if len(self._track):
            end = self._finish()
            self._trajectories.end(self._at, end, name)
        return self._at - known

    def _finish(self) -> Floats | None:
        """Take the last pairs of the track and begin another; (d,) where it ended, None where nothing comes of it."""
        track, whole_track = self._track, self._track.whole()
        self._track = self._new_track()
        if whole_track is None or whole_track.times is None:
            self._trajectories.count(**{track.flaw: 1})
            return None
        self._lowest = np.minimum(self._lowest, track.lowest)
        first = self._trajectories.first
        given = self._at - first
        self._trajectories.count(**{name.replace(" ", "_"): count for name, count in whole_track.source.notes.items()})
        self._table.put_right(first, whole_track.states[:given], whole_track.actions[:given])
        self._times.rows[first : self._at] = whole_track.times[:given]
        end: Floats = whole_track.final_states[0]
        self._table.offer(end, is_end=True)
        self._take(Pairs(whole_track.times[given:], whole_track.states[given:], whole_track.actions[given:]))
        self._record = None
        return end

    def rejuvenate(self, sweeps: int = 1) -> None:
        """Whole sweeps of all chains: for when there is time."""
        sweeps = whole("sweeps", sweeps)
        if self._table.moves:
            self._chains.sweep(self.likelihood(), self._concentration, sweeps)

    def retune(self, *, confidence: float | None = None, concentration: float | None = None) -> None:
        """Another α or η for all that came, and sweeps enough to replace the draws of late."""
        alpha = self.confidence if confidence is None else checked_confidence(confidence)
        eta = self._concentration if concentration is None else positive("concentration", concentration)
        self._concentration, self._record = eta, None
        if alpha != self.confidence:
            self._table.retune(alpha)
        self.rejuvenate(KEPT)

    def demonstrations(self) -> Demonstrations:
        """All pairs so far; the trajectory that is going on is marked truncated, and ends in its last pair.

        Of trajectories that are over these are the numbers of ``subgoal.demonstrate`` for the same samples.
        Raises ``InputError`` while there are none.
        """
        if not self.n_pairs:
            raise InputError("stream", found="no pairs yet", wanted="at least one", hint="add more samples, or lift()")
        known = self._trajectories
        found = Demonstrations(
            states=self._table.states.copy(),
            actions=self._table.actions.copy(),
            offset=known.offset(self._at),
            times=self._times.rows.copy(),
            final_states=known.ends(self._at, self._table.states[-1]),
            truncated=known.truncated(self._at),
            names=self._names,
            units=self._units,
            trajectory_names=known.names(self._at),
            time_unit=self._time_unit,
            source=known.source,
        )
        return wrapped(found, self._period, self._lows) if self._wraps else found

    def candidates(self) -> Candidates:
        """The greedy net so far, in order of arrival, uniform; ``InputError`` before the first pair."""
        found = self._table.candidates
        if not self._wraps:
            return found
        placed = Demonstrations.from_arrays(found.points, np.zeros(len(found.points)))
        return replace(found, points=wrapped(placed, self._period, self._lows).states)

    def likelihood(self) -> LogLikelihood:
        """The table of ``action_comparison`` for the pairs and candidates so far.

        Raises ``InputError`` while nothing has moved.
        """
        if not self._table.moves:
            raise InputError("stream", found="nothing that moves yet", wanted="at least one pair that does",
                             hint="add more samples, or lift()")  # fmt: skip
        if self._record is None or self._record[0] != self._at:
            self._record = self._at, self._table.likelihood(self.demonstrations(), self.candidates())
        return self._record[1]

    def subgoals(self, *, merge_radius: float | None = None) -> Subgoals:
        """Subgoals by the latest draws of all chains, in milliseconds; none while nothing has moved."""
        if not self._table.moves:
            nothing = np.zeros((self._chains.count, 1), np.int64)
            return Subgoals((), np.full(self._table.n_candidates, -1), MERGE_RADII * self._radius, nothing)
        return subgoals(self._of_late(), merge_radius=merge_radius)

    def segments(self, found: Subgoals | None = None) -> Segments:
        """Segments by the latest draws of all chains; ``found`` is what ``subgoals`` said now."""
        if not self._table.moves:
            return Segments((), np.full(self.n_pairs, OTHER), np.ones((self.n_pairs, 1)))
        return segments(self._of_late(), found)

    def posterior(self, draws: int = DRAWS, *, warmup: int = WARMUP, thin: int = THIN) -> Posterior:
        """New draws of all chains from where they are: what ``subgoal.sample`` gives for ``likelihood()``.

        ``draws``, ``warmup`` and ``thin`` as there. Not converging does not raise: ``status`` says so and a
        ``ConvergenceWarning`` is given. Raises ``InputError`` while nothing has moved.
        """
        posterior = drawn(
            self._target, self._chains, self.likelihood(), draws=whole("draws", draws),
            warmup=whole("warmup", warmup, least=0), thin=whole("thin", thin),
        )  # fmt: skip
        if posterior.status is not Status.CONVERGED:
            warnings.warn(posterior.status.value, ConvergenceWarning, stacklevel=2)
        return posterior

    @property
    def _target(self) -> Target:
        return Target(self._concentration, self.confidence, self._seed)

    def _of_late(self) -> Posterior:
        pairs, places = self.demonstrations(), self.candidates()
        return of_late(self._target, self._chains, pairs, places, self._table.slow.copy())

    @property
    def _wraps(self) -> bool:
        return bool(np.isfinite(self._metric.period).any())

    @property
    def _period(self) -> list[float]:
        return [float(length) for length in self._metric.period]

    @property
    def _lows(self) -> Floats:
        """(1, d) least coordinates of all samples."""
        return np.asarray(np.minimum(self._lowest, self._track.lowest)[None])

    def _new_track(self) -> Track:
        return Track(self._metric.period, self._rate, self._window)

    def _take(self, pairs: Pairs) -> None:
        for time, state, action in zip(*pairs, strict=True):
            self._table.offer(state)
            self._table.add(state, action)
            self._times.extend([time])
            self._at += 1
            self._chains.seat(self._table, self._concentration)


def warm() -> None:
    """Load, and the first time compile, all that a stream needs, so that its first point need not wait."""
    stream = Stream(2, radius=0.5, rate=None)
    for k in range(8):
        stream.add(k, [k, k % 2])
    stream.lift()
    stream.retune(confidence=2.0)
    stream.segments(stream.subgoals())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        stream.posterior(8)
