"""The frozen records of this room: a Recording (positions over time), Demonstrations (states, actions)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from subgoal.demonstrations.fields import (
    check_period,
    check_quaternion,
    coordinates_of,
    group_labels,
    labels_of,
    same_length,
    set_fields,
    values_of,
)  # fmt: skip
from subgoal.runtime.checks import Floats, Ints, check_offset, frozen, real_array
from subgoal.runtime.errors import InputError


@dataclass(frozen=True)
class Source:
    """Where data came from: a name for people, a checksum for provenance, and what was done on the way in.

    ``notes`` counts every quiet act: rows dropped, gaps split, samples interpolated.
    """

    name: str = "arrays"
    checksum: str = ""
    notes: dict[str, int] = field(default_factory=dict)

    def noting(self, **counts: int) -> Source:
        """The same source with counts added to its notes; "_" in a key reads as a space, zeros are left out."""
        notes = dict(self.notes)
        for key, count in counts.items():
            if count:
                label = key.replace("_", " ")
                notes[label] = notes.get(label, 0) + int(count)
        return replace(self, notes=notes)

    def told(self, found: str, nothing: str) -> str:
        """``found`` with the notes behind it in brackets; ``nothing`` where there are none."""
        notes = ", ".join(f"{count} {what}" for what, count in self.notes.items())
        return f"{found} ({notes})" if notes else nothing


@dataclass(frozen=True, eq=False, repr=False)
class Recording:
    """Positions over time, as read from a file, before velocities.

    Attributes
    ----------
    positions:
        (M, d) samples in ``units``.
    times:
        (M,) seconds (or frames, if that is all the file has), strictly increasing within a trajectory.
    offset:
        (D+1,) start of each trajectory in the rows, ending with M.
    names, units:
        d column names; one unit for all columns ("" if unknown).
    trajectory_names:
        D labels (the values of the id column).
    time_unit:
        "s", "frame", "sample" or another unit of ``times``.
    actions:
        (M, k) recorded actions (commands, measured velocities), or None: then velocities are computed.
    truncated:
        (D,) True where the recording stopped before the demonstrator did (it was cut at a gap).
    groups:
        (D,) name of the group of each trajectory (an animal, a driver, a day); empty where there are none.
    period:
        (d,) length after which a column wraps, infinity where it does not; empty where none wraps.
    quaternion:
        First of the four columns (x, y, z, w) that hold a unit quaternion, continuous in sign within each trajectory;
        None where there is none.
    """

    positions: Floats
    times: Floats
    offset: Ints
    names: tuple[str, ...]
    units: str = ""
    trajectory_names: tuple[str, ...] = ()
    time_unit: str = "s"
    source: Source = field(default_factory=Source)
    actions: Floats | None = None
    truncated: Any = None
    groups: tuple[str, ...] = ()
    period: tuple[float, ...] = ()
    quaternion: int | None = None

    def __post_init__(self) -> None:
        positions = real_array("positions", self.positions, ndim=2)
        times = real_array("times", self.times, ndim=1)
        offset = check_offset(self.offset, len(positions))
        same_length("times", times, len(positions))
        inside = np.ones(len(times), bool)
        inside[offset[:-1]] = False
        back = inside & ~(np.diff(times, prepend=-np.inf) > 0)
        if back.any():
            row = int(np.argmax(back))
            raise InputError(
                "times", where=f"row {row}", found=f"{times[row]} after {times[row - 1]}",
                wanted="times that increase within a trajectory",
                hint="drop or sort the rows first; readers do so with clock='sort', 'split' or 'drop'",
            )  # fmt: skip
        if self.actions is not None:
            set_fields(self, actions=real_array("actions", self.actions, ndim=2))
            same_length("actions", self.actions, len(positions))
        truncated = np.zeros(len(offset) - 1, bool) if self.truncated is None else np.array(self.truncated, bool)
        same_length("truncated", truncated, len(offset) - 1)
        set_fields(self, positions=positions, times=times, offset=offset, truncated=frozen(truncated))
        set_fields(self, names=labels_of("names", self.names, positions.shape[1], "x"))
        set_fields(self, trajectory_names=labels_of("trajectory_names", self.trajectory_names, len(offset) - 1, "T"))
        set_fields(self, groups=group_labels(self.groups, len(offset) - 1))
        set_fields(self, period=check_period(self.period, positions.shape[1]))
        check_quaternion(self.quaternion, positions, offset)

    def __repr__(self) -> str:
        told = f"{len(self.times)} samples of ({', '.join(self.names)})"
        return f"Recording({self.source.name!r}: {told} in {self.n_trajectories} trajectories)"

    @property
    def n_trajectories(self) -> int:
        """Number of trajectories D."""
        return len(self.offset) - 1


@dataclass(frozen=True, eq=False, repr=False)
class Demonstrations:
    """State-action pairs, grouped into trajectories: what every learner of this library takes.

    Attributes
    ----------
    states:
        (N, d) float positions, or (N,) integers for a discrete world.
    actions:
        (N, k) floats (velocities in ``units`` per ``time_unit``), or (N,) integers.
    offset:
        (D+1,) start of each trajectory, ending with N. Unordered pairs are one trajectory per pair.
    times:
        (N,) time of each pair, or None.
    final_states:
        (D, d) or (D,) where each trajectory ended; the last state of each if not given.
    truncated:
        (D,) True where the recording stopped before the demonstrator did.
    coordinates:
        (S, d) where the states of a discrete world lie, for distances and pictures, or None.
    names, units, trajectory_names, time_unit, source, groups:
        As in ``Recording``; one name per dimension of the states, or of the coordinates where there are some.

    Raises
    ------
    InputError
        Wrong shape, NaN, infinity, or offsets that do not fit, naming the argument and the index.
    """

    states: Any
    actions: Any
    offset: Ints
    times: Floats | None = None
    final_states: Any = None
    truncated: Any = None
    names: tuple[str, ...] = ()
    units: str = ""
    trajectory_names: tuple[str, ...] = ()
    time_unit: str = "s"
    source: Source = field(default_factory=Source)
    coordinates: Any = None
    groups: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        states, actions = values_of("states", self.states), values_of("actions", self.actions)
        same_length("actions", actions, len(states))
        offset = check_offset(self.offset, len(states))
        count = len(offset) - 1
        final = states[offset[1:] - 1] if self.final_states is None else values_of("final_states", self.final_states)
        same_length("final_states", final, count)
        if final.shape[1:] != states.shape[1:]:
            raise InputError("final_states", found=f"shape {final.shape}", wanted=f"{(count, *states.shape[1:])}")
        truncated = np.zeros(count, bool) if self.truncated is None else np.asarray(self.truncated, bool)
        same_length("truncated", truncated, count)
        times = None if self.times is None else real_array("times", self.times, ndim=1)
        if times is not None:
            same_length("times", times, len(states))
        set_fields(self, states=states, actions=actions, offset=offset, times=times)
        set_fields(self, final_states=frozen(final), truncated=frozen(truncated))
        coordinates = None if self.coordinates is None else coordinates_of(self.coordinates, states, final)
        set_fields(self, coordinates=coordinates)
        width = states.shape[1] if states.ndim == 2 else 1 if coordinates is None else coordinates.shape[1]
        set_fields(self, names=labels_of("names", self.names, width, "x"))
        set_fields(self, trajectory_names=labels_of("trajectory_names", self.trajectory_names, count, "T"))
        set_fields(self, groups=group_labels(self.groups, count))

    def __repr__(self) -> str:
        told = f"{self.n_observations} pairs of ({', '.join(self.names)})"
        return f"Demonstrations({self.source.name!r}: {told} in {self.n_trajectories} trajectories)"

    @classmethod
    def from_arrays(cls, states: Any, actions: Any, offset: Any = None, **fields: Any) -> Demonstrations:
        """Demonstrations from what is in memory.

        ``offset`` (D+1,) marks trajectories; without it the pairs are unordered (thesis 4.1: exchangeable), each a
        trajectory of its own. Other ``fields`` as in the class.
        """
        if offset is None:
            offset = np.arange(len(states) + 1)
        return cls(states=states, actions=actions, offset=offset, **fields)

    @property
    def n_observations(self) -> int:
        """Number of pairs N."""
        return len(self.states)

    @property
    def n_trajectories(self) -> int:
        """Number of trajectories D."""
        return len(self.offset) - 1

    @property
    def trajectory(self) -> Ints:
        """(N,) index of the trajectory of each pair."""
        return np.repeat(np.arange(self.n_trajectories), np.diff(self.offset))

    @property
    def group_names(self) -> tuple[str, ...]:
        """The K names of the groups, sorted."""
        return tuple(sorted(set(self.groups)))

    @property
    def group(self) -> Ints:
        """(D,) number of the group of each trajectory, into ``group_names``; ``InputError`` where there are none."""
        if not self.groups:
            hint = "read(..., group='animal'), or dataclasses.replace(demonstrations, groups=names)"
            raise InputError("groups", found="none", wanted="the name of a group for each trajectory", hint=hint)
        number = {name: k for k, name in enumerate(self.group_names)}
        return np.array([number[name] for name in self.groups], np.int64)

    @property
    def is_discrete(self) -> bool:
        """Whether states are numbers of states and not positions."""
        return np.ndim(self.states) == 1

    @property
    def places(self) -> Floats:
        """(N, d) where each observation lies: its position, the coordinates of its state, or the state's number."""
        return self._placed(self.states)

    @property
    def final_places(self) -> Floats:
        """(D, d) where each trajectory ended, as ``places``."""
        return self._placed(self.final_states)

    @property
    def extent(self) -> float:
        """Largest range over the dimensions of the places, final ones included."""
        return float(np.ptp(np.vstack([self.places, self.final_places]), axis=0).max())

    def _placed(self, states: Any) -> Floats:
        if not self.is_discrete:
            return np.asarray(states)
        return np.asarray(states, float)[:, None] if self.coordinates is None else np.asarray(self.coordinates[states])
