"""What readers of poses have in common: positions alone, with a quaternion, or in a plane with an angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.poses import (
    continue_quaternions,
    nothing_turns,
    plane_angles,
    plane_axes,
    quaternion_rates,
)
from subgoal.demonstrations.readers.columns import Choice, Treatment, assemble, numbers
from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.checks import Floats, Ints, flag
from subgoal.runtime.errors import InputError, ReadError, data_row

ROUNDED = 1e-3
"""A norm this near to 1 is that of a unit quaternion but for rounding."""
TILTED = np.pi / 4
"""A pose that leans this far out of its plane is counted."""
FLAT = np.pi - 1e-3
"""A pose that leans this far has no angle in the plane."""
TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
"""Names of the columns of a velocity and an angular velocity in the body."""


@dataclass(frozen=True)
class Posing:
    """Options of the readers of poses; checked when made.

    Attributes
    ----------
    pose:
        States are positions and a unit quaternion (x, y, z, w), and not positions alone.
    plane:
        Two axes such as "yz": states are these two positions and the angle from the first axis to the second.
    scale, units, clock:
        As in ``read_csv``; ``scale`` is of lengths.
    """

    pose: bool = False
    plane: str | None = None
    scale: float = 1.0
    units: str = "m"
    clock: str = "refuse"
    time_scale: float = 1.0

    def __post_init__(self) -> None:
        flag("pose", self.pose)
        if self.plane is not None:
            plane_axes(self.plane)
            if self.pose:
                raise InputError("plane", found=f"{self.plane!r} beside pose=", wanted="one of them")
        self.treatment(self.scale)

    @property
    def turns(self) -> bool:
        """Whether orientations are asked for."""
        return self.pose or self.plane is not None

    def treatment(self, scale: float) -> Treatment:
        """How the columns are to be treated."""
        return Treatment(scale=scale, units=self.units, time_scale=self.time_scale, clock=self.clock)


def posed(
    path: Path,
    columns: dict[str, Any],
    time: str,
    names: Sequence[str],
    how: Posing,
    source: Source,
    *,
    twist: bool = False,
) -> Recording:
    """A Recording from columns (M,): ``time``, ``names`` of x, y, z, qx, qy, qz, qw, and ``TWIST`` if that is wanted.

    Raises ``ReadError`` naming the row of a quaternion without length, and of a pose that has no angle in the plane.
    """
    places = tuple(names[:3])
    if not (how.turns or twist):
        return assemble(path, columns, Choice(places, time), how.treatment(how.scale), source)
    _check_lengths(path, columns, names[3:])
    choice = Choice((*places, *names[3:]), time, action=TWIST if twist else ())
    recording = assemble(path, columns, choice, how.treatment(1.0), source)
    given = recording.positions[:, 3:]
    unit = continue_quaternions(given, recording.offset)
    source = recording.source.noting(
        quaternions_normalised=int((np.abs(np.linalg.norm(given, axis=1) - 1) > ROUNDED).sum()),
        quaternions_whose_sign_jumped=_jumps(given, unit, recording.offset),
    )
    with np.errstate(over="ignore"):
        moved = recording.positions[:, :3] * how.scale
        speeds = None if recording.actions is None else _in_the_world(unit, recording.actions, how.scale)
    recording = replace(recording, positions=moved, names=places, actions=None, source=source)
    if how.plane is not None:
        return _in_a_plane(path, recording, unit, speeds, how.plane)
    if not how.pose:
        return replace(recording, actions=None if speeds is None else speeds[:, :3])
    if speeds is not None:
        speeds = np.hstack([speeds[:, :3], quaternion_rates(unit, speeds[:, 3:])])
    return replace(
        recording, positions=np.hstack([moved, unit]), names=(*places, *names[3:]), quaternion=3, actions=speeds
    )


def _check_lengths(path: Path, columns: dict[str, Any], names: Sequence[str]) -> None:
    """Raise ``ReadError`` for a quaternion that is no rotation; cells without a value are not looked at."""
    four = np.stack([numbers(path, name, columns[name]) for name in names], axis=1)
    short = nothing_turns(four)
    if short.any():
        row = int(np.argmax(short))
        raise ReadError(
            str(path), where=data_row(row), found=f"the quaternion {four[row].tolist()}",
            wanted="one that is a rotation", hint="positions alone, or a file without such rows",
        )  # fmt: skip


def _jumps(given: Floats, unit: Floats, offset: Ints) -> int:
    """How often the sign changed within a trajectory that now continues."""
    change = np.diff(np.einsum("ij,ij->i", given, unit) < 0)
    change[offset[1:-1] - 1] = False
    return int(change.sum())


def _in_the_world(unit: Floats, twist: Floats, scale: float) -> Floats:
    """(M, 6) velocity and angular velocity in the world from those in the body."""
    from scipy.spatial.transform import Rotation

    rotations, twist = Rotation.from_quat(unit), np.array(twist)
    return np.hstack([rotations.apply(twist[:, :3]) * scale, rotations.apply(twist[:, 3:])])


def _in_a_plane(path: Path, recording: Recording, unit: Floats, speeds: Floats | None, plane: str) -> Recording:
    """Two positions and the angle, continuous within each trajectory; it wraps at 2π."""
    first, second, normal, sign = plane_axes(plane)
    angles, tilt = plane_angles(unit, recording.offset, plane)
    if (tilt > FLAT).any():
        row = int(np.argmax(tilt > FLAT))
        raise ReadError(
            str(path), where=f"{recording.times[row]:.6g} s", found=f"a pose upside down to the plane {plane}",
            wanted="one that has an angle in it", hint="another plane=, or quaternions",
        )  # fmt: skip
    axes: Ints = np.array([first, second])
    return replace(
        recording,
        positions=np.column_stack([recording.positions[:, axes], angles]),
        names=(*(recording.names[k] for k in axes), "angle"),
        period=(np.inf, np.inf, 2 * np.pi),
        actions=None if speeds is None else np.column_stack([speeds[:, axes], sign * speeds[:, 3 + normal]]),
        source=recording.source.noting(poses_tilted_out_of_the_plane_by_over_45_degrees=int((tilt > TILTED).sum())),
    )
