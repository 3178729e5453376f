"""What each figure shows: as many artists as there are things, in the colours of their subgoals."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgba
from matplotlib.figure import Figure

from subgoal.answers.residuals import Residuals, residuals
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.plots import (
    plot_count_posterior,
    plot_recording,
    plot_residuals,
    plot_segments,
    plot_subgoal_count,
    plot_trajectories,
)
from subgoal.plots.shown import shown
from subgoal.plots.strips import strip_bars
from subgoal.plots.style import OTHER_COLOUR, PALETTE, colour, ink_on
from subgoal.plots.words import compact, headline, percent, reading, sure
from tests.plots.example import example


def words(figure: Figure) -> str:
    return "\n".join(text.get_text() for text in figure.texts)


def by_gid(figure: Figure, gid: str) -> list:
    return figure.findobj(lambda artist: artist.get_gid() == gid)


@pytest.mark.parametrize(("dimension", "panels"), [(1, 1), (2, 1), (3, 3), (5, 3)])
def test_every_listed_subgoal_has_one_disc_in_its_colour_per_panel(dimension: int, panels: int) -> None:
    posterior, found, cut = example(dimension)
    figure = plot_trajectories(posterior, found, cut)
    figure.draw_without_rendering()
    assert len(figure.axes) == panels
    assert len(found.listed) >= 2
    for k in range(len(found.listed)):
        discs = by_gid(figure, f"subgoal {k + 1}")
        assert [to_hex(disc.get_facecolor()[0]).upper() for disc in discs] == [colour(k)] * panels
        numbers = [text for axes in figure.axes for text in axes.texts if text.get_text() == str(k + 1)]
        assert len(numbers) == panels
    assert "first 3 of 5 dimensions" in words(figure) if dimension == 5 else "first 3" not in words(figure)


def test_observations_lie_where_they_were_in_the_colour_of_their_subgoal() -> None:
    posterior, found, cut = example(2)
    labels = np.where(np.arange(posterior.n_observations) < 3, -1, cut.labels)
    figure = plot_trajectories(posterior, found, replace(cut, labels=labels))
    (dots,) = by_gid(figure, "observations")
    np.testing.assert_array_equal(dots.get_offsets(), posterior.demonstrations.states)
    np.testing.assert_allclose(dots.get_facecolors(), [to_rgba(colour(int(k))) for k in labels])
    assert to_hex(dots.get_facecolors()[0]).upper() == OTHER_COLOUR


def test_disc_lies_on_the_subgoal_and_the_ring_has_the_radius_of_the_credible_set() -> None:
    posterior, found, cut = example(2)
    figure = plot_trajectories(posterior, found, cut)
    for k, goal in enumerate(found.listed):
        np.testing.assert_allclose(by_gid(figure, f"subgoal {k + 1}")[0].get_offsets()[0], goal.position)
        rings = by_gid(figure, f"credible set {k + 1}")
        assert [ring.width / 2 for ring in rings] == pytest.approx([goal.radius] * (goal.radius > 0))
    assert any(goal.radius > 0 for goal in found.listed)


def test_one_scale_on_both_axes_and_image_coordinates_on_request() -> None:
    posterior, found, cut = example(2)
    upright, turned = (plot_trajectories(posterior, found, cut, y_down=down).axes[0] for down in (False, True))
    assert upright.get_aspect() == 1
    assert upright.get_ylim()[0] < upright.get_ylim()[1]
    assert turned.get_ylim()[0] > turned.get_ylim()[1]
    assert upright.get_xlabel() == r"x\$0 [m]"


@pytest.mark.parametrize("converged", [True, False])
def test_the_sentence_and_the_status_stand_on_every_figure(converged: bool) -> None:
    posterior, found, cut = example(2, converged=converged)
    seen = residuals(posterior)
    figures = [
        plot_trajectories(posterior, found, cut),
        plot_subgoal_count(posterior),
        plot_count_posterior(found, posterior),
        plot_segments(posterior, found, cut),
        plot_residuals(posterior, seen),
    ]
    for figure in figures:
        assert ("NOT CONVERGED" in words(figure)) is not converged
    assert sure(found, posterior).split(";")[0] in words(figures[0]).replace("\n", " ")
    assert ("not settled" in sure(found, posterior)) is not converged


def test_arrows_only_while_there_are_few_observations() -> None:
    from matplotlib.quiver import Quiver

    few, many = example(2), example(2, n=1_200)
    assert len(plot_trajectories(*few).findobj(Quiver)) == 1
    assert not plot_trajectories(*many).findobj(Quiver)


def test_segments_are_drawn_from_start_to_the_next_one_in_their_colours() -> None:
    posterior, found, cut = example(2)
    figure = plot_segments(posterior, found, cut)
    (boxes,) = figure.axes[0].collections
    assert len(boxes.get_paths()) == len(cut)
    for shade, segment in zip(boxes.get_facecolors(), cut, strict=True):
        assert to_hex(shade[:3]).upper() == colour(segment.subgoal)
        assert shade[3] == pytest.approx(0.15 + 0.85 * segment.probability**2)
    bars, label = strip_bars(posterior, cut)
    assert len(bars) > posterior.demonstrations.n_trajectories
    assert label == "time since the start [s]"
    assert bars[0].start == 0
    for bar, later in pairwise(bars):
        assert bar.stop == pytest.approx(later.start) if bar.row == later.row else later.start == 0
    assert max(bar.stop for bar in bars) == pytest.approx(20 * 0.5)


def test_strip_tells_how_many_trajectories_it_leaves_out() -> None:
    posterior, found, cut = example(2, trajectories=60)
    figure = plot_segments(posterior, found, cut)
    assert "20 more trajectories are not shown" in words(figure)
    assert len(figure.axes[0].get_yticks()) == 40
    assert "not shown" not in words(plot_segments(*example(2)))


def test_traces_have_a_line_per_chain_and_a_shaded_warm_up() -> None:
    posterior, _, _ = example(2)
    upper, lower = plot_subgoal_count(posterior).axes
    for axes, name in ((upper, "n_active"), (lower, "log_joint")):
        assert len(axes.lines) == posterior.n_chains
        np.testing.assert_array_equal(axes.lines[1].get_ydata(), posterior.traces[name][1])
        assert axes.patches[0].get_width() == posterior.settings.warmup


def test_count_bars_are_the_posterior_probabilities() -> None:
    _, found, _ = example(2)
    found = replace(found, counted_per_draw=np.array([[2, 3, 3], [3, 5, 5]]))
    bars = plot_count_posterior(found).axes[0].patches
    assert {round(b.get_x() + b.get_width() / 2): b.get_height() for b in bars} == {2: 1 / 6, 3: 1 / 2, 5: 1 / 3}


def test_residual_histograms_are_shares_beside_what_the_model_expects() -> None:
    posterior, _, _ = example(2)
    seen = residuals(posterior)
    left, right = plot_residuals(posterior, seen).axes
    for axes in (left, right):
        bars = [patch for patch in axes.patches if hasattr(patch, "get_height")]
        assert sum(bar.get_height() for bar in bars) == pytest.approx(1)
    np.testing.assert_allclose(left.lines[0].get_ydata()[:-1], seen.expected)
    assert right.lines[0].get_ydata() == [pytest.approx(1 / 20)] * 2


@pytest.mark.parametrize(
    ("transform", "told"),
    [
        (np.linspace(0, 0.6, 50), "more precise than confidence 5"),
        (np.linspace(0.4, 1, 50), "less precise than confidence 5"),
        (np.linspace(0.01, 0.99, 50), "about what confidence 5 expects"),
        (np.linspace(0.3, 0.7, 50), "their shape is another"),
        (np.zeros(0), "No observation"),
    ],
)
def test_reading_of_the_residuals(transform: np.ndarray, told: str) -> None:
    posterior, _, _ = example(2)
    seen = Residuals(transform, transform, np.arange(transform.size), np.linspace(0, 2, 3), np.array([0.5, 0.5]))
    assert told in reading(posterior, seen)
    plot_residuals(posterior, seen).draw_without_rendering()


def test_recording_shows_paths_starts_ends_steps_and_speeds() -> None:
    generator = np.random.default_rng(0)
    places, times = generator.normal(size=(50, 2)), np.tile(np.arange(25) * 0.25, 2)
    offset = np.array([0, 25, 50])
    recording = Recording(places, times, offset, ("a", "b"), "m")
    figure = plot_recording(recording)
    figure.draw_without_rendering()
    starts, ends = (c for c in figure.axes[0].collections if c.get_label() in ("start", "end"))
    np.testing.assert_array_equal(starts.get_offsets(), places[[0, 25]])
    np.testing.assert_array_equal(ends.get_offsets(), places[[24, 49]])
    assert "median 0.25" in figure.axes[1].get_title(loc="right")
    assert figure.axes[2].get_xlabel() == "speed [m/s]"
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1)[np.arange(49) != 24] / 0.25
    assert f"median {np.median(speeds):.4g}" in figure.axes[2].get_title(loc="right")


@pytest.mark.parametrize("states", [np.arange(6), np.arange(6.0)[:, None], np.zeros((6, 2))])
def test_recording_of_anything(states: np.ndarray) -> None:
    """Discrete worlds, unordered pairs and places that never change are drawn too."""
    for offset in (None, [0, 3, 6]):
        figure = plot_recording(Demonstrations.from_arrays(states, np.zeros((6, 2)), offset))
        figure.draw_without_rendering()
        assert len(figure.axes) >= 3


def test_thinning_keeps_ends_and_tells() -> None:
    offset = np.array([0, 7, 50_000, 50_001, 90_000])
    part = shown(offset, 1_000)
    assert part.rows.size <= 1_000
    assert {0, 6, 49_999, 50_000, 89_999} <= set(part.rows.tolist())
    assert part.note == f"{part.rows.size:,} of 90,000 observations drawn"
    np.testing.assert_array_equal(np.repeat(np.arange(4), np.diff(part.offset)),
                                  np.searchsorted(offset, part.rows, side="right") - 1)  # fmt: skip
    everything = shown(offset, 90_000)
    assert everything.note == ""
    np.testing.assert_array_equal(everything.rows, np.arange(90_000))
    singles = shown(np.arange(30_001), 1_000)
    assert singles.rows.size <= 1_000
    assert singles.rows.size == len(singles.trajectory)


def test_words() -> None:
    posterior, found, _ = example(2)
    assert headline(posterior, found) == f"{found.n_subgoals} subgoals in 6 trajectories (120 observations)"
    assert percent(0.999) == "over 99 %"
    assert percent(0.001) == "under 1 %"
    assert percent(0.25) == "25 %"
    assert compact(np.array([1.23456, -0.0001]), 60.0) == "(1.2, 0.0)"
    assert compact(np.array([1.23456]), 0.1) == "(1.2346)"
    assert "100 %" not in sure(found)


def test_palette_is_distinct_and_readable() -> None:
    assert len(set(PALETTE)) == len(PALETTE) == 12
    assert colour(12) == PALETTE[0]
    assert colour(-1) == OTHER_COLOUR
    assert ink_on("#000000") == "#FFFFFF"
    assert ink_on("#DDB94F") == "#000000"
