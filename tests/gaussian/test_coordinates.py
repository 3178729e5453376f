"""Coordinates in which the metric is the plain distance."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.continuous import spread_metric
from subgoal.demonstrations import Metric
from subgoal.gaussian.coordinates import coordinates
from subgoal.runtime.errors import InputError


def test_distances_are_those_of_the_metric():
    rng = np.random.default_rng(0)
    metric, (a, b) = Metric.of(3, (1.0, 2.0, 0.5)), rng.normal(size=(2, 20, 3))
    apart = np.linalg.norm(coordinates(metric, a) - coordinates(metric, b), axis=1)
    np.testing.assert_allclose(apart, metric.distance(a, b), atol=1e-12)


def test_angles_lie_on_a_circle_of_the_right_size():
    metric = Metric.of(2, (1.0, 3.0), (np.inf, 2 * np.pi))
    near = np.array([[0.0, 0.01], [0.0, 2 * np.pi - 0.01]])
    placed = coordinates(metric, near)
    assert placed.shape == (2, 3)
    assert np.linalg.norm(placed[0] - placed[1]) == pytest.approx(3 * 0.02, rel=1e-4)
    around = coordinates(metric, np.array([[0.0, 0.0], [0.0, np.pi]]))
    assert np.linalg.norm(around[0] - around[1]) == pytest.approx(2 * 3.0)
    np.testing.assert_allclose(coordinates(metric, near + np.array([0, 2 * np.pi])), placed, atol=1e-12)


def test_units_are_spreads_but_not_below_the_floor():
    rng = np.random.default_rng(1)
    states = rng.normal(size=(4000, 2)) * [2.0, 0.001]
    metric = spread_metric(states, floor=[0.5, 0.25])
    np.testing.assert_allclose(1 / metric.weights, [states[:, 0].std(), 0.25])


def test_the_spread_of_an_angle_does_not_hang_on_where_it_is_cut():
    rng = np.random.default_rng(2)
    angle = rng.normal(0, 0.2, 4000)
    inside = spread_metric(angle[:, None], period=[2 * np.pi])
    across = spread_metric(np.mod(angle + np.pi, 2 * np.pi)[:, None], period=[2 * np.pi])
    at_zero = spread_metric(np.mod(angle, 2 * np.pi)[:, None], period=[2 * np.pi])
    assert 1 / inside.weights[0] == pytest.approx(0.2, rel=0.05)
    np.testing.assert_allclose([across.weights, at_zero.weights], [inside.weights] * 2, rtol=1e-9)


def test_a_dimension_that_never_changes_is_refused_unless_it_has_a_floor():
    states = np.column_stack([np.arange(5.0), np.full(5, 3.0)])
    with pytest.raises(InputError, match="dimension 1: found 3 throughout"):
        spread_metric(states)
    assert 1 / spread_metric(states, floor=[0, 0.5]).weights[1] == 0.5


@pytest.mark.parametrize("floor", [[1.0], [1.0, -1.0], [1.0, np.nan]])
def test_floors_that_do_not_fit_are_refused(floor):
    with pytest.raises(InputError, match="floor"):
        spread_metric(np.random.default_rng(0).normal(size=(5, 2)), floor=floor)


def test_states_of_another_dimension_are_refused():
    with pytest.raises(InputError, match="2 columns"):
        coordinates(Metric.euclidean(2), np.zeros((4, 3)))
