"""Figures of chapter 3: what their numbers say, and that they are drawn."""

from __future__ import annotations

import pytest

from experiments import fig_3_2, fig_3_3
from experiments.common import Options


def test_the_printed_prior_is_flat_and_the_scaled_one_has_three_peaks(tmp_path) -> None:
    headline, figure = fig_3_2.experiment(Options(tmp_path))
    assert headline["as_printed"]["zero_against_R_max"] == pytest.approx(1, abs=1e-6)
    assert headline["as_printed"]["deviation_of_a_peak_in_R_max"] == pytest.approx(2236, abs=1)
    assert headline["scaled"]["zero_against_R_max"] == pytest.approx(2.5, rel=1e-3)
    assert headline["scaled"]["zero_against_half_R_max"] > headline["scaled"]["zero_against_R_max"]
    assert headline["claims"][0]["verdict"] == "does not hold"
    for prior, low in ((fig_3_2.PRINTED, 0.999), (fig_3_2.SCALED, 0.0)):
        drawn = fig_3_2.densities(prior)
        assert drawn.max() == 1 and low < drawn.min() < low + 0.1
    assert len(figure.axes) == 2


def test_relevance_is_the_visited_cells_and_a_tube_around_them(tmp_path) -> None:
    headline, figure = fig_3_3.experiment(Options(tmp_path, quick=True))
    for layout in ("layout_A", "layout_B"):
        row = headline[layout]
        assert row["narrow_is_visited_only"] and row["visits_of_upper_right"] == 0
        assert row["relevant"]["narrow"] == row["visited"] < row["relevant"]["wide"] < row["states"]
    assert [claim["verdict"] for claim in headline["claims"]] == ["holds", "holds"]
    assert len(figure.axes) == 7
