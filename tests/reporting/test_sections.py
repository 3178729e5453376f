"""The sections that not every page has: when they are there, and that their numbers are those of the answers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from subgoal.answers.groups import group_shares
from subgoal.answers.segments import Segments, segments
from subgoal.answers.subgoals import subgoals
from subgoal.irl.reruns import Rerun, Sensitivity
from subgoal.likelihood.table import LogLikelihood
from subgoal.plots.style import OTHER_COLOUR, colour
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.reporting import report
from subgoal.reporting.boundaries import boundary_section, shown_trajectory, told_of
from subgoal.reporting.groups import group_figure, largest_difference, shares_of_groups
from subgoal.reporting.results import summary, write_results
from subgoal.reporting.sensitivity import rate_section, rate_words, sensitivity_section
from subgoal.reporting.tables import subgoal_table
from tests.answers.made import posterior_of
from tests.plots.example import EVIL, example
from tests.posterior.worlds import quiet_sample
from tests.reporting.made import PLACES, cells, changing
from tests.reporting.test_report import Page

NAMES = ("fox", "cat", "fox", "fox", "cat", EVIL)
MAYBE = ("Groups", "Learned numbers", "How sure are the settings", "Rate", "Boundaries", "What each observation counts")


def grouped(groups: tuple[str, ...] = NAMES, **choice: Any) -> Posterior:
    posterior, _, _ = example(2, **choice)
    return replace(posterior, demonstrations=replace(posterior.demonstrations, groups=groups))


def page_of(posterior: Posterior, path: Path, **options: Any) -> Page:
    return Page(report(posterior, path / "p.html", **options).read_text(encoding="utf-8"))


def test_each_section_is_there_where_it_applies_and_nowhere_else(tmp_path: Path) -> None:
    plain = page_of(example(2)[0], tmp_path)
    assert [name for name in MAYBE if name in plain.text] == ["Boundaries", "What each observation counts"]
    bare = page_of(replace(grouped(), assignments=None, likelihood=None), tmp_path)
    assert [name for name in MAYBE if name in bare.text] == []
    whole = page_of(
        replace(grouped(), parameters={"concentration": np.ones((4, 60))}), tmp_path, sensitivity=table_of(RATE)
    )
    assert [name for name in MAYBE if name in whole.text] == list(MAYBE)
    for page in (plain, bare, whole):
        places = [attributes["id"] for tag, attributes in page.tags if tag == "div" and "id" in attributes]
        assert sorted(places) == sorted(page.figures)


def test_unordered_observations_and_plain_tables_have_no_boundaries_and_no_weights(tmp_path: Path) -> None:
    page = page_of(quiet_sample(LogLikelihood.from_table(np.zeros((8, 2))), chains=1, draws=3, warmup=0), tmp_path)
    assert [name for name in MAYBE if name in page.text] == []


def test_shares_of_groups_in_table_and_figure(tmp_path: Path) -> None:
    posterior = grouped()
    shares = group_shares(posterior, found=subgoals(posterior))
    page = page_of(posterior, tmp_path)
    told = " ".join(page.text)
    assert EVIL in told
    for k in range(3):
        low, high = 100 * shares.interval[k, 0]
        assert f"{100 * shares.share[k, 0]:.0f} %" in told
        assert f"{low:.0f}–{high:.0f} %" in told
    low, high = 100 * shares.difference_interval[0, 0]
    assert f"{100 * shares.difference[0, 0]:+.0f}" in told
    assert f"{low:.0f} to {high:.0f}" in told or f"{low:.0f}–{high:.0f}" in told
    bars = page.figures["groups"]["data"]
    for s, bar in enumerate(bars[: len(shares.subgoals.listed)]):
        assert bar["marker"]["color"] == colour(s)
        assert bar["x"] == pytest.approx(100 * shares.share[:, s], abs=0.005)
    assert [sum(each) for each in zip(*(bar["x"] for bar in bars), strict=True)] == pytest.approx([100] * 3, abs=0.5)
    assert "<img" not in json.dumps(page.figures["groups"])
    evil, *others = page.figures["groups"]["layout"]["yaxis"]["ticktext"]
    assert (evil[:4], others) == ("&lt;", ["cat", "fox"])


def test_one_group_or_lost_assignments_have_no_shares() -> None:
    assert shares_of_groups(grouped(("fox",) * 6), subgoals(grouped())) is None
    assert shares_of_groups(replace(grouped(), assignments=None), subgoals(grouped())) is None


def test_the_largest_sure_difference_is_told_the_larger_group_first() -> None:
    """Group b is at the second place 9 times of 10 and a never; c always but in 4 draws of 50, which is not sure."""
    draws = np.zeros((50, 30), int)
    draws[:, 10:19] = 1
    draws[4:, 20:] = 1
    shares = group_shares(posterior_of(draws, PLACES, offset=[0, 10, 20, 30]), ["a", "b", "c"])
    assert shares.subgoals.listed[0].position == [9.0]
    assert largest_difference(shares) == (
        "Largest difference: subgoal 1 has 90 % of the observations of b and 0 % of those of a: 90 to 90 percentage "
        "points more. The 90 % intervals of 2 of 6 differences leave zero out."
    )
    alike = group_shares(posterior_of(draws[:, :20] * 0, PLACES, offset=[0, 10, 20]), ["a", "b"])
    assert largest_difference(alike) == "No two groups surely differ in any subgoal."


def test_what_no_listed_subgoal_explains_is_grey_and_many_groups_are_cut() -> None:
    draws = np.tile(np.arange(80) % 2, (3, 1))
    posterior = posterior_of(draws, PLACES, offset=list(range(0, 81, 2)))
    hidden = np.array(posterior.assignments)
    hidden[:, :, 0] = -1
    shares = group_shares(replace(posterior, assignments=hidden), [f"g{k:02d}" for k in range(40)])
    bars = group_figure(shares)["data"]
    assert len(bars[0]["y"]) == 30
    assert bars[-1]["marker"]["color"] == OTHER_COLOUR
    assert bars[-1]["x"].tolist() == [50.0] + [0.0] * 29


def cut_of(chance: list[float], posterior: Posterior) -> Segments:
    return replace(segments(posterior), boundary=np.array(chance))


def test_boundaries_of_the_trajectory_with_the_most_segments() -> None:
    posterior = changing()
    cut = cut_of([1, 0.5, 0.5, 1, 0.1, 0.95, 0.2, 0.9, 0.35], posterior)
    figures: dict[str, Any] = {}
    page = Page(boundary_section(posterior, subgoals(posterior), cut, figures))
    assert shown_trajectory(posterior, cut) == 1
    *bars, chance = figures["boundaries"]["data"]
    assert chance["y"].tolist() == [0.1, 0.95, 0.2, 0.9, 0.35]
    assert chance["x"].tolist() == [1, 2, 3, 4, 5]
    assert {y for bar in bars for y in bar["y"]} == {0}
    assert {bar["yaxis"] for bar in bars} == {"y2"}
    assert sorted(base for bar in bars for base in bar["base"]) == [0, 2, 4]
    assert (
        "2.5 changes of subgoal are expected, and 2 of 6 steps are a sure one (at least 90 %). A tall thin bar is a cut"
        in " ".join(page.text)
    )


@pytest.mark.parametrize(("sure", "words"), [(0.5, "none of 6 steps is"), (0.9, "1 of 6 steps is")])
def test_how_many_boundaries_are_sure(sure: float, words: str) -> None:
    posterior = changing()
    assert words in told_of(posterior, cut_of([1, 0, 0, 1, 0, 0, 0, 0, sure], posterior), 1)


@pytest.mark.parametrize(
    ("model", "chances", "words"),
    [
        ("exchangeable", [0.9] * 5, "The 3 segments above have 2 changes between them: "
         "segments follow the most probable subgoal of each step, while expected changes are those within a draw, and "
         "in this model, in which nothing"),
        ("Grouped([0, 1])", [0.9] * 5, "steps that are unsure switch to and fro."),
        ("Persistent()", [0.9] * 5, "expected changes are those within a draw."),
        ("exchangeable", [0.1] * 5, "expected changes are those within a draw."),
        ("exchangeable", [0.5] * 5, "a change whose moment is not known."),
    ],
)  # fmt: skip
def test_why_expected_changes_are_not_those_between_segments(model: str, chances: list[float], words: str) -> None:
    posterior = replace(changing(), settings=replace(changing().settings, model=model))
    told = told_of(posterior, cut_of([1, 0, 0, 1, *chances], posterior), 1)
    assert words in told
    assert ("segments above" in told) == (chances[0] != 0.5)
    assert ("to and fro" in told) == (chances[0] == 0.9 and model != "Persistent()")


def test_places_that_are_listed_and_not_counted_are_marked() -> None:
    draws = np.array([[0] * 48 + [1] * 2] * 4)
    posterior = posterior_of(draws, PLACES)
    found = subgoals(posterior)
    assert (len(found), found.n_subgoals) == (2, 1)
    first, second = cells(subgoal_table(posterior, found), "Subgoal")
    assert "not counted" not in first
    assert "not counted: below 5 %" in second
    told = summary(posterior, found, segments(posterior, found))
    assert (told["n_subgoals"], [goal["counted"] for goal in told["subgoals"]]) == (1, [True, False])


def rerun(setting: str, kind: str, **other: Any) -> Rerun:
    fields: dict[str, Any] = {
        "every": 1, "n_observations": 60, "worth": 30.0, "n_subgoals": 2, "places": np.zeros((2, 1)), "rhat": 1.0,
        "shares": np.array([0.6, 0.3]), "moved": np.zeros(2), "change": np.zeros(2), "persistence": 0.9,
        "concentration": 1.0, "status": Status.CONVERGED,
    } | other  # fmt: skip
    return Rerun(setting, kind, **fields)


RATE = rerun(
    "every 2nd observation", "rate", every=2, n_observations=30, worth=20.0, n_subgoals=1, persistence=0.8,
    shares=np.array([0.5, 0.0]), moved=np.array([0.25, np.nan]), change=np.array([-0.1, -0.3]), rhat=1.3,
)  # fmt: skip


def table_of(*rows: Rerun, **other: Any) -> Sensitivity:
    fields = {"top": tuple(subgoals(changing()).items), "left_out": ("every 4th observation",), "unit": EVIL} | other
    return Sensitivity(rows=(rerun("as sampled", "as sampled"), *rows), **fields)


def test_settings_are_told_with_the_verdict_and_what_was_left_out() -> None:
    table = table_of(RATE)
    html = sensitivity_section(table)
    page = Page(html)
    assert table.verdict in page.text
    assert cells(html, "Setting") == ["as sampled", "every 2nd observation"]
    assert cells(html, "Subgoals") == ["2", "<b>1</b>"]
    assert cells(html, "Missing") == ["–", "<b>1</b>"]
    assert cells(html, "Shares change by up to") == ["0.0 points", "30.0 points"]
    assert cells(html, "ρ") == ["0.900", "0.800"]
    assert cells(html, "Counts as") == ["30", "20"]
    assert cells(html, "R-hat") == ["1.00", '<span class="fail">1.30</span>']
    assert "Stopped before: every 4th observation." in page.text
    assert "img" not in {tag for tag, _ in page.tags}
    loose = [replace(row, persistence=np.nan) for row in table.rows]
    assert "ρ" not in sensitivity_section(replace(table, rows=tuple(loose)))
    assert sensitivity_section(None) == ""


def test_rates_are_told_with_shares_and_stays_in_the_steps_of_the_recording() -> None:
    html = rate_section(changing(), table_of(RATE))
    assert cells(html, "Recording") == ["as recorded", "every 2nd observation"]
    assert cells(html, "Observations") == ["60", "30"]
    assert cells(html, "subgoal 1") == ["60 %", "50 %"]
    assert cells(html, "subgoal 2") == ["30 %", "–"]
    assert cells(html, "Subgoal drawn anew every") == ["10 observations (10 s)", "10 observations (10 s)"]
    assert rate_section(changing(), table_of(rerun("A", "weight"))) == ""
    assert rate_section(changing(), None) == ""


def test_whether_the_rate_decides() -> None:
    base, same = rerun("as sampled", "as sampled"), rerun("every 4th", "rate", change=np.array([0.02, 0.05]))
    assert rate_words(base, [same]).endswith("stays 2, shares change by at most 5.0 percentage points.")
    assert rate_words(base, [same, RATE]).endswith(
        "is 2 with all observations and 2 and 1 with fewer, shares change by at most 30.0 percentage points, 1 subgoal "
        "not found again."
    )


def rows_of(path: Path) -> list[list[str]]:
    return [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]


def test_tables_of_groups_and_settings_stand_in_the_folder_while_they_apply(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    posterior = grouped(("fox", "cat", "fox", "fox", "cat", "cat"))
    shares = group_shares(posterior)
    found = write_results(posterior, tmp_path, sensitivity=table_of(RATE)).found
    heads, first, *_ = rows_of(tmp_path / "groups.csv")
    wanted = ["cat", "60", "1", found.listed[0].name, *(repr(float(x)) for x in (shares.share[0, 0],
              *shares.interval[0, 0]))]  # fmt: skip
    assert dict(zip(heads, first, strict=True))["share_low"] == wanted[5]
    assert first == wanted
    assert float(rows_of(tmp_path / "groups.csv")[-1][4]) == shares.share[1, len(found.listed) - 1]
    assert len(rows_of(tmp_path / "groups.csv")) == 1 + 2 * len(found.listed)
    heads, _, last = rows_of(tmp_path / "sensitivity.csv")
    told = dict(zip(heads, last, strict=True))
    assert (told["setting"], told["missing"], told["largest_share_change"]) == ("every 2nd observation", "1", "0.3")
    assert "How sure are the settings" in (tmp_path / "report.html").read_text(encoding="utf-8")
    write_results(replace(posterior, demonstrations=replace(posterior.demonstrations, groups=())), tmp_path)
    assert not {"groups.csv", "sensitivity.csv"} & {path.name for path in tmp_path.iterdir()}


def test_given_subgoals_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    posterior, _, _ = example(2)
    found = subgoals(posterior, merge_radius=100.0)
    assert write_results(posterior, tmp_path, found=found).found is found
