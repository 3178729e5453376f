"""Distances with weights and angles, by hand and by their laws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subgoal.demonstrations import Metric
from subgoal.runtime.errors import InputError

places = st.lists(st.floats(-50, 50), min_size=2, max_size=2).map(np.array)


def test_by_hand():
    metric = Metric.of(2, weights=[2, 10], period=[np.inf, 1])
    assert metric.difference([0.0, 0.9], [1.0, 0.1]) == pytest.approx([2, 2])
    assert metric.distance([[0.0, 0.0], [0.0, 0.25]], [1.5, 0.0]) == pytest.approx([3, (9 + 2.5**2) ** 0.5])
    assert Metric.euclidean(2).distance([0, 0], [3, 4]) == 5
    assert metric.dimension == 2


@given(places, places, places, st.floats(0.1, 20))
def test_laws(a, b, c, period):
    metric = Metric.of(2, weights=[0.5, 3], period=[period, np.inf])
    assert metric.distance(a, b) == pytest.approx(metric.distance(b, a), abs=1e-9)
    assert metric.distance(a, c) <= metric.distance(a, b) + metric.distance(b, c) + 1e-9
    assert metric.distance(a + np.array([period, 0]), b) == pytest.approx(metric.distance(a, b), abs=1e-6)
    assert abs(metric.difference(a, b)[0]) <= 0.5 * period / 2 + 1e-9


@pytest.mark.parametrize(
    ("weights", "period", "message"),
    [
        ([1, 0], None, "weights at dimension 1"),
        ([1, np.nan], None, "weights"),
        (None, [0, 1], "period at dimension 0"),
        (None, [np.nan, 1], "period at dimension 0"),
        ([1, 1, 1], None, "weights: found 3 numbers"),
        ([1.0], [1.0], "weights: found 1 numbers"),
    ],
)
def test_bad_metrics_are_refused(weights, period, message):
    with pytest.raises(InputError, match=message):
        Metric.of(2, weights, period)
