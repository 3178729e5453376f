"""Groups of trajectories: from a column of a file through every step to the demonstrations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from subgoal.demonstrations import Demonstrations, Recording, read, read_recording
from subgoal.runtime.errors import InputError, ReadError

HEAD = "t,x,y,walk,animal\n"


def rows(walk: object, animal: str, count: int = 4, begin: float = 0.0) -> list[str]:
    return [f"{begin + k},{k},{k % 2},{walk},{animal}" for k in range(count)]


@pytest.fixture
def table(tmp_path):
    def write(*lines, head=HEAD):
        path = tmp_path / "table.csv"
        path.write_text(head + "\n".join(lines) + "\n")
        return path

    return write


def mixed(table):
    """Walks 7 and 9 of the fox and 3 of the cat, rows interleaved."""
    parts = rows(7, "fox"), rows(3, "cat"), rows(9, "fox")
    return table(*(line for each in zip(*parts, strict=True) for line in each))


def test_one_group_for_each_trajectory_in_the_order_of_the_trajectories(table):
    demos = read(mixed(table), trajectory="walk", group="animal")
    assert demos.trajectory_names == ("7", "3", "9")
    assert demos.groups == ("fox", "cat", "fox")
    assert demos.group_names == ("cat", "fox")
    assert demos.group.tolist() == [1, 0, 1]


def test_numbers_of_animals_are_kept_as_written(table):
    path = table(*rows(1, "007"), *rows(2, "7"))
    assert read(path, trajectory="walk", group="animal").groups == ("007", "7")


def test_parquet(tmp_path):
    frame = pd.DataFrame({"x": np.arange(6.0), "y": 0.0, "id": [1, 1, 1, 2, 2, 2], "day": [3, 3, 3, 1, 1, 1]})
    frame.to_parquet(tmp_path / "a.parquet")
    assert read(tmp_path / "a.parquet", group="day").groups == ("3", "1")


def test_the_groups_column_does_not_tell_trajectories_apart_unless_it_is_said_to(table):
    path = table(*rows(1, "fox"), *rows(1, "cat", begin=10.0))
    with pytest.raises(
        ReadError,
        match=r"column 'animal', data row 5, counted from 1: found 'cat' after 'fox' in trajectory 'T0'.*trajec",
    ):
        read(path, group="animal")
    demos = read(path, trajectory="animal", group="animal")
    assert (demos.trajectory_names, demos.groups) == (("fox", "cat"), ("fox", "cat"))


def test_a_trajectory_with_two_groups_is_refused_with_its_row(table):
    with pytest.raises(
        ReadError, match=r"data row 7, counted from 1: found 'fox' after 'cat' in trajectory '3', wanted one group"
    ):
        read(table(*rows(7, "fox"), *rows(3, "cat", 2), "5,5,5,3,fox"), trajectory="walk", group="animal")


def test_two_groups_of_one_trajectory_are_noticed_where_their_times_are_the_same(table):
    lines = [line for each in zip(rows(1, "fox"), rows(1, "cat"), strict=True) for line in each]
    with pytest.raises(ReadError, match="'cat' after 'fox'"):
        read(table(*lines), trajectory="walk", group="animal")


@pytest.mark.parametrize("cell", ["", "  ", "NaN"])
def test_a_row_without_a_group_is_refused(table, cell):
    with pytest.raises(
        ReadError,
        match=r"column 'animal', data row 6, counted from 1: found no value, wanted the group of trajectory '3'",
    ):
        read(table(*rows(7, "fox"), *rows(3, "cat", 1), f"5,5,5,3,{cell}"), trajectory="walk", group="animal")


def test_rows_that_are_dropped_anyway_need_no_group(table):
    path = table(*rows(7, "fox"), "9,,1,7,", *rows(3, "cat"))
    demos = read(path, trajectory="walk", group="animal")
    assert demos.groups == ("fox", "cat")
    assert demos.source.notes == {"rows without a position dropped": 1}


@pytest.mark.parametrize(("group", "message"), [("beast", "column 'beast'"), (["animal"], "group: found")])
def test_a_group_that_is_no_column_is_refused(table, group, message):
    with pytest.raises(InputError, match=message):
        read(mixed(table), trajectory="walk", group=group)


def test_readers_without_such_a_column_say_so(tmp_path):
    (tmp_path / "poses.txt").write_text("1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n")
    with pytest.raises(InputError, match="options: found group"):
        read(tmp_path / "poses.txt", format="tum", group="animal")


def test_groups_stay_with_their_trajectories_on_every_way(table):
    """Cut at a gap, resampled, thinned, too short, starting elsewhere: the names say which group it must be."""
    path = table(
        *rows("cat 1", "cat", 4), *rows("cat 1", "cat", 4, 50.0), *rows("fox 1", "fox", 1), *rows("fox 2", "fox", 5),
        "0,9,9,owl 1,owl", "1,8,9,owl 1,owl", "2,7,9,owl 1,owl", *rows("fox 3", "fox", 6),
    )  # fmt: skip
    for way in (
        {"max_gap": 5.0}, {"rate": 3.0, "max_gap": 5.0}, {"every": 2}, {"thin": 1.5},
        {"start_within": [(-1, 5), (-1, 5)]},
        {"velocity": "savgol", "window": 5, "max_gap": 5.0}, {"period": [4.0, np.inf]},
    ):  # fmt: skip
        demos = read(path, trajectory="walk", group="animal", **way)
        assert demos.groups == tuple(name[:3] for name in demos.trajectory_names), way
        assert len(demos.groups) == demos.n_trajectories
    whole = read_recording(path, trajectory="walk", group="animal")
    assert whole.groups == ("cat", "fox", "fox", "owl", "fox")


def test_pieces_of_a_clock_that_jumps_keep_their_group(table):
    path = table(*rows("cat 1", "cat"), *rows("cat 1", "cat"), *rows("fox 1", "fox"))
    cut = read_recording(path, trajectory="walk", group="animal", clock="split")
    assert (cut.trajectory_names, cut.groups) == (("cat 1/0", "cat 1/1", "fox 1"), ("cat", "cat", "fox"))


def test_arrays(tmp_path):
    np.savez(tmp_path / "a.npz", positions=np.arange(12.0).reshape(6, 2), offset=[0, 3, 6], animal=[4, 2], bad=[0.5, 1])
    np.savez(tmp_path / "b.npz", states=np.arange(6.0), actions=np.ones(6), offset=[0, 3, 6], animal=[4, 2])
    assert read(tmp_path / "a.npz", group="animal").groups == ("4", "2")
    assert read(tmp_path / "b.npz", group="animal").groups == ("4", "2")
    for name in ("bad", "offset", "beast"):
        with pytest.raises(ReadError, match=f"array '{name}'"):
            read(tmp_path / "a.npz", group=name)


def test_mice_are_groups_of_their_bouts(tmp_path):
    lines = ["session,bout,step,node,frame_in_bout", "C4,7,0,0,0"]
    lines += [f"{who},{bout},{k},{node},{k}" for who, bout in (("D/9a", 1), ("A1b", 1), ("A1b", 2))
              for k, node in enumerate((0, 1, 0, 127))]  # fmt: skip
    (tmp_path / "visits.csv").write_text("\n".join(lines))
    path = tmp_path / "visits.csv"
    assert read(path, format="labyrinth", group="session").groups == ("D/9a", "A1b", "A1b")
    assert read(path, format="labyrinth").groups == ()
    with pytest.raises(InputError, match="'session'"):
        read(path, format="labyrinth", group="bout")


def test_records_take_one_name_for_each_trajectory():
    demos = Demonstrations.from_arrays(np.zeros(3), np.ones(3), groups=["b", "a", "b"])
    assert demos.group.tolist() == [1, 0, 1]
    for wrong in (["a"], "abc"):
        with pytest.raises(InputError, match="groups"):
            replace(demos, groups=wrong)
        with pytest.raises(InputError, match="groups"):
            Recording(np.zeros((3, 1)), np.arange(3), np.array([0, 1, 2, 3]), ("x",), groups=wrong)


def test_without_groups_their_numbers_are_refused_with_advice():
    demos = Demonstrations.from_arrays(np.zeros(3), np.ones(3))
    assert (demos.groups, demos.group_names) == ((), ())
    with pytest.raises(InputError, match="read"):
        demos.group  # noqa: B018
