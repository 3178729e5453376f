"""The page: complete in itself, honest on its first screen, and deaf to names that try to be markup."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from subgoal.plots.style import colour
from subgoal.plots.words import headline
from subgoal.posterior.diagnostics import Status
from subgoal.reporting import report
from subgoal.reporting.safe import script_json
from tests.plots.example import EVIL, example


class Page(HTMLParser):
    """Tags with attributes, visible text in order, and the contents of the scripts."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.scripts: list[str] = []
        self._inside = ""
        self.feed(source)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = tag
        self.tags.append((tag, dict(attrs)))
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "script":
            self.scripts[-1] += data
        elif self._inside != "style" and data.strip():
            self.text.append(data.strip())

    @property
    def figures(self) -> dict:
        return json.loads(self.scripts[0], parse_constant=lambda name: pytest.fail(f"{name} in the data"))


def page_of(tmp_path: Path, **choice) -> tuple[Page, str]:
    posterior, found, cut = example(**choice)
    source = report(posterior, tmp_path / "page.html", found=found, cut=cut).read_text(encoding="utf-8")
    return Page(source), source


def test_headline_status_figure_and_table_come_first(tmp_path: Path) -> None:
    posterior, found, _ = example(2)
    page, _ = page_of(tmp_path)
    assert headline(posterior, found) in page.text[:4]
    before = page.text[: page.text.index("Segments")]
    assert "CONVERGED" in before
    assert "NOT CONVERGED" not in " ".join(page.text)
    for k in range(len(found.listed)):
        assert str(k + 1) in before
    assert {"class": "badge good", "role": "status"} in [attributes for _, attributes in page.tags]
    places = [attributes["id"] for tag, attributes in page.tags if tag == "div" and "id" in attributes]
    assert places[0] == "scene"
    assert sorted(places) == sorted(page.figures)


@pytest.mark.parametrize("status", [Status.NOT_CONVERGED, Status.INTERRUPTED, Status.FEW_CHAINS])
def test_a_posterior_that_is_not_to_be_trusted_says_so_in_red_before_anything_is_shown(
    tmp_path: Path, status: Status
) -> None:
    posterior, found, cut = example(2)
    source = report(replace(posterior, status=status), tmp_path / "p.html", found=found, cut=cut).read_text()
    page = Page(source)
    first = page.text[: page.text.index("Subgoals")]
    assert "NOT CONVERGED" in first or "INTERRUPTED" in first
    assert source.index('class="badge bad"') < source.index('id="scene"')
    assert any(advice in " ".join(first) for advice in ("raise", "resume"))


def test_nothing_is_fetched_from_anywhere(tmp_path: Path) -> None:
    from plotly.offline import get_plotlyjs

    page, source = page_of(tmp_path)
    assert [attributes for tag, attributes in page.tags if tag == "script" and "src" in attributes] == []
    assert not {"link", "img", "iframe", "object", "form", "a", "base"} & {tag for tag, _ in page.tags}
    policy = next(a["content"] for t, a in page.tags if t == "meta" and a.get("http-equiv"))
    assert policy is not None
    assert policy.startswith("default-src 'none'")
    assert "http" not in policy
    library = get_plotlyjs()
    assert source.count(library) == 1
    assert "http" not in source.replace(library, "").replace('http-equiv="Content', "")
    assert "showSendToCloud: false" in source
    assert len(source) - len(library) < 200_000


@pytest.mark.parametrize("dimension", [1, 2, 3])
def test_names_from_data_are_text_and_nothing_else(tmp_path: Path, dimension: int) -> None:
    page, source = page_of(tmp_path, dimension=dimension, named=True)
    assert [tag for tag, _ in page.tags].count("script") == 3
    assert "img" not in {tag for tag, _ in page.tags}
    assert not [name for _, attributes in page.tags for name in attributes if name.startswith("on")]
    assert EVIL in " ".join(page.text)
    assert EVIL not in source
    assert "<" not in page.scripts[0]
    assert "<img" not in json.dumps(page.figures)
    assert "&lt;img" in json.dumps(page.figures)


def test_colours_are_those_of_the_figures(tmp_path: Path) -> None:
    _, found, _ = example(2)
    page, source = page_of(tmp_path)
    for k in range(len(found.listed)):
        mine = [t for t in page.figures["scene"]["data"] if t.get("legendgroup") == f"goal {k}"]
        assert {t["marker"]["color"] for t in mine if "marker" in t} == {colour(k)}
        assert sum(t.get("showlegend", True) for t in mine) == 1
        assert f"background:{colour(k)}" in source
    strips = {t["name"]: t["marker"]["color"] for t in page.figures["strip"]["data"]}
    assert strips == {goal.name: colour(k) for k, goal in enumerate(found.listed) if goal.name in strips}


def test_every_observation_is_there_with_probability_time_and_trajectory(tmp_path: Path) -> None:
    posterior, _, cut = example(2)
    page, _ = page_of(tmp_path)
    seen = [
        (x, y, chance, time, name)
        for t in page.figures["scene"]["data"]
        if "customdata" in t
        for x, y, (chance, time), name in zip(t["x"], t["y"], t["customdata"], t["text"], strict=True)
    ]
    demos = posterior.demonstrations
    rows = range(posterior.n_observations)
    wanted = [
        (*demos.states[i], cut.probability[i, cut.labels[i]], 0.5 * (i % 20), f"walk {i // 20}")
        for i in rows
    ]  # fmt: skip
    for got, want in zip(sorted(seen), sorted(wanted), strict=True):
        assert got[:4] == pytest.approx(want[:4], abs=1e-3)
        assert got[4] == want[4]


def test_numbers_of_the_tables(tmp_path: Path) -> None:
    posterior, found, cut = example(2)
    page, _ = page_of(tmp_path)
    told = " ".join(page.text)
    goal = found.listed[0]
    assert f"{100 * goal.share:.0f} %" in told
    assert f"{100 * goal.share_interval[0]:.0f}–{100 * goal.share_interval[1]:.0f} %" in told
    assert f"Table of {len(cut)} segments" in told
    for fact in ("walks.csv", "rows dropped", "collapsed_blocks", posterior.settings.data, "0.1.0"):
        assert fact in told
    assert "Position (x$0, x$1) [m]" in told
    for name in posterior.diagnostics:
        assert name in told


def test_what_the_scene_leaves_out_is_a_sentence(tmp_path: Path) -> None:
    page, _ = page_of(tmp_path, dimension=5)
    assert any(text.endswith("hides a subgoal.\nFirst 3 of 5 dimensions.") for text in page.text)


def test_only_the_first_segments_are_listed(tmp_path: Path) -> None:
    page, _ = page_of(tmp_path, n=1_200, trajectories=300)
    assert sum(a.get("data-label") == "Observations" for _, a in page.tags) == 200
    assert any("more segments are not listed" in text for text in page.text)
    assert any("260 more trajectories are not shown" in text for text in page.text)


@pytest.mark.parametrize("dimension", [1, 2, 3, 5])
def test_a_loaded_posterior_without_its_likelihood(tmp_path: Path, dimension: int) -> None:
    posterior, _, _ = example(dimension)
    bare = replace(posterior, likelihood=None, assignments=None)
    page = Page(report(bare, tmp_path / "deep" / "p.html", title="A <title>").read_text())
    assert "distance" not in page.figures
    assert "Does the confidence fit?" not in page.text
    assert page.text.count("A <title>") == 2


def test_image_coordinates(tmp_path: Path) -> None:
    posterior, found, cut = example(2)
    turned = Page(report(posterior, tmp_path / "p.html", found=found, cut=cut, y_down=True).read_text())
    plain, _ = page_of(tmp_path)
    assert turned.figures["scene"]["layout"]["yaxis"]["autorange"] == "reversed"
    assert "autorange" not in plain.figures["scene"]["layout"]["yaxis"]
    angles = [next(t for t in p.figures["scene"]["data"] if "customdata" in t)["marker"]["angle"] for p in
              (plain, turned)]  # fmt: skip
    for upright, down in zip(*angles, strict=True):
        assert (upright + down) % 360 == pytest.approx(180, abs=1.1)


def test_a_failure_leaves_the_old_page_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "page.html"
    target.write_text("old")

    def torn(self: Path, text: str, **options: object) -> int:
        self.write_bytes(b"half a")
        raise OSError("disk full")

    monkeypatch.setattr(Path, "write_text", torn)
    with pytest.raises(OSError, match="disk full"):
        report(example(2)[0], target)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("page.html", b"old")]


def test_json_in_a_script_is_strict_and_inert() -> None:
    value = {"a": [float("nan"), float("inf"), 1.0, 2.5], "b": "</script>&\u2028"}
    packed = script_json(value)
    assert not set("<>&\u2028") & set(packed)
    assert json.loads(packed) == {"a": [None, None, 1, 2.5], "b": "</script>&\u2028"}
