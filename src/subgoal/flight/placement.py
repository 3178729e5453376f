"""Where the coordinates of a demonstration lie in the world of a vehicle: in metres, with z upwards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.demonstrations.poses import plane_axes
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError

METRES = {"": 1.0, "m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048, "in": 0.0254}
QUATERNION = ("qx", "qy", "qz", "qw")
UP = 2
TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class Placement:
    """How positions of the demonstration become those of the world, and back.

    Attributes
    ----------
    columns, axes:
        Coordinates that are positions, and the axis of the world (0, 1, 2) of each.
    angle, quaternion:
        The coordinate that is an angle; the first of four that are a quaternion; None where there is none.
    plane:
        The plane flown in ("yz"), or None in three dimensions.
    scale:
        Metres per unit of the demonstration.
    rest:
        (3,) where the axes lie that have no coordinate.
    """

    columns: tuple[int, ...]
    axes: tuple[int, ...]
    angle: int | None
    quaternion: int | None
    plane: str | None
    scale: float
    rest: Floats

    @property
    def upright(self) -> bool:
        """Whether the plane is vertical, so that its angle is a tilt; else an angle is a heading."""
        return self.plane is not None and UP in self.axes

    @property
    def heading(self) -> float:
        """The yaw at which nose or tail point out of a vertical plane, so that a full roll stays in it; else 0."""
        return np.pi / 2 if self.upright and 0 in self.axes else 0.0

    def to_world(self, places: Floats) -> Floats:
        """(n, 3) metres for places (n, d)."""
        world = np.tile(self.rest, (len(places), 1))
        world[:, self.axes] = places[:, self.columns] * self.scale
        return world

    def from_world(self, world: Floats) -> Floats:
        """(n, k) positions in the units of the demonstration, for (n, 3) metres."""
        return np.asarray(world[:, self.axes] / self.scale)

    @property
    def _across(self) -> tuple[int, float]:
        """The level axis of a vertical plane, and the sign of a turn from it to up."""
        first, second = self.axes
        return (first, 1.0) if second == UP else (second, -1.0)

    def direction(self, angles: Floats) -> Floats:
        """(n, 3) which way thrust points at tilts (n,) in a vertical plane: up, turned from its first to its second."""
        across, sense = self._across
        world = np.zeros((len(angles), 3))
        world[:, across], world[:, UP] = -sense * np.sin(angles), np.cos(angles)
        return world

    def tilts(self, thrust: Floats) -> Floats:
        """(...) tilts in a vertical plane at which thrust points along (..., 3)."""
        across, sense = self._across
        return np.asarray(np.arctan2(-sense * thrust[..., across], thrust[..., UP]))

    def angles(self, quaternions: Floats) -> Floats:
        """(n,) continuous angles of attitudes (n, 4): the tilt in a vertical plane, else the heading."""
        from scipy.spatial.transform import Rotation

        turned = Rotation.from_quat(quaternions)
        if self.upright:
            return np.unwrap(self.tilts(turned.apply([0.0, 0.0, 1.0])))
        nose = turned.apply([1.0, 0.0, 0.0])
        return np.unwrap(np.arctan2(nose[:, 1], nose[:, 0]))


def place(waypoints: Waypoints, plane: str | None, height: float, scale: float | None) -> Placement:
    """The placement of waypoints; raises ``InputError`` for an unknown plane or unit, and for what is no position."""
    names, period = waypoints.dimensions, waypoints.period
    four = len(names) - 4 if names[-4:] == QUATERNION else None
    inside = [k for k in range(len(names)) if four is None or k < four]
    wraps = [k for k in inside if np.isfinite(period[k])]
    if [k for k in wraps if k != waypoints.angle]:
        raise InputError("waypoints", found=f"the coordinate {names[wraps[0]]!r} with period {period[wraps[0]]:g}",
                         wanted="positions, and at most one angle in radians")  # fmt: skip
    columns = tuple(k for k in inside if k not in wraps)
    if len(columns) not in (2, 3):
        raise InputError("waypoints", found=f"{len(columns)} positions ({', '.join(names)})", wanted="two or three")
    metres = _metres(waypoints.units) if scale is None else positive("scale", scale)
    if not np.isfinite(height):
        raise InputError("height", found=height, wanted="a finite number of metres")
    rest = np.zeros(3)
    if len(columns) == 3:
        if plane is not None:
            raise InputError("plane", found=repr(plane), wanted="None: waypoints have three positions")
        return Placement(columns, (0, 1, 2), waypoints.angle, four, None, metres, rest)
    own = "".join(names[k] for k in columns)
    chosen = plane if plane is not None else own if _is_plane(own) else "xy"
    first, second, normal, _ = plane_axes(chosen)
    rest[normal] = height if normal == UP else 0.0
    return Placement(columns, (first, second), waypoints.angle, four, chosen, metres, rest)


def _is_plane(text: str) -> bool:
    return len(text) == 2 and len(set(text) & set("xyz")) == 2


def _metres(units: str) -> float:
    if units not in METRES:
        raise InputError("units", found=repr(units), wanted=f"one of {', '.join(map(repr, METRES))}",
                         hint="scale= (--scale), the metres of one unit, such as 0.01 for centimetres")  # fmt: skip
    return METRES[units]
