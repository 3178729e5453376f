"""ε-net and thinning against a brute-force form, and by hand."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal._kernels.nets import greedy_net
from subgoal.demonstrations import Demonstrations, Metric, epsilon_net_indices, thin
from subgoal.demonstrations.thinning import _hash_grid
from subgoal.runtime.errors import InputError


def brute_force(points, radius, weights, period, first):
    """The greedy net by the definition, with distances of its own (exact for multiples of a power of two)."""

    def distance(a, b):
        total = 0.0
        for k in range(len(a)):
            step = abs(a[k] - b[k])
            if np.isfinite(period[k]):
                step = min(step % period[k], period[k] - step % period[k])
            total += (weights[k] * step) ** 2
        return total**0.5

    kept = []
    for i in first:
        if all(distance(points[i], points[j]) > 0 for j in kept):
            kept.append(i)
    for i in range(len(points)):
        if i not in first and all(distance(points[i], points[j]) > radius for j in kept):
            kept.append(i)
    return kept


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_epsilon_net_is_the_greedy_net(seed):
    rng = np.random.default_rng(seed)
    count, d = int(rng.integers(1, 60)), int(rng.integers(1, 6))
    points = np.round(rng.normal(size=(count, d)) * rng.choice([4.0, 120.0])) / 4
    period = np.where(rng.random(d) < 0.4, rng.choice([1.0, 6.0, 50.0], d), np.inf)
    weights = rng.choice([0.5, 1.0, 2.0], d)
    radius = float(rng.choice([0.0, 0.33, 1.07, 5.03]))
    first = list(dict.fromkeys(rng.integers(0, count, int(rng.integers(0, 4))).tolist()))
    found = epsilon_net_indices(points, radius, Metric(weights, period), first)
    assert found.dtype == np.int64
    assert found.tolist() == brute_force(points, radius, weights, period, first)


def test_compiled_net_equals_its_python_form():
    rng = np.random.default_rng(3)
    points, metric = rng.random((200, 3)), Metric.of(3, [1, 2, 0.5], [np.inf, 0.7, np.inf])
    arguments = (points, np.arange(200), 5, 0.2, metric.weights, metric.period, *_hash_grid(points, 0.2, metric), 255)
    python_form = getattr(greedy_net, "py_func", greedy_net)  # the same where compilation is off
    assert greedy_net(*arguments).tolist() == python_form(*arguments).tolist()


def test_first_points_stay_however_close_and_collapse_only_when_equal():
    points = np.array([[0.0], [0.01], [0.0], [3.0], [0.02]])
    assert epsilon_net_indices(points, 1.0, Metric.euclidean(1), first=[4, 1, 0, 2]).tolist() == [4, 1, 0, 3]


def test_points_at_exactly_the_radius_are_dropped_and_radius_zero_keeps_distinct_points():
    points = np.array([[0.0], [2.0], [2.5], [4.5], [0.0]])
    assert epsilon_net_indices(points, 2.0, Metric.euclidean(1)).tolist() == [0, 2]
    assert epsilon_net_indices(points, 0, Metric.euclidean(1)).tolist() == [0, 1, 2, 3]


def test_angles_are_close_across_the_wrap():
    angles = np.array([[0.05], [6.25], [3.1], [-0.02]])
    assert epsilon_net_indices(angles, 0.2, Metric.of(1, period=[2 * np.pi])).tolist() == [0, 2]
    assert epsilon_net_indices(angles, 0.2, Metric.euclidean(1)).tolist() == [0, 1, 2]


def test_a_million_points_take_seconds():
    points = np.random.default_rng(0).random((10**6, 2))
    epsilon_net_indices(points[:10], 0.1, Metric.euclidean(2))
    begin = time.perf_counter()
    kept = epsilon_net_indices(points, 0.03, Metric.euclidean(2))
    assert 700 < len(kept) < 900
    assert time.perf_counter() - begin < 5


@pytest.mark.parametrize(
    ("points", "radius", "first", "message"),
    [
        ([[0.0, np.nan]], 1, None, "points at index"),
        ([0.0, 1.0], 1, None, "2 dimensions"),
        ([[0.0, 1.0]], -1, None, "radius"),
        ([[0.0, 1.0]], np.nan, None, "radius"),
        ([[0.0]], 1, None, "metric"),
        ([[0.0, 1.0]], 1, [1], "first at index 0"),
        ([[0.0, 1.0]], 1, [0.5], "first"),
        ([[0.0, 1e308], [0.0, -1e308]], 1, None, "too far apart"),
    ],
)
def test_bad_input_is_refused(points, radius, first, message):
    with pytest.raises(InputError, match=message):
        epsilon_net_indices(points, radius, Metric.euclidean(2), first)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("far", "weight"), [(1e300, 1.0), (1e308, 1.0), (1e10, 1e300)])
def test_points_too_far_apart_are_refused_without_a_warning(far, weight):
    with pytest.raises(InputError, match="too far apart"):
        epsilon_net_indices([[-far, 0.0], [far, 1.0]], 1, Metric.of(2, [weight, 1.0]))


def test_no_points_give_no_rows():
    assert epsilon_net_indices(np.empty((0, 2)), 1, Metric.euclidean(2)).shape == (0,)


def demonstrations():
    states = np.array([0.0, 0.4, 1.0, 1.3, 2.2, 0.1, 0.0, 5.0])[:, None]
    return Demonstrations(
        states, np.arange(8.0), np.array([0, 5, 8]), times=np.arange(8) / 2, final_states=[[9.0], [8.0]]
    )


def test_thinning_is_within_each_trajectory_and_keeps_ends_and_times():
    demos = demonstrations()
    thinned = thin(demos, 0.5)
    assert thinned.states.ravel().tolist() == [0.0, 1.0, 2.2, 0.1, 5.0]
    assert thinned.actions.ravel().tolist() == [0, 2, 4, 5, 7]
    assert thinned.times.tolist() == [0, 1, 2, 2.5, 3.5]
    assert thinned.offset.tolist() == [0, 3, 5]
    assert thinned.final_states.ravel().tolist() == [9, 8]
    assert thinned.source.notes == {"pairs dropped by thinning": 3, "pairs kept by thinning": 5}
    assert demos.n_observations == 8
    assert thin(demos, 0).n_observations == 8


def test_thinning_uses_the_metric_and_refuses_discrete_worlds():
    assert thin(demonstrations(), 0.5, Metric.of(1, weights=[10])).n_observations == 8
    with pytest.raises(InputError, match="discrete"):
        thin(Demonstrations([1, 2], [0, 1], np.array([0, 2])), 1)
