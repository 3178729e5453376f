"""The null candidate of the experiment, on made strokes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments import flat_subgoal
from experiments.common import Options
from subgoal.candidates import epsilon_net
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.maximum_literal import literal_maximum

TINY = {"draws": 50, "warmup": 50, "thin": 1, "chains": 2, "workers": 1}


def strokes() -> Demonstrations:
    """Two legs of 20 steps, to a corner and back down, with a shaking hand."""
    rng = np.random.default_rng(2)
    way = np.repeat([[1.0, 1.0], [1.0, -1.0]], 20, axis=0) + 0.2 * rng.normal(size=(40, 2))
    places = np.vstack([[0.0, 0.0], np.cumsum(way, axis=0)])
    return Demonstrations.from_arrays(places[:-1], np.diff(places, axis=0))


def test_the_null_takes_all_as_printed_and_nothing_if_normalised(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(flat_subgoal, "SHORT", TINY)
    monkeypatch.setattr(flat_subgoal, "strokes", lambda options, name: strokes())
    headline, figure = flat_subgoal.experiment(Options(out=tmp_path, quick=True, data=tmp_path))
    rows = {row["confidence"]: row for row in headline["rows"][flat_subgoal.SHOWN]}
    assert sorted(rows) == [1, 3, 30]
    for row in rows.values():
        assert row["printed"]["share_of_null"] > 0.95
        assert row["printed"]["observations_on_null"] == pytest.approx(40 * row["printed"]["share_of_null"])
    assert rows[3]["normalised"]["share_of_null"] < 0.05
    assert rows[3]["normalised"]["subgoals"] == 2
    assert len(figure.axes) == 3


def test_the_null_is_one_more_candidate_of_the_same_prior() -> None:
    demos = strokes()
    fair = action_comparison(demos, epsilon_net(demos), confidence=3.0)
    printed = flat_subgoal.with_null(literal_maximum(fair), "printed", fair)
    normalised = flat_subgoal.with_null(fair, "normalised", fair)
    count = fair.n_candidates + 1
    assert np.exp(normalised.log_prior) == pytest.approx(np.full(count, 1 / count))
    assert (printed.dense[:, -1] == 0).all()
    background = fair.with_background(1 / count)
    np.testing.assert_allclose(normalised.dense, background.dense, atol=1e-12)
    np.testing.assert_allclose(normalised.log_prior, background.log_prior, atol=1e-12)
