"""Thinning by regression: what is kept reproduces the rest, as an explicit inverse does it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

import subgoal
from experiments.common import find_data
from subgoal.demonstrations.records import Demonstrations
from subgoal.gaussian import Reproduction, thin_by_regression, thin_trajectories
from subgoal.runtime.errors import InputError
from tests.oracles.gaussian_regression import greedily_kept

TIMES = np.linspace(2.0, 7.0, 120)
PATH = np.column_stack([np.sin(TIMES), 0.2 * TIMES**2, np.cos(2.5 * TIMES)])
FIXED = ConstantKernel(40.0, "fixed") * RBF(0.7, "fixed") + WhiteKernel(0.01, "fixed")


def demonstrations(**fields) -> Demonstrations:
    """Two trajectories of 120 and 60 pairs, and one of a single pair."""
    states = np.vstack([PATH[:, :2], 3 - PATH[::2, :2], [[9.0, 9.0]]])
    actions = np.vstack([PATH[:, 1:], -PATH[::2, 1:], [[1.0, 0.0]]])
    times = np.concatenate([TIMES, TIMES[::2], [5.0]])
    return Demonstrations(states, actions, np.array([0, 120, 180, 181]), **{"times": times, **fields})


def test_rows_and_mean_against_the_naive_greedy_choice() -> None:
    tolerance = np.array([0.05, 0.1, 0.08])
    thinned = thin_by_regression(TIMES, PATH, tolerance, covariance=FIXED)
    scaled = (PATH - PATH.mean(axis=0)) / tolerance
    rows, mean = greedily_kept(40 * RBF(0.7)(TIMES[:, None]), 0.01, scaled)
    assert thinned.rows.tolist() == sorted(rows)
    np.testing.assert_allclose(thinned.reproduced, PATH.mean(axis=0) + mean * tolerance, atol=1e-9)
    np.testing.assert_allclose(thinned.error, np.abs(thinned.reproduced - PATH).max(axis=0), rtol=1e-12)
    assert thinned.noise == 0.01 and 2 < len(rows) < 40


def test_of_what_does_not_change_the_first_and_the_last_are_kept() -> None:
    thinned = thin_by_regression(TIMES, np.full((len(TIMES), 2), 3.0), 0.1)
    assert thinned.rows.tolist() == [0, len(TIMES) - 1]


@settings(max_examples=40, deadline=None)
@example(3, 0.5, 40)
@given(st.integers(0, 2**32 - 1), st.floats(0.02, 0.5), st.integers(1, 40))
def test_the_rest_is_reproduced_within_the_tolerance(seed, tolerance, n) -> None:
    generator = np.random.default_rng(seed)
    times = np.cumsum(generator.uniform(0.5, 1.5, size=n))
    values = np.cumsum(generator.standard_normal((n, 2)), axis=0)
    thinned = thin_by_regression(times, values, tolerance)
    assert thinned.status is Reproduction.WITHIN_TOLERANCE
    assert (thinned.error <= tolerance).all()
    assert {0, n - 1} <= set(thinned.rows) and (np.diff(thinned.rows) > 0).all()
    assert thinned.saved == pytest.approx(1 - len(thinned.rows) / n)


def test_smooth_needs_few_and_a_turn_needs_more_around_it() -> None:
    turning = np.column_stack([TIMES, np.abs(TIMES - 4.5)])
    smooth, bent = (thin_by_regression(TIMES, values, 0.02) for values in (PATH, turning))
    assert smooth.saved > 0.8
    near = np.abs(TIMES[bent.rows] - 4.5) < 0.5
    assert near.mean() > 1.3 * (np.abs(TIMES - 4.5) < 0.5).mean()


def shaking() -> tuple[np.ndarray, np.ndarray]:
    """Twenty seconds at 100 Hz: a slow path with a tremor of 0.02 at 8 Hz, whose period 150 samples do not show."""
    times = np.arange(2000) / 100
    return times, np.sin(0.5 * times) + 0.02 * np.sin(16 * np.pi * times)


def test_a_tremor_between_evenly_spaced_observations_is_seen() -> None:
    thinned = thin_by_regression(*shaking(), 0.005)
    assert thinned.status is Reproduction.WITHIN_TOLERANCE and 0.3 < thinned.saved < 0.9


def test_a_tremor_within_the_tolerance_is_passed_over() -> None:
    thinned = thin_by_regression(*shaking(), 0.04)
    assert thinned.status is Reproduction.WITHIN_TOLERANCE and thinned.saved > 0.95


def test_a_larger_tolerance_keeps_fewer() -> None:
    sizes = [len(thin_by_regression(TIMES, PATH, t).rows) for t in (0.001, 0.01, 0.1, 10.0)]
    assert sizes == sorted(sizes, reverse=True) and sizes[-1] == 2 and sizes[0] > 12


def test_units_do_not_matter() -> None:
    plain = thin_by_regression(TIMES, PATH, 0.05)
    other = thin_by_regression(1e3 * TIMES, 1e-4 * PATH + 7, 5e-6)
    assert plain.rows.tolist() == other.rows.tolist()


def test_infinity_leaves_a_column_out_of_account_but_reproduces_it() -> None:
    rough = np.random.default_rng(0).standard_normal(120)
    thinned = thin_by_regression(TIMES, np.column_stack([PATH, rough]), [0.05, 0.05, 0.05, np.inf])
    alone = thin_by_regression(TIMES, PATH, 0.05)
    assert thinned.rows.tolist() == alone.rows.tolist()
    np.testing.assert_allclose(thinned.reproduced[:, :3], alone.reproduced, atol=1e-9)
    assert thinned.status is Reproduction.WITHIN_TOLERANCE and thinned.error[3] > 1


def test_one_column_gives_numbers() -> None:
    thinned = thin_by_regression(TIMES, PATH[:, 0], 0.05)
    assert thinned.reproduced.shape == (120,) and isinstance(thinned.error, float)
    assert thinned.error <= 0.05


def test_what_never_changes_needs_its_ends() -> None:
    thinned = thin_by_regression(TIMES, np.full((120, 2), 3.0), 0.01)
    assert thinned.rows.tolist() == [0, 119] and (thinned.error <= 1e-9).all()


def test_places_in_the_thesis_form_and_two_ways_from_one_place_are_told() -> None:
    """8.1.2 as printed: from states to actions. It can be done while no state is seen with two actions."""
    states = np.random.default_rng(1).uniform(-2, 2, size=(80, 2))
    actions = np.column_stack([np.sin(states[:, 0]), states[:, 1]])
    once = thin_by_regression(states, actions, 0.05)
    assert once.status is Reproduction.WITHIN_TOLERANCE and once.saved > 0.3
    twice = thin_by_regression(np.vstack([states, states]), np.vstack([actions, -actions]), 0.05)
    assert twice.status is Reproduction.TOO_ROUGH and twice.saved == 0 and "NOT" in twice.status.value


def test_every_trajectory_is_thinned_by_itself_and_its_ends_stay() -> None:
    demos = demonstrations(names=("x", "y"), trajectory_names=("a", "b", "c"), final_states=np.eye(3)[:, :2])
    thinned = thin_trajectories(demos, 0.05, [0.1, 0.2])
    kept = thinned.demonstrations
    assert kept.n_trajectories == 3 and kept.names == ("x", "y") and kept.trajectory_names == ("a", "b", "c")
    np.testing.assert_array_equal(kept.final_states, demos.final_states)
    for field in ("states", "actions", "times"):
        np.testing.assert_array_equal(getattr(kept, field), getattr(demos, field)[thinned.rows])
    assert {0, 119, 120, 179, 180} <= set(thinned.rows.tolist())
    first = thin_by_regression(TIMES - TIMES[0], PATH[:, [0, 1, 1, 2]], [0.05, 0.05, 0.1, 0.2])
    assert thinned.rows[: kept.offset[1]].tolist() == first.rows.tolist()
    assert kept.source.notes == {
        "pairs dropped by thinning": 181 - len(thinned.rows), "pairs kept by thinning": len(thinned.rows),
    }  # fmt: skip
    assert thinned.saved == pytest.approx(1 - len(thinned.rows) / 181)
    assert set(thinned.status) == {Reproduction.WITHIN_TOLERANCE} and len(thinned.status) == 3


def test_errors_are_the_largest_of_all_trajectories() -> None:
    demos = demonstrations()
    thinned = thin_trajectories(demos, 0.05, [0.1, 0.2])
    np.testing.assert_allclose(thinned.state_error, np.abs(thinned.states - demos.states).max(axis=0), atol=1e-12)
    np.testing.assert_allclose(thinned.action_error, np.abs(thinned.actions - demos.actions).max(axis=0), atol=1e-12)
    assert (thinned.state_error <= 0.05).all() and (thinned.action_error <= [0.1, 0.2]).all()


def test_without_times_pairs_are_equally_far_apart() -> None:
    with_times = thin_trajectories(demonstrations(), 0.05, 0.1)
    without = thin_trajectories(demonstrations(times=None), 0.05, 0.1)
    assert without.demonstrations.times is None
    assert without.rows.tolist() == with_times.rows.tolist()


def test_a_real_recording_needs_a_tenth_of_its_pairs() -> None:
    folder, reason = find_data("tum_rgbd_handheld", None)
    if folder is None:
        pytest.skip(str(reason))
    demos = subgoal.read(folder / "freiburg1_xyz-groundtruth.txt", rate=20)
    speed = float(np.median(np.linalg.norm(demos.actions, axis=1)))
    thinned = thin_trajectories(demos, 0.03 * demos.extent, 0.5 * speed)
    assert thinned.saved > 0.85 and thinned.status == (Reproduction.WITHIN_TOLERANCE,)


@pytest.mark.parametrize(
    ("named", "arguments", "options"),
    [
        ("inputs", (np.full(120, np.nan), PATH, 0.1), {}),
        ("inputs", ("ab", PATH, 0.1), {}),
        ("values", (TIMES, PATH[:50], 0.1), {}),
        ("values", (TIMES, np.full((120, 1), np.inf), 0.1), {}),
        ("points and values", (TIMES[:0], PATH[:0], 0.1), {}),
        ("tolerance", (TIMES, PATH, 0.0), {}),
        ("tolerance", (TIMES, PATH, np.nan), {}),
        ("tolerance", (TIMES, PATH, [0.1, 0.1]), {}),
        ("tolerance", (TIMES, PATH, np.inf), {}),
        ("covariance", (TIMES, PATH, 0.1), {"covariance": RBF(1.0)}),
        ("covariance", (TIMES, PATH, 0.1), {"covariance": "RBF"}),
    ],
)
def test_bad_input_is_named(named, arguments, options) -> None:
    with pytest.raises(InputError, match=named):
        thin_by_regression(*arguments, **options)


@pytest.mark.parametrize(
    ("named", "demos", "limits"),
    [
        ("states", Demonstrations.from_arrays([0, 1, 2], PATH[:3]), (0.1, 0.1)),
        ("actions", Demonstrations.from_arrays(PATH[:3], [0, 1, 2]), (0.1, 0.1)),
        ("tolerance", demonstrations(), (-1.0, 0.1)),
        ("action_tolerance", demonstrations(), (0.1, [0.1])),
    ],
)
def test_bad_demonstrations_are_named(named, demos, limits) -> None:
    with pytest.raises(InputError, match=named):
        thin_trajectories(demos, *limits)
