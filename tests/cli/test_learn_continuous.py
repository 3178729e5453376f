"""``subgoal learn --likelihood gp``: planning in a continuous world."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from subgoal.irl.confidence_sweep import confidence_sweep
from tests.cli.conftest import QUICK
from tests.likelihood.point_mass import there_and_back

READ = ("-p", "x,y", "--action", "u,v", "-t", "t")
PROCESSES = ("--likelihood", "gp", "--epsilon", "0.3", "-a", "40")
MODEL = """
def push(states, actions, duration):
    return states + duration * actions

def other(states, actions, duration):
    return states[:, :1]

number = 3
"""


@pytest.fixture
def laps(tmp_path: Path) -> Path:
    """Four samples of each half second of three laps round three corners."""
    demos, _, _ = there_and_back()
    part = np.arange(4)[None, :, None] / 4 * 0.5
    states = (demos.states[:, None] + part * demos.actions[:, None]).reshape(-1, 2)
    actions = np.repeat(demos.actions, 4, axis=0)
    data = pd.DataFrame(np.column_stack([0.125 * np.arange(len(states)), states, actions]), columns=list("txyuv"))
    data.to_csv(tmp_path / "laps.csv", index=False)
    (tmp_path / "model.py").write_text(MODEL)
    return tmp_path / "laps.csv"


def learned(subgoal, laps, out, *words):
    return subgoal("learn", laps, *READ, *PROCESSES, "--every", "4", "--out", out, *QUICK, *words)


def corners_found(out: Path) -> np.ndarray:
    goals = pd.read_csv(out / "subgoals.csv")
    places = goals.loc[goals["share"] >= 0.05, ["x", "y"]].to_numpy()
    return np.array([np.linalg.norm(places - corner, axis=1).min() for corner in ((3, 0), (3, 3), (0, 0))])


def test_corners_are_found_with_a_model_of_ones_own(subgoal, laps: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = learned(subgoal, laps, out, "--dynamics", f"{laps.parent / 'model.py'}:push", "--action-bounds=-1:1,-1:1")
    assert answer.code == 0, answer.err
    assert "a pair every 0.5 s" in answer.out
    assert "candidates can be held" in answer.out
    assert (corners_found(out) < 0.5).all()
    summary = json.loads((out / "summary.json").read_text())
    assert "decides every 0.5, looks 2.5 ahead" in summary["settings"]["planner"]
    assert "Value functions and phase portraits" in (out / "report.html").read_text()
    assert (out / "portraits.png").stat().st_size > 10_000


def test_a_model_is_learned_where_none_is_given(subgoal, laps: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = learned(subgoal, laps, out)
    assert answer.code == 0, answer.err
    assert "LearnedDynamics(linear, a step is 0.5 s, held-out error" in answer.out
    assert (corners_found(out) < 0.5).all()


def test_order_may_say_nothing(subgoal, laps: Path, tmp_path: Path) -> None:
    answer = learned(subgoal, laps, tmp_path / "out", "--dwell", "0", "--warmup", "80")
    assert answer.code == 0, answer.err
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["settings"]["sampler"] == "annealed"


def test_numbers_may_be_learned(subgoal, laps: Path, tmp_path: Path) -> None:
    answer = learned(subgoal, laps, tmp_path / "out", "--learn-all")
    assert answer.code == 0, answer.err
    assert "persistence" in json.loads((tmp_path / "out" / "summary.json").read_text())["learned"]


def test_a_report_can_be_made_again(subgoal, laps: Path, tmp_path: Path) -> None:
    learned(subgoal, laps, tmp_path / "out")
    answer = subgoal("report", tmp_path / "out", "--merge-radius", "0.2")
    assert answer.code == 0, answer.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--dynamics", "magic"), "model.py:function"),
        (("--dynamics", "nowhere.py:push"), "no file nowhere.py"),
        (("--dynamics", "{model}:number"), "no function 'number'"),
        (("--dynamics", "{model}:other"), "shape"),
        (("--action-bounds", "0:1"), "2"),
        (("--action-bounds=0:0.1,0:0.1",), "actions"),
        (("--action-bounds", "low"), "low:high"),
        (("--floor", "1"), "floor"),
        (("--floor", "1,1", "--weights", "1,1"), "none beside --weights"),
        (("--gain", "2"), "--gain"),
        (("--cell", "1"), "--likelihood grid"),
        (("--dwell", "-1"), "dwell: found -1.0, wanted a finite number of at least 0"),
        (("--hold", "1.5"), "share of the future"),
        (("--epsilon", "50"), "more states than dimensions"),
    ],
)
def test_what_does_not_fit_is_refused(subgoal, laps: Path, tmp_path: Path, words, said) -> None:
    model = laps.parent / "model.py"
    answer = learned(subgoal, laps, tmp_path / "out", *(word.format(model=model) for word in words))
    assert answer.code == 2
    assert said in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "options"),
    [
        (("--horizon", "1e9"), ("--horizon (it is 1e+09, a step is 0.5)", "--hold")),
        (("--rate", "2", "--every", "60"), ("--every", "--rate", "one pair in each trajectory")),
        (("--action-bounds=0:0.1,0:0.1",), ("wider bounds (--action-bounds)",)),
    ],
)
def test_what_to_try_is_an_option(subgoal, laps: Path, tmp_path: Path, words, options) -> None:
    answer = learned(subgoal, laps, tmp_path / "out", *words)
    assert answer.code == 2
    said, tried = answer.err.split(" Try: ")
    assert all(option in said + tried for option in options)
    for word in ("width", "ContinuousWorld", "numpy"):
        assert word not in tried.split("in Python")[0]


@pytest.mark.parametrize("words", [("--dynamics", "linear"), ("--floor", "1,1"), ("--dwell", "2"), ("--horizon", "3")])
def test_its_options_want_it_beside_them(subgoal, laps: Path, tmp_path: Path, words) -> None:
    answer = subgoal("learn", laps, *READ, *words, "--out", tmp_path / "out")
    assert answer.code == 2
    assert "--likelihood gp beside it" in answer.err


def test_a_model_that_says_nothing_is_warned_of(subgoal, laps: Path, tmp_path: Path) -> None:
    noise = pd.read_csv(laps)
    noise[["x", "y"]] = np.random.default_rng(0).normal(size=(len(noise), 2)).cumsum(axis=0)
    noise.to_csv(laps, index=False)
    answer = learned(subgoal, laps, tmp_path / "out", "--dynamics", "neighbours", "--hold", "0")
    assert "where actions lead was not learned" in answer.err


def test_the_confidence_may_be_swept(subgoal, laps: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("subgoal.cli.write.confidence_sweep", partial(confidence_sweep, trials=2, sweeps=20))
    out = tmp_path / "out"
    answer = learned(subgoal, laps, out, "--sweep")
    assert answer.code == 0, answer.err
    told = pd.read_csv(out / "sweep.csv")
    assert (told.groupby("confidence").size() == 2).all()
    assert (out / "sweep.png").exists()
    assert not (out / ".sweep.npz").exists()
    assert subgoal("report", out, "--sweep").code == 2
    refused = learned(subgoal, laps, tmp_path / "other", "--sweep", "--learn-all")
    assert refused.code == 2
    assert "without --learn-all" in refused.err
