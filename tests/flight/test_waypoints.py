"""Which waypoints a posterior gives, in which order, and what no waypoints are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from subgoal.answers import predictions
from subgoal.flight import Waypoints, waypoints
from subgoal.flight.waypoints import NOBODY
from subgoal.posterior.diagnostics import Status
from subgoal.runtime.errors import InputError
from tests.flight.made import RADIUS, TURN, flip, served, square

PLACES = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0], [-1.0, -1.0]])
POSES = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 3.1], [0.0, 0.0, 0.0]])


def candidates(made: Waypoints, posterior) -> list[int]:
    return [int(np.flatnonzero((posterior.candidates.points == place).all(axis=1))[0]) for place in made.positions]


@pytest.mark.parametrize("runs", ["2*20 0*20 1*20", "2*20 1*2 2*20 0*20 1*20", "2*20 0*20 1*20 2*20 0*20 1*20"])
def test_the_order_is_that_of_the_first_visits_whatever_strays_or_comes_again(runs: str) -> None:
    posterior = served(runs, PLACES)
    assert candidates(waypoints(posterior), posterior) == [2, 0, 1]


def test_waypoints_and_action_prediction_agree_on_the_order() -> None:
    posterior = served("3*12 1*30 1*5 2*9 0*20 3*12 1*30", PLACES)
    assert candidates(waypoints(posterior, least_share=0.01), posterior) == predictions.waypoints(posterior).tolist()


def test_a_place_that_the_best_draw_leaves_out_comes_where_it_is_likeliest_served() -> None:
    posterior = served("2*20 0*20 1*20", PLACES)
    shares = posterior.shares.toarray()
    shares[22:38, 0], shares[22:38, 3], shares[59, 1], shares[59, 3] = 0.6, 0.4, 0.9, 0.1
    unsure = replace(posterior, shares=sparse.csr_array(shares), assignments=None)
    assert candidates(waypoints(unsure), unsure) == [2, 0, 3, 1]


@pytest.mark.parametrize("long", [20, 200])
def test_a_place_of_some_trajectories_comes_between_its_neighbours_there(long: int) -> None:
    runs = f"2*20 0*20 1*20 2*20 0*20 1*20 2*{long} 0*{long} 3*{long} 1*{long}"
    posterior = served(runs, PLACES, offset=[0, 60, 120, 120 + 4 * long])
    assert candidates(waypoints(posterior, least_share=0.01), posterior) == [2, 0, 3, 1]
    assert predictions.waypoints(posterior).tolist() == [2, 0, 3, 1]


def test_trajectories_that_end_early_leave_the_order() -> None:
    posterior = served("2*20 0*20 2*20 0*20 2*20 0*20 2*20 0*20 3*20 1*20", PLACES, offset=[0, 40, 80, 120, 200])
    assert candidates(waypoints(posterior), posterior) == [2, 0, 3, 1]


def test_places_that_never_meet_come_by_share_of_their_trajectories() -> None:
    posterior = served("0*10 1*30 2*100 3*100", PLACES, offset=[0, 40, 240])
    assert candidates(waypoints(posterior, least_share=0.01), posterior) == [0, 2, 1, 3]


def test_small_subgoals_are_left_out() -> None:
    posterior = served("2*20 0*20 1*2 3*20", PLACES)
    assert candidates(waypoints(posterior), posterior) == [2, 0, 3]
    assert candidates(waypoints(posterior, least_share=0.02), posterior) == [2, 0, 1, 3]


@pytest.mark.parametrize(
    ("runs", "cyclic"),
    [("0*20 1*20 2*20", False), ("0*20 1*20 2*20 0*20 1*20", True), ("0*20 1*20 2*20 1*20 0*20", False),
     ("0*20 1*20 2*20 0*4", False), ("0*20 1*20 0*20 1*20", True)],
)  # fmt: skip
def test_waypoints_are_cyclic_where_the_first_comes_after_the_last(runs: str, cyclic: bool) -> None:
    posterior = served(runs, PLACES)
    assert waypoints(posterior).cyclic is cyclic
    assert waypoints(posterior, cyclic=not cyclic).cyclic is not cyclic


def test_visits_are_the_segments_in_order_without_strays() -> None:
    posterior = served("0*20 1*20 2*4 1*20 0*20 2*20", PLACES)
    assert candidates(waypoints(posterior, visits=True), posterior) == [0, 1, 0, 2]
    assert candidates(waypoints(posterior, visits=True, stray=4), posterior) == [0, 1, 2, 1, 0, 2]


def test_the_start_is_where_the_demonstrator_began() -> None:
    np.testing.assert_allclose(waypoints(served("2*20 0*20", PLACES)).start, [-1, -1])


def test_whole_turns_are_those_of_the_demonstrator() -> None:
    assert waypoints(flip(), cyclic=True).turns.sum() == pytest.approx(TURN)
    assert waypoints(flip(1, -1), cyclic=True).turns.sum() == pytest.approx(-TURN)


def test_turns_are_nearest_to_what_was_turned() -> None:
    made = waypoints(served("1*20 0*20", POSES, angles=True))
    np.testing.assert_allclose(made.turns, [3.1, -3.1])


def test_visits_turn_as_each_was_turned_to() -> None:
    posterior = served("1*20 0*20 1*20 0*20", POSES, angles=True)
    states = np.array(posterior.demonstrations.states)
    states[40:, 2] *= (3.1 - TURN) / 3.1
    other = replace(posterior, demonstrations=replace(posterior.demonstrations, states=states))
    np.testing.assert_allclose(waypoints(other, visits=True).turns, [3.1, -3.1, 3.1 - TURN, TURN - 3.1])


def test_roundness_is_that_of_the_demonstrated_loop() -> None:
    np.testing.assert_allclose(waypoints(flip(), cyclic=True).roundness, 1, atol=0.15)
    np.testing.assert_allclose(waypoints(flip(width=0.15), cyclic=True).roundness, 0.15 / RADIUS, atol=0.1)
    np.testing.assert_array_equal(waypoints(square()).roundness, 1)


def test_a_square_has_four_corners_in_order() -> None:
    np.testing.assert_allclose(waypoints(square()).positions, [[1.5, 0.5], [1.5, 2], [0, 2], [0, 0.5]], atol=0.15)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"positions": [[0.0, np.nan], [1, 1]]}, "positions at index"),
        ({"positions": [[0.0, 1.0]]}, "found one place, wanted two"),
        ({"positions": [[0.0, 1.0], [2, 2], [2, 2]]}, "waypoint 3: found the same place"),
        ({"positions": [[0.0, 1.0], [2, 2], [0, 1]], "cyclic": True}, "waypoint 1: found the same place"),
        ({"positions": [[0.0, 1.0], [2, 2]], "dwell": [0.0, -1.0]}, "dwell: found -1"),
        ({"positions": [[0.0, 1.0], [2, 2]], "dwell": [0.0, np.nan]}, "dwell"),
        ({"positions": [[0.0, 1.0], [2, 2]], "start": [0.0]}, "start: found 1 numbers"),
        ({"positions": [[0.0, 1.0], [2, 2]], "turns": [0.0]}, "turns: found 1 of them"),
        ({"positions": [[0.0, 1.0], [2, 2]], "dwell": [1.0]}, "dwell: found 1 of them"),
        ({"positions": [[0.0, 1.0], [2, 2]], "dimensions": ("y", "y")}, "dimensions: found"),
        ({"positions": [[0.0, 1.0], [2, 2]], "roundness": 0.0}, "roundness: found"),
        ({"positions": [[0.0, 1.0], [2, 2]], "roundness": [1.0, 1.1]}, "roundness: found"),
        ({"positions": [[0.0, 1.0], [2, 2]], "dwell": [0.0, 1.0, 2.0]}, "dwell: found 3 of them"),
        ({"positions": [[0.0, 1.0], [2, 2]], "labels": [1, 2.5]}, r"labels at index 1: found 2.5"),
        ({"positions": [[0.0, 1.0], [2, 2]], "labels": [1]}, "labels: found 1 of them"),
        ({"positions": [[0.0, 1.0], [2, 2]], "cyclic": "no"}, "cyclic: found 'no'"),
        ({"positions": [[0.0, 1.0], [2, 2]], "units": None}, "units: found None"),
        ({"positions": [[0.0, 1.0], [2, 2]], "notes": (3,)}, "notes: found 3"),
        ({"positions": [[0.0, 1.0], [2]]}, "rows of different lengths"),
    ],
)
def test_what_is_no_waypoints_is_refused(fields: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Waypoints(**fields)


def test_of_several_trajectories_one_of_the_starts_is_the_start() -> None:
    """Begins are (−1, −1), (3, 3), (3, 0) and (0, 0), so that nobody begins at their median."""
    posterior = served("2*20 1*20 0*20 3*20", PLACES, offset=[0, 20, 40, 60, 80])
    begins = posterior.demonstrations.states[[0, 20, 40, 60]].tolist()
    assert begins == [[-1, -1], [3, 3], [3, 0], [0, 0]]
    np.testing.assert_array_equal(waypoints(posterior).start, [3, 0])


def test_whoever_went_to_all_in_this_order_is_looked_for() -> None:
    together = waypoints(served("2*20 3*20 0*20 1*20", PLACES, offset=[0, 80]))
    assert NOBODY not in together.notes
    apart = waypoints(served("2*20 0*20 3*20 1*20", PLACES, offset=[0, 40, 80]))
    assert NOBODY in apart.notes


@pytest.mark.parametrize("status", list(Status))
def test_what_has_not_converged_is_told(status: Status) -> None:
    made = waypoints(replace(served("2*20 0*20", PLACES), status=status))
    assert made.notes == (() if status is Status.CONVERGED else (status.value,))


def test_a_start_and_one_place_are_enough() -> None:
    assert len(Waypoints(np.array([[1.0, 1.0]]), start=np.array([0.0, 0.0]))) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [({"least_share": 0.9}, "least_share"), ({"visits": True, "cyclic": True}, "cyclic"), ({"dwell": -1.0}, "dwell"),
     ({"cyclic": "no"}, "cyclic: found 'no'"), ({"stray": 0}, "stray"),
     ({"visits": True, "stray": 50}, "stray: found no segment")],
)  # fmt: skip
def test_wrong_options_are_refused(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        waypoints(served("0*20 1*20", PLACES), **options)
