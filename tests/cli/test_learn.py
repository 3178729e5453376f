"""``subgoal learn`` and what it writes."""

from __future__ import annotations

import csv
import json
import os
import signal
import threading
from itertools import pairwise
from pathlib import Path

import numpy as np

import subgoal as library
from tests.cli.conftest import QUICK

FILES = {
    "subgoals.csv", "segments.csv", "summary.json", "posterior.npz", "report.html", "trajectories.png",
    "trajectories.svg", "segments.png", "segments.svg", "subgoal_count.png", "subgoal_count.svg",
    "count_posterior.png", "count_posterior.svg", "residuals.png", "residuals.svg",
}  # fmt: skip


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_writes_everything_and_finds_the_corner(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = subgoal("learn", corner, "-p", "x,y", "-t", "t", "-i", "id", "--out", out, *QUICK)
    assert answer.code == 0
    assert "2 subgoals" in answer.out
    assert {path.name for path in out.iterdir()} == FILES
    goals = table(out / "subgoals.csv")
    places = np.array([[float(row["x"]), float(row["y"])] for row in goals[:2]])
    for wanted in ((10, 0), (10, 10)):
        assert np.linalg.norm(places - wanted, axis=1).min() <= 1.0
    assert sum(float(row["share"]) for row in goals) <= 1 + 1e-9


def test_results_that_are_replaced_are_told_before_unless_they_go_on(
    subgoal, corner: Path, tmp_path: Path
) -> None:  # fmt: skip
    words = ("learn", corner, "-i", "id", "--out", tmp_path / "out", *QUICK)
    told = f"replaces the results in {tmp_path / 'out'}/"
    assert told not in subgoal(*words).out
    assert told in subgoal(*words).out
    assert told not in subgoal(*words, "--resume").out
    assert subgoal(*words, "-q").out == ""


def test_segments_cover_every_trajectory_once(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "-i", "id", "--out", out, "-q", *QUICK)
    rows = table(out / "segments.csv")
    edges = [(int(row["start"]), int(row["stop"])) for row in rows]
    assert edges[0][0] == 0
    assert all(a[1] == b[0] for a, b in pairwise(edges))
    assert edges[-1][1] == json.loads((out / "summary.json").read_text())["observations"]
    assert {row["trajectory"] for row in rows} == {"a", "b"}


def test_status_is_in_the_summary_and_the_exit_code_is_zero(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("learn", corner, "-i", "id", "--out", tmp_path / "out", "--draws", "5", "--warmup", "0")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert answer.code == 0
    assert summary["status"] == "NOT_CONVERGED"
    assert summary["converged"] is False
    assert "NOT CONVERGED" in answer.out


def test_same_seed_same_files(subgoal, corner: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        subgoal("learn", corner, "-i", "id", "--out", tmp_path / name, "-q", "--seed", 3, *QUICK)
    for file in ("subgoals.csv", "segments.csv", "trajectories.svg"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


def test_quiet_prints_nothing(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("learn", corner, "-i", "id", "--out", tmp_path / "out", "--quiet", *QUICK)
    assert (answer.code, answer.out, answer.err) == (0, "", "")


def test_named_places_stand_in_the_tables(subgoal, corner: Path, tmp_path: Path) -> None:
    places = tmp_path / "places.csv"
    places.write_text("x,y,name,prior\n10,0,the corner,1\n10,10,exit,1\n-5,5,nowhere,2\n")
    out = tmp_path / "out"
    answer = subgoal("learn", corner, "-i", "id", "--candidates", places, "--out", out, *QUICK)
    assert answer.code == 0
    assert {row["name"] for row in table(out / "subgoals.csv")} == {"the corner", "exit"}
    assert "the corner" in (out / "report.html").read_text(encoding="utf-8")


def test_report_again_with_another_merge_radius(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "-i", "id", "--out", out, "-q", *QUICK)
    assert subgoal("report", out, "--merge-radius", "100").code == 0
    assert len(table(out / "subgoals.csv")) == 1


def test_library_gives_what_the_command_gives(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "-p", "x,y", "-t", "t", "-i", "id", "--out", out, "-q", *QUICK)
    demos = library.read(corner, position=["x", "y"], time="t", trajectory="id")
    likelihood = library.action_comparison(demos, library.epsilon_net(demos), confidence=3)
    posterior = library.sample(likelihood, draws=60, warmup=40, thin=1, seed=0)
    np.testing.assert_array_equal(library.load(out / "posterior.npz").assignments, posterior.assignments)


def test_proportional_controller_and_weights(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal(
        "learn", corner, "-i", "id", "--controller", "proportional", "--weights", "1,2", "--out", tmp_path / "o", *QUICK
    )
    assert answer.code == 0
    assert table(tmp_path / "o" / "subgoals.csv")


def test_spreadsheet_with_decimal_commas(subgoal, corner: Path, tmp_path: Path) -> None:
    text = corner.read_text().replace(",", ";").replace(".", ",")
    (tmp_path / "sheet.csv").write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    subgoal("learn", corner, "-i", "id", "--out", tmp_path / "a", "-q", *QUICK)
    answer = subgoal("learn", tmp_path / "sheet.csv", "-i", "id", "--out", tmp_path / "b", "-q", *QUICK)
    assert answer.code == 0
    assert (tmp_path / "a" / "subgoals.csv").read_bytes() == (tmp_path / "b" / "subgoals.csv").read_bytes()


def test_interleaved_trajectories(subgoal, corner: Path, tmp_path: Path) -> None:
    head, *lines = corner.read_text().splitlines()
    half = len(lines) // 2
    mixed = [line for pair in zip(lines[:half], lines[half:], strict=True) for line in pair]
    (tmp_path / "mixed.csv").write_text("\n".join([head, *mixed]))
    subgoal("learn", corner, "-i", "id", "--out", tmp_path / "a", "-q", *QUICK)
    assert subgoal("learn", tmp_path / "mixed.csv", "-i", "id", "--out", tmp_path / "b", "-q", *QUICK).code == 0
    assert (tmp_path / "a" / "segments.csv").read_bytes() == (tmp_path / "b" / "segments.csv").read_bytes()


def test_stopping_keeps_the_draws_says_so_and_goes_on_from_there(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("learn", corner, "-i", "id", "--out", out, "--draws", "3000", "--warmup", "5", "--thin", "400")
    timer = threading.Timer(3.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    answer = subgoal(*words)
    timer.join()
    made = json.loads((out / "summary.json").read_text())["draws_made"]
    assert answer.code == 130
    assert 0 < made < 3000
    assert f"stopped with {made} of 3000 draws" in answer.err
    assert (out / ".checkpoint.npz").exists()


def test_a_biased_sampler_is_called_so(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("learn", corner, "-i", "id", "--sampler", "alg4_literal_sum", "--out", tmp_path / "out", *QUICK)
    assert answer.code == 0
    assert "NOT THE POSTERIOR" in answer.out
    assert "NOT THE POSTERIOR" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_what_was_dropped_on_the_way_in_is_told(subgoal, corner: Path, tmp_path: Path) -> None:
    lines = corner.read_text().splitlines()
    (tmp_path / "twice.csv").write_text("\n".join([*lines[:5], lines[4], *lines[5:]]))
    answer = subgoal("learn", tmp_path / "twice.csv", "--out", tmp_path / "out", *QUICK)
    assert "samples of repeated time dropped: 1" in answer.out


def test_a_column_called_id_tells_trajectories_apart(subgoal, corner: Path, tmp_path: Path) -> None:
    assert "in 2 trajectories" in subgoal("learn", corner, "--out", tmp_path / "out", *QUICK).out


def test_report_again_keeps_y_and_drops_what_is_stale(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "--y-down", "--controller", "proportional", "--out", out, "-q", *QUICK)
    before = (out / "trajectories.svg").read_bytes()
    assert (out / "residuals.png").exists()
    subgoal("report", out, "-q")
    assert (out / "trajectories.svg").read_bytes() == before
    assert not (out / "residuals.png").exists()


def test_far_coordinates_keep_their_digits(subgoal, corner: Path, tmp_path: Path) -> None:
    head, *lines = corner.read_text().splitlines()
    rows = [line.split(",") for line in lines]
    far = [",".join([repr(1e9 + float(x)), repr(float(y)), t, name]) for x, y, t, name in rows]
    (tmp_path / "far.csv").write_text("\n".join([head, *far]))
    answer = subgoal("learn", tmp_path / "far.csv", "--out", tmp_path / "out", *QUICK)
    assert "1e+09" not in answer.out
    places = np.array([float(row["x"]) for row in table(tmp_path / "out" / "subgoals.csv")])
    assert np.isin(places, [1e9 + float(x) for x, *_ in rows]).all()


def with_animals(corner: Path) -> Path:
    """The two tracks, each of an animal of its own."""
    head, *lines = corner.read_text().splitlines()
    file = corner.with_name("animals.csv")
    rows = [f"{line},{'fox' if line.endswith('a') else 'owl'}" for line in lines]
    file.write_text("\n".join([f"{head},animal", *rows]))
    return file


def test_groups_have_weights_of_their_own_and_a_table(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    out, file = tmp_path / "out", with_animals(corner)
    answer = subgoal("learn", file, "--group", "animal", "--out", out, *QUICK)
    assert answer.code == 0
    assert {row["group"] for row in table(out / "groups.csv")} == {"fox", "owl"}
    assert "Largest difference" in (page := (out / "report.html").read_text()) or "No two groups" in page
    demos = library.read(file, group="animal")
    likelihood = library.action_comparison(demos, library.epsilon_net(demos), confidence=3)
    posterior = library.sample(
        likelihood, model=library.models.Grouped(demos.group), draws=60, warmup=40, thin=1, seed=0
    )
    saved = library.load(out / "posterior.npz")
    np.testing.assert_array_equal(saved.assignments, posterior.assignments)
    assert saved.demonstrations.groups == ("fox", "owl")
    assert subgoal("report", out, "-q").code == 0
    assert {row["group"] for row in table(out / "groups.csv")} == {"fox", "owl"}


def test_learn_all_is_what_the_library_learns(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.irl.learn.PRELIMINARY", {"chains": 1, "draws": 8, "warmup": 8, "thin": 1})
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    out = tmp_path / "out"
    assert subgoal("learn", corner, "--learn-all", "--epsilon", "2", "--out", out, "-q", *QUICK).code == 0
    demos = library.read(corner, trajectory="id")
    likelihood = library.action_comparison(demos, library.epsilon_net(demos, 2.0))
    posterior = library.learn(likelihood, draws=60, warmup=40, thin=1, seed=0)
    saved = library.load(out / "posterior.npz")
    np.testing.assert_array_equal(saved.assignments, posterior.assignments)
    np.testing.assert_array_equal(saved.likelihood.weight, posterior.likelihood.weight)
    assert set(saved.parameters) == {"concentration", "persistence", "noise levels"}


def test_what_is_given_beside_learn_all_stays_as_it_is(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.irl.learn.PRELIMINARY", {"chains": 1, "draws": 8, "warmup": 8, "thin": 1})
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    out = tmp_path / "out"
    words = ("--learn-all", "-a", "5", "-e", "0.5", "--epsilon", "2", "--draws", "3", "--warmup", "0")
    answer = subgoal("learn", corner, *words, "--out", out)
    assert answer.code == 0
    assert "each observation counts as" in answer.out
    summary = json.loads((out / "summary.json").read_text())
    assert set(summary["learned"]) == {"persistence"}
    assert summary["weight_of_evidence"]["settled"] in (True, False)
    settings = summary["settings"]
    assert (settings["confidence"], settings["concentration"], settings["thin"]) == (5.0, 0.5, 5)
    assert settings["model"].startswith("Persistent")
    assert set(library.load(out / "posterior.npz").parameters) == {"persistence"}


def test_defaults_without_learn_all_are_those_of_sample(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    assert subgoal("learn", corner, "--draws", "2", "--epsilon", "4", "--out", tmp_path / "out", "-q").code == 0
    settings = json.loads((tmp_path / "out" / "summary.json").read_text())["settings"]
    wanted = {"confidence": 3.0, "concentration": 1.0, "warmup": 1000, "thin": 10, "sampler": "collapsed_blocks"}
    assert {name: settings[name] for name in wanted} == wanted


def test_sensitivity_is_shown_printed_and_written_and_only_where_asked(
    subgoal, corner: Path, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.setattr("subgoal.irl.sensitivity.SHORT", {"chains": 1, "draws": 4, "warmup": 4, "thin": 1})
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    out = tmp_path / "out"
    answer = subgoal("learn", corner, "--epsilon", "3", "--sensitivity", "--out", out, *QUICK)
    assert answer.code == 0
    assert "Under 6 other settings the number of subgoals" in answer.out
    assert len(table(out / "sensitivity.csv")) == 8
    assert "How sure are the settings" in (out / "report.html").read_text()
    subgoal("report", out, "-q")
    assert not (out / "sensitivity.csv").exists()
    assert "How sure are the settings" not in (out / "report.html").read_text()
    answer = subgoal("report", out, "-q", "--sensitivity")
    assert (answer.code, answer.out) == (0, "")
    assert len(table(out / "sensitivity.csv")) == 8


def test_learning_all_of_groups_says_that_they_do_not_last(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.irl.learn.PRELIMINARY", {"chains": 1, "draws": 8, "warmup": 8, "thin": 1})
    monkeypatch.setattr("subgoal.reporting.results._draw", lambda *arguments: None)
    words = ("--learn-all", "--group", "animal", "--epsilon", "2", "--draws", "3", "--warmup", "0")
    answer = subgoal("learn", with_animals(corner), *words, "--out", tmp_path / "out")
    assert "note: with groups (--group) how long subgoals last is not learned" in answer.out
    assert "With groups (--group) how long subgoals last is not learned" in (tmp_path / "out/report.html").read_text()
