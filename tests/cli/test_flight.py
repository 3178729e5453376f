"""Waypoints and flights on the command line."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from subgoal import save
from subgoal.flight import read_waypoints
from tests.flight.made import flip, square

pytest.importorskip("rotorpy")


@pytest.fixture
def learned(tmp_path):
    """A folder with the posterior of a square, gone round twice."""
    (tmp_path / "out").mkdir()
    save(square(2), tmp_path / "out" / "posterior.npz")
    return tmp_path / "out"


def test_waypoints_are_written_in_order(subgoal, learned, tmp_path):
    answer = subgoal("waypoints", learned, "--out", tmp_path / "w.json", "--dwell", 1.5)
    assert answer.code == 0, answer.err
    made = read_waypoints(tmp_path / "w.json")
    assert (made.cyclic, made.dwell.tolist()) == (True, [1.5] * 4)
    order = " → ".join(map(str, made.labels))
    assert f"4 waypoints, by number of the subgoal: {order}, and round again" in answer.out
    assert f"Written to {tmp_path / 'w.json'}" in answer.out


def test_visits_and_one_pass_are_options(subgoal, learned, tmp_path):
    assert subgoal("waypoints", learned, "-o", tmp_path / "v.csv", "--visits", "--quiet").out == ""
    assert len(read_waypoints(tmp_path / "v.csv")) == 8
    subgoal("waypoints", learned, "-o", tmp_path / "w.json", "--one-pass")
    assert not read_waypoints(tmp_path / "w.json").cyclic


def test_a_flight_is_written_drawn_and_told(subgoal, learned):
    answer = subgoal("fly", learned, "--speed", 1.5, "--rounds", 2)
    assert answer.code == 0, answer.err
    folder = learned / "flight"
    names = {"flight.csv", "flight.json", "flight.png", "flight.svg", "flight.gif"}
    assert {path.name for path in folder.iterdir()} == names
    told = json.loads((folder / "flight.json").read_text())
    assert (told["status"], told["plane"], len(told["places"])) == ("FLOWN", "yz", 9)
    assert 1.4 < told["largest_speed"] < 1.6
    assert told["tracking_rmse"] < 0.05
    assert "flown: every waypoint was reached" in answer.out
    assert "m from the demonstrated path (RMS)" in answer.out


def test_a_flip_is_flown_upside_down(subgoal, tmp_path):
    save(flip(), tmp_path / "posterior.npz")
    answer = subgoal("fly", tmp_path, "--out", tmp_path / "f", "--no-film")
    assert answer.code == 0, answer.err
    rows = list(csv.DictReader((tmp_path / "f" / "flight.csv").open()))
    top = max(rows, key=lambda row: float(row["z"]))
    assert abs(float(top["angle"]) - np.pi) < 0.3
    assert not (tmp_path / "f" / "flight.gif").exists()


@pytest.mark.parametrize(
    ("command", "words", "message"),
    [
        ("waypoints", ("--out", "w.txt"), "ends in .csv, .json"),
        ("waypoints", ("--out", "w.csv", "--least-share", "0.9"), "least_share"),
        (
            "waypoints",
            ("--out", "w.csv", "--frame", "a", "--height", "2"),
            "--frame and --height: found given, wanted none",
        ),
        ("waypoints", ("--out", "w.mcap", "--plane", "up"), "plane: found 'up'"),
        ("fly", ("--plane", "up"), "plane: found 'up'"),
        ("fly", ("--smoothing", "curvy"), "smoothing: found 'curvy', wanted 'stop' or 'through'"),
        ("fly", ("--one-pass", "--rounds", "2"), "rounds: found 2, wanted 1"),
        ("fly", ("--vehicle", "goose"), "wanted one of 'hummingbird', 'crazyflie'"),
        ("fly", ("--speed", "99"), "wanted at most 20 m/s"),
        ("fly", ("--one-pass", "--rounds", "3"), "--cyclic"),
        ("fly", ("--dwell", "1e9"), "--most-seconds"),
    ],
)
def test_bad_input_is_told_and_nothing_is_written(subgoal, learned, monkeypatch, command, words, message):
    monkeypatch.chdir(learned)
    answer = subgoal(command, learned, *words)
    assert (answer.code, message in answer.err) == (2, True), answer.err
    assert [path.name for path in learned.iterdir()] == ["posterior.npz"]


def test_what_to_know_of_the_subgoals_is_told_with_them(subgoal, learned, tmp_path, monkeypatch):
    drawn, known = [], "NOT CONVERGED: more sweeps are needed"
    monkeypatch.setattr("subgoal.plots.files.save_figure", lambda figure, *_: drawn.append(figure))
    assert known in subgoal("waypoints", learned, "--out", tmp_path / "w.csv").out
    assert known in subgoal("fly", learned, "--no-film").out
    assert json.loads((learned / "flight" / "flight.json").read_text())["notes"][0].startswith(known)
    assert any(known in text.get_text() for text in drawn[0].texts)


def test_a_film_of_another_flight_is_taken_away(subgoal, learned):
    (learned / "flight").mkdir()
    (learned / "flight" / "flight.gif").write_bytes(b"old")
    subgoal("fly", learned, "--no-film")
    assert not (learned / "flight" / "flight.gif").exists()


def test_places_are_merged_as_in_the_results_unless_told(subgoal, learned):
    (learned / "summary.json").write_text('{"merge_radius": 9.0}')
    assert "1 waypoint, by number" in subgoal("waypoints", learned, "--out", learned / "w.csv").out
    assert "1 waypoint, by number" in subgoal("fly", learned, "--no-film").out
    for words in (("waypoints", learned, "--out", learned / "w.csv"), ("fly", learned, "--no-film")):
        assert "4 waypoints, by number" in subgoal(*words, "--merge-radius", 0.3).out


@pytest.mark.parametrize(("words", "downwards"), [((), True), (("--no-y-down",), False)])
def test_pictures_point_down_as_those_of_the_results_do(subgoal, learned, monkeypatch, words, downwards):
    drawn = []
    (learned / "summary.json").write_text('{"y_down": true}')
    monkeypatch.setattr("subgoal.plots.files.save_figure", lambda figure, *_: drawn.append(figure))
    assert subgoal("fly", learned, "--no-film", *words).code == 0
    assert drawn[0].axes[0].yaxis_inverted() == downwards


def test_a_vehicle_that_loses_its_path_ends_with_1(subgoal, learned):
    answer = subgoal("fly", learned, "--noise", 5, "--no-film")
    assert (answer.code, "try less noise" in answer.out) == (1, True)


def test_a_folder_without_a_posterior_is_told(subgoal, tmp_path):
    for words in (("fly", tmp_path), ("waypoints", tmp_path, "--out", tmp_path / "w.csv")):
        answer = subgoal(*words)
        assert (answer.code, "posterior.npz" in answer.err) == (2, True)
        assert "subgoal learn" in answer.err
