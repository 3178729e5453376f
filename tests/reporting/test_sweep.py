"""Counts at each confidence in pictures, page and folder: when they are there, and that their numbers are right."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from subgoal.irl.sweep_record import Sweep
from subgoal.plots import plot_sweep, save_figure
from subgoal.plots.sweep import settled_number, sweep_words
from subgoal.reporting import report
from subgoal.reporting.results import write_results
from subgoal.reporting.sweep import sweep_section
from tests.plots.example import example
from tests.reporting.made import cells
from tests.reporting.test_report import Page


def swept(*means: int, left: tuple[float, ...] = ()) -> Sweep:
    """At levels 1, 2, 4, ...; five trials, one of which has one subgoal more wherever there are two or more."""
    counts = np.array([[m] * 4 + [m + (m > 1)] for m in means])
    return Sweep(2.0 ** np.arange(len(means)), counts, np.array(left), {"least_share": 0.03}, 1.0)


FOUND = swept(1, 1, 2, 3, 3, 3, 5, left=(128.0,))


def test_the_number_that_lasts_is_said_with_its_range() -> None:
    assert settled_number(FOUND) == 3
    assert sweep_words(FOUND) == "One subgoal up to confidence 2; 3 subgoals from 8 to 32, a factor of 4"
    assert settled_number(swept(1, 2, 4, 8)) is None
    assert sweep_words(swept(2, 4, 9)) == "More than one subgoal at every confidence; no other number lasts"
    assert settled_number(swept(1, 1, 1)) is None


def test_the_picture_shows_mean_spread_plateau_and_the_score_test(tmp_path: Path) -> None:
    axes = plot_sweep(FOUND, second=3.0).axes[0]
    line = axes.lines[1]
    np.testing.assert_allclose(line.get_ydata(), FOUND.mean)
    np.testing.assert_allclose(line.get_xdata(), FOUND.confidences)
    assert axes.get_xscale() == "log" and axes.texts[0].get_text() == "a second subgoal is likelier"
    assert len(plot_sweep(FOUND, second=np.inf).axes[0].texts) == 0
    save_figure(plot_sweep(FOUND), tmp_path, "sweep")
    assert (tmp_path / "sweep.png").stat().st_size > 5000


def test_the_section_has_the_sentence_the_curve_and_every_level() -> None:
    figures: dict[str, dict] = {}
    posterior = example(2)[0]
    html = sweep_section(posterior, FOUND, figures)
    page = Page(html)
    assert sweep_words(FOUND) + ". The answer above is at 5." in " ".join(page.text)
    assert "Stopped before: 128." in " ".join(page.text)
    assert cells(html, "Confidence") == ["1", "2", "4", "8", "16", "32", "64"]
    assert cells(html, "Subgoals, mean")[3] == "3.20" and cells(html, "± sd")[3] == "0.40"
    assert cells(html, "Least")[3] == "3" and cells(html, "Most")[3] == "4"
    np.testing.assert_allclose(figures["sweep"]["data"][0]["error_y"]["array"], 2 * FOUND.sd, atol=1e-3)
    assert sweep_section(posterior, None, figures) == ""


def test_the_page_has_it_where_it_is_given(tmp_path: Path) -> None:
    for sweep in (FOUND, None):
        page = Page(report(example(2)[0], tmp_path / "p.html", sweep=sweep).read_text(encoding="utf-8"))
        assert ("How many subgoals at each confidence" in page.text) == (sweep is not None)
        assert ("sweep" in page.figures) == (sweep is not None)


def test_the_folder_has_a_row_for_each_trial_while_it_applies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    posterior = example(2)[0]
    write_results(posterior, tmp_path, sweep=FOUND)
    with (tmp_path / "sweep.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == FOUND.counts.size
    assert [int(row["subgoals"]) for row in rows] == FOUND.counts.ravel().tolist()
    assert [float(row["confidence"]) for row in rows[:6]] == [1.0] * 5 + [2.0]
    assert (tmp_path / "sweep.svg").exists()
    write_results(posterior, tmp_path)
    assert not {"sweep.csv", "sweep.png", "sweep.svg"} & {path.name for path in tmp_path.iterdir()}
