"""Waypoints: the subgoals of a posterior in the order in which a machine is to go to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import sparse

from subgoal.answers.order import first_served
from subgoal.answers.segments import Segments, segments
from subgoal.answers.subgoals import COUNTED_FROM, Subgoal, Subgoals, reaches, subgoals
from subgoal.demonstrations.fields import check_period, labels_of, set_fields
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.flight.visits import Visit, follows, in_this_order, roundness_of, turns_to, visited_in_order
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, flag, frozen, positive, real_array, text, whole, whole_numbers
from subgoal.runtime.errors import InputError

NOBODY = "no trajectory goes to all of these places in this order"
STRAY = 5
"""A segment of fewer observations is no visit."""


@dataclass(frozen=True, eq=False, repr=False)
class Waypoints:
    """Places to go to, one after another.

    Attributes
    ----------
    positions:
        (W, d) in the demonstration's coordinates.
    names:
        (W,) names, "subgoal 1" and so on.
    labels:
        (W,) number of the subgoal at each waypoint, from 1; a subgoal can come more than once.
    dwell:
        (W,) seconds to stay at each.
    cyclic:
        Whether the first comes again after the last.
    dimensions, units:
        d names of the coordinates, and the unit of lengths.
    period:
        (d,) length after which a coordinate wraps (2π: an angle), infinity where it does not.
    start:
        (d,) where the demonstrator began, or None: then a flight begins at the first waypoint.
    turns:
        (W,) radians that the demonstrator turned on the way to each waypoint from the one before it, where a
        coordinate is an angle; zeros elsewhere. Before the first comes the last if ``cyclic``, else ``start``.
    roundness:
        (W,) how far the demonstrator's way to each waypoint swung out, as a share of what the arc of its turn does:
        1 for circles, less for narrower loops.
    notes:
        What to know of them: that the posterior has not converged, that nobody went to all of them in this order.

    Raises
    ------
    InputError
        NaN, wrong shapes, fewer than two places, or the same place twice in a row.
    """

    positions: Floats
    names: tuple[str, ...] = ()
    labels: Any = None
    dwell: Any = 0.0
    cyclic: bool = False
    dimensions: tuple[str, ...] = ()
    units: str = ""
    period: tuple[float, ...] = ()
    start: Floats | None = None
    turns: Any = None
    roundness: Any = 1.0
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        places = real_array("positions", self.positions, ndim=2)
        count, d = places.shape
        labels = np.arange(1, count + 1) if self.labels is None else whole_numbers("labels", self.labels, count)
        if len(set(self.dimensions)) < len(self.dimensions):
            raise InputError("dimensions", found=list(self.dimensions), wanted="names that differ")
        set_fields(
            self, positions=places, labels=frozen(labels), dwell=_one_each("dwell", self.dwell, count),
            names=labels_of("names", self.names or tuple(f"subgoal {label}" for label in labels), count, "w"),
            roundness=_one_each("roundness", self.roundness, count), cyclic=flag("cyclic", self.cyclic),
            notes=tuple(text("notes", note) for note in self.notes),
            dimensions=labels_of("dimensions", self.dimensions, d, "x"), units=text("units", self.units),
            period=check_period(self.period, d) or (np.inf,) * d,
            start=None if self.start is None else _start(self.start, d),
        )  # fmt: skip
        if (~(self.dwell >= 0)).any():
            raise InputError("dwell", found=self.dwell.min(), wanted="seconds, at least 0")
        if (~((self.roundness > 0) & (self.roundness <= 1))).any():
            raise InputError("roundness", found=list(self.roundness), wanted="above 0, at most 1")
        if count + (self.start is not None) < 2:
            raise InputError("waypoints", found="one place", wanted="two at least, the start included")
        turns = self._wrapped_turns() if self.turns is None else _one_each("turns", self.turns, count)
        set_fields(self, turns=frozen(turns))
        self._check_apart()

    def __repr__(self) -> str:
        order = " → ".join(str(label) for label in self.labels[:12]) + (" → …" if len(self) > 12 else "")
        return f"Waypoints({order}{', cyclic' if self.cyclic else ''})"

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def angle(self) -> int | None:
        """Which coordinate is an angle of 2π, None if none is."""
        found = np.flatnonzero(np.isclose(self.period, 2 * np.pi))
        return int(found[0]) if found.size == 1 else None

    @property
    def metric(self) -> Metric:
        """Distance with angles that wrap."""
        return Metric.of(self.positions.shape[1], None, self.period)

    def _before(self) -> Floats:
        """(W, d) the place before each; the first itself where nothing is before it."""
        first = self.positions[-1] if self.cyclic else self.positions[0] if self.start is None else self.start
        return np.vstack([first, self.positions[:-1]])

    def _wrapped_turns(self) -> Floats:
        if self.angle is None:
            return np.zeros(len(self))
        return np.array(self.metric.difference(self._before(), self.positions)[:, self.angle])

    def _check_apart(self) -> None:
        gaps = self.metric.distance(self._before(), self.positions)
        near = ~(gaps > 0)
        near[0] &= self.cyclic and len(self) > 1
        if near.any():
            k = int(np.argmax(near))
            raise InputError("waypoints", where=f"waypoint {k + 1}", found="the same place as the one before",
                             wanted="places that differ")  # fmt: skip


def _one_each(what: str, given: Any, count: int) -> Floats:
    """(count,) of one number for all, or of one for each."""
    array = real_array(what, given, ndim=(0, 1))
    if array.ndim and array.size != count:
        raise InputError(what, found=f"{array.size} of them", wanted=f"one number, or {count}")
    return frozen(np.broadcast_to(array, (count,)).copy())


def _start(given: Any, dimension: int) -> Floats:
    start = real_array("start", given, ndim=1)
    if start.size != dimension:
        raise InputError("start", found=f"{start.size} numbers", wanted=f"{dimension}")
    return start


def waypoints(
    posterior: Posterior,
    *,
    found: Subgoals | None = None,
    cyclic: bool | None = None,
    dwell: float = 0.0,
    least_share: float = COUNTED_FROM,
    visits: bool = False,
    stray: int = STRAY,
) -> Waypoints:
    """The subgoals with at least ``least_share`` of the observations, as places to fly to.

    They come in the order in which the best draw first serves them, as in action prediction
    (``predictions.waypoints``), or with ``visits`` each time the demonstrator went to one: the segments of all
    trajectories, one after another, without those of fewer than ``stray`` observations.

    Parameters
    ----------
    found:
        Subgoals, if they are already made.
    cyclic:
        Whether the first comes again after the last. None finds out: it does where, of the visits that follow one of
        the last, more than half are of the first. Visits are never cyclic.
    dwell:
        Seconds to stay at each waypoint.

    Raises ``InputError`` for states that are no positions, and if fewer than two places are left.
    """
    if not isinstance(posterior, Posterior):
        raise InputError("posterior", found=type(posterior).__name__, wanted="a Posterior, as sample() gives")
    cyclic = None if cyclic is None else flag("cyclic", cyclic)
    demos = posterior.demonstrations
    if demos.is_discrete:
        raise InputError("demonstrations", found="states of a discrete world", wanted="positions to fly to")
    found, least = subgoals(posterior) if found is None else found, positive("least_share", least_share, zero=True)
    kept = [goal for goal in found.items if reaches(goal.share, least)]
    if not kept:
        raise InputError("least_share", found=least, wanted=f"at most {found.items[0].share:.2f}, the largest share",
                         hint="a smaller least_share (--least-share)")  # fmt: skip
    cut = segments(posterior, found)
    seen = visited_in_order(demos, cut, len(kept), whole("stray", stray))
    if visits:
        if cyclic:
            raise InputError("cyclic", found="True beside visits", wanted="one of them")
        order, circles = np.array([visit.subgoal for visit in seen], np.int64), False
    else:
        order = _order(posterior, found, kept)
        circles = follows(seen, int(order[-1]), int(order[0])) if cyclic is None else cyclic
    return _made(posterior, kept, order, cut, seen, circles, positive("dwell", dwell, zero=True))


def _order(posterior: Posterior, found: Subgoals, kept: list[Subgoal]) -> Ints:
    """(W,) numbers of the kept subgoals, in the order of first service by the best draw."""
    theta = posterior.best_assignment
    served = np.where(theta >= 0, found.group[theta], -1)
    shares = np.array([goal.share for goal in kept])
    belongs = sparse.csr_array(found.group[:, None] == np.arange(len(kept)), dtype=np.float64)
    return first_served(posterior.demonstrations, served, np.arange(len(kept)), shares, posterior.shares @ belongs)


def _made(
    posterior: Posterior, kept: list[Subgoal], order: Ints, cut: Segments, seen: list[Visit], cyclic: bool,
    dwell: float,
) -> Waypoints:  # fmt: skip
    demos: Demonstrations = posterior.demonstrations
    notes = [] if posterior.status is Status.CONVERGED else [str(posterior.status.value)]
    notes += [] if in_this_order(seen, order) else [NOBODY]
    if not order.size:
        raise InputError("stray", found="no segment as long", wanted="fewer observations")
    period = tuple(posterior.candidates.metric.period.tolist())
    goals = [kept[k] for k in order]
    made = Waypoints(
        np.array([goal.position for goal in goals]), tuple(goal.name for goal in goals),
        np.array([goal.label for goal in goals]), dwell, cyclic, demos.names, demos.units, period,
        _usual_start(demos, posterior.candidates.metric), notes=tuple(notes),
    )  # fmt: skip
    if made.angle is None:
        return made
    turned = turns_to(demos.states[:, made.angle], demos.offset, seen, order, made.turns)
    flat = np.delete(demos.states, made.angle, axis=1)
    return replace(made, turns=turned, roundness=roundness_of(flat, seen, order, turned))


def _usual_start(demos: Demonstrations, metric: Metric) -> Floats:
    """(d,) where the trajectory begins whose begin is nearest to the median of all begins; of several, the first."""
    begins = demos.states[demos.offset[:-1]]
    return np.asarray(begins[int(np.argmin(metric.distance(np.median(begins, axis=0), begins)))])
