"""Planes of the world: where coordinates go, which way thrust points, and that one is the other's inverse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from subgoal.demonstrations.poses import plane_angles, plane_axes
from subgoal.flight.placement import place
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.errors import InputError

PERIOD = (np.inf, np.inf, 2 * np.pi)
POSES = np.array([[0.5, 1.0, 0.3], [2.0, -1.0, 2.5]])
ANGLES = np.linspace(-3, 3, 13)


def placed(plane: str):
    return place(Waypoints(POSES, dimensions=("a", "b", "c"), units="m", period=PERIOD), plane, 1.5, None)


@pytest.mark.parametrize("plane", ["xy", "yz", "xz", "zy", "zx", "yx"])
def test_positions_come_back(plane: str) -> None:
    world = placed(plane).to_world(POSES)
    np.testing.assert_allclose(world[:, "xyz".index(plane[0])], POSES[:, 0])
    np.testing.assert_allclose(placed(plane).from_world(world), POSES[:, :2])


@pytest.mark.parametrize("plane", ["yz", "xz", "zy", "zx"])
def test_tilts_are_angles_in_the_plane_from_its_first_axis_to_its_second(plane: str) -> None:
    made = placed(plane)
    first, second, normal, sign = plane_axes(plane)
    turned = Rotation.from_rotvec(sign * ANGLES[:, None] * np.eye(3)[normal])
    np.testing.assert_allclose(made.direction(ANGLES), turned.apply([0, 0, 1]), atol=1e-12)
    np.testing.assert_allclose(made.tilts(made.direction(ANGLES)), ANGLES, atol=1e-12)
    np.testing.assert_allclose(made.angles(turned.as_quat()), ANGLES, atol=1e-12)
    np.testing.assert_allclose(plane_angles(turned.as_quat(), np.array([0, 13]), plane)[0], ANGLES, atol=1e-12)
    assert {first, second, normal} == {0, 1, 2}


def test_headings_are_angles_about_the_vertical() -> None:
    np.testing.assert_allclose(
        placed("xy").angles(Rotation.from_euler("z", ANGLES[:, None]).as_quat()), ANGLES, atol=1e-12
    )


def test_quaternions_give_headings_and_tilted_ones_are_told() -> None:
    from subgoal.flight.route import route_of

    four = Rotation.from_euler("zx", [[0, 0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]]).as_quat()
    places = np.column_stack([np.arange(4.0), np.zeros(4), np.ones(4), four])
    made = Waypoints(places, dimensions=("x", "y", "z", "qx", "qy", "qz", "qw"), units="m")
    placement = place(made, None, 1.0, None)
    np.testing.assert_allclose(route_of(made, placement, 1, 1.1).angles[:2], [0, 1.0], atol=1e-12)
    with pytest.raises(InputError, match="waypoint 3: found a tilt in 3 dimensions"):
        route_of(made, placement, 1, 0.9)
