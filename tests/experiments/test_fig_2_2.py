"""Figure 2-2: what is said of a value function by few of its values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments import fig_2_2
from experiments.common import Options, figure_style, plain
from experiments.fig_2_2 import ONCE, OWN, PEAKS, SIZE, World, lattice, peaks, world


@pytest.fixture(scope="module")
def place() -> World:
    return world(0.98, 4.0, fig_2_2.ALIKE)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory):
    with figure_style():
        return fig_2_2.experiment(Options(tmp_path_factory.mktemp("out"), quick=True))


def test_values_run_from_nought_to_one_and_are_greatest_at_the_best_peak(place: World) -> None:
    assert place.value.min() == 0 and place.value.max() == 1
    np.testing.assert_array_equal(place.cells[place.value.argmax()], PEAKS[0])


def test_points_are_where_they_are_said_to_be(place: World) -> None:
    np.testing.assert_array_equal(place.cells[peaks()], PEAKS)
    for side in (4, 8):
        cells = place.cells[lattice(side)]
        assert len(np.unique(cells, axis=0)) == side**2
        assert set(np.diff(np.unique(cells[:, 0]))) <= {SIZE // side}
        assert (np.abs(cells.mean(axis=0) - (SIZE - 1) / 2) <= 0.5).all()


def test_the_error_is_the_mean_over_all_cells_in_percent_of_the_range(place: World) -> None:
    process = place.learn(lattice(4))
    wanted = np.mean([abs(process.mean(cell[None])[0] - v) for cell, v in zip(place.cells, place.value, strict=True)])
    assert place.percent(process) == pytest.approx(100 * wanted)


def test_hyper_parameters_learned_elsewhere_are_used_as_they_are(place: World) -> None:
    once = place.learn(lattice(8))
    used = place.use(peaks(), once)
    assert (used.covariance.theta == once.covariance.theta).all() and used.noise == once.noise


def test_more_points_make_less_error_and_three_cannot_tell_their_length(answer) -> None:
    error = answer[0]["error_percent"]
    assert error["160 random"][OWN] < error["64 random"][OWN] < error["16 random"][OWN]
    assert error["64 lattice"][OWN] < error["16 lattice"][ONCE] < error["3 peaks"][ONCE] < error["3 peaks"][OWN]
    assert error["64 lattice"][OWN] == error["64 lattice"][ONCE]
    assert error["64 random"]["least"] <= error["64 random"][OWN] <= error["64 random"]["most"]


def test_claims_say_which_reading_of_the_text_fits(answer) -> None:
    verdicts = [claim["verdict"] for claim in answer[0]["claims"]]
    assert verdicts == ["holds", "does not hold: less", "holds", "holds", "does not hold: more"]


def test_the_numbers_can_be_written_and_the_picture_has_five_surfaces_and_a_chart(answer) -> None:
    headline, figure = answer
    assert plain(headline)["thesis_percent"]["3 peaks"] == 5.9
    assert len(figure.axes) == 6
    titles = [axis.get_title() for axis in figure.axes[1:5]]
    assert all("% off (thesis" in title for title in titles)


def test_quick_runs_are_of_fewer_worlds(answer, tmp_path: Path) -> None:
    assert len(answer[0]["sensitivity"]) == 12
    assert {row["discount"] for row in answer[0]["sensitivity"]} == {0.9, 0.98, 0.99}
