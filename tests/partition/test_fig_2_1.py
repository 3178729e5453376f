"""The experiment's frame and Figure 2-1 itself: files, numbers, skipping, seeds."""

from __future__ import annotations

import json

import numpy as np
import pytest

from experiments import common, fig_2_1
from subgoal.partition.crp import expected_clusters


def tiny(options: common.Options):
    figure = common.sheet(2, 2)
    figure.subplots().plot([0, 1])
    return {"seed_seen": options.seed, "odd": np.float64("nan"), "array": np.arange(2), 3: (1, 2.5)}, figure


def test_the_frame_writes_two_files_and_one_last_line(tmp_path, capsys):
    common.run("tiny", tiny, argv=["--out", str(tmp_path / "a" / "b"), "--seed", "7", "--quick"])
    shown = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (shown["seed_seen"], shown["odd"], shown["array"], shown["3"]) == (7, None, [0, 1], [1, 2.5])
    assert shown["quick"] is True
    assert shown["seconds"] >= 0
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["tiny.json", "tiny.png"]
    assert json.loads((tmp_path / "a" / "b" / "tiny.json").read_text()) == shown
    assert (tmp_path / "a" / "b" / "tiny.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_recordings_that_are_not_there_are_skipped(tmp_path, capsys, monkeypatch):
    monkeypatch.delenv(common.DATA_VARIABLE, raising=False)
    common.run("tiny", tiny, "walks", argv=["--out", str(tmp_path / "out")])
    common.run("tiny", tiny, "walks", argv=["--out", str(tmp_path / "out"), "--data", str(tmp_path)])
    for line in capsys.readouterr().out.splitlines():
        assert list(json.loads(line)) == ["skipped"]
        assert "walks" in json.loads(line)["skipped"]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("by", ["argument", "variable", "own folder"])
def test_recordings_are_found(by, tmp_path, monkeypatch):
    folder = tmp_path / "walks"
    folder.mkdir()
    monkeypatch.delenv(common.DATA_VARIABLE, raising=False)
    if by == "variable":
        monkeypatch.setenv(common.DATA_VARIABLE, str(tmp_path))
    given = {"argument": tmp_path, "variable": None, "own folder": folder}[by]
    assert common.find_data("walks", given) == (folder, None)
    assert common.Options(out=tmp_path, data=folder).recordings == folder
    with pytest.raises(LookupError, match="needs="):
        _ = common.Options(out=tmp_path).recordings


@pytest.mark.parametrize("wrong", [["--seed", "-1"], ["--seed", "x"], ["--data", "/no/such/folder"], []])
def test_a_wrong_command_line_ends_with_status_2(wrong, tmp_path):
    out = ["--out", str(tmp_path)] if wrong else []
    with pytest.raises(SystemExit) as ended:
        common.run("tiny", tiny, argv=[*out, *wrong])
    assert ended.value.code == 2


def test_a_torn_write_leaves_the_old_file(tmp_path, monkeypatch):
    common.save(tmp_path / "numbers", b"old")
    monkeypatch.setattr(common.os, "replace", lambda *_: (_ for _ in ()).throw(OSError("disk")))
    with pytest.raises(OSError, match="disk"):
        common.save(tmp_path / "numbers", b"new")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"]


def test_style_is_undone():
    from matplotlib import rcParams

    before = rcParams["axes.grid"]
    with common.figure_style():
        assert rcParams["axes.grid"] is True
    assert rcParams["axes.grid"] == before


@pytest.fixture(scope="module")
def small():
    return fig_2_1.sample(0, chains=1, sweeps=6)


def test_five_clusters_are_found_within_twenty_sweeps(small):
    numbers = common.plain(fig_2_1.headline(small))
    assert numbers["clusters_at_20"] == numbers["clusters_at_25"] == 5
    assert numbers["sweeps_to_truth"] <= 20
    assert numbers["matched_at_25"] >= 0.9
    assert list(numbers["clusters_by_eta"]) == ["1", "10", "100", "1000", "10000"]
    for eta, row in numbers["clusters_by_eta"].items():
        assert row["prior"] == pytest.approx(expected_clusters(300, float(eta)), abs=0.01)
    assert numbers["clusters_by_eta"]["10000"]["all"] > 200
    assert all(chain["sweeps_to_truth"] is None for chain in numbers["literal"]["by_chain"])


def test_the_picture_has_all_its_panels(small):
    with common.figure_style():
        assert len(fig_2_1.picture(small).get_axes()) == len(fig_2_1.SHOWN) + 4


def test_matching_ignores_names_and_sees_merged_clusters():
    assert fig_2_1.matched_share((fig_2_1.TRUTH + 2) % 5) == 1.0
    assert fig_2_1.matched_share(np.minimum(fig_2_1.TRUTH, 3)) == 0.8
