"""The kitchen experiment on made games whose goals are known, and the game's rules and tiles by hand."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from experiments import overcooked
from experiments.common import Options, find_data
from experiments.overcooked_world import (
    ACTIONS,
    GAMES,
    LAYOUTS,
    STEPS,
    Kitchen,
    kitchen,
    read_games,
    read_kitchens,
    shown,
    start_of,
)

ROWS = ["XOXXDXX", "X  X  S", "X  X  X", "XXSXOXX"]
"""Two rooms of four cells: x = 1, 2 and x = 4, 5."""
COLUMNS = ["split", "worker", "round", "layout", "t", "player", "x", "y", "ori_x", "ori_y", "held", "action", "event"]
ROUNDS = {0: ["O:1:0", "S:2:3"], 1: ["D:4:0", "S:6:1", "O:4:3"]}
STARTS = {0: (1, 1), 1: (4, 1)}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    text = "".join(f"{name}\n" + "\n".join(ROWS) + "\n\n" for name in ("asymmetric_advantages", "random0"))
    (tmp_path / LAYOUTS).write_text(text)
    with gzip.open(tmp_path / GAMES, "wt", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for layout in ("asymmetric_advantages", "random0"):
            for worker, split in enumerate(("train", "train", "test")):
                for player in (0, 1):
                    writer.writerows(game(split, worker, layout, player))
    return tmp_path


def game(split: str, worker: int, layout: str, player: int) -> list[list[Any]]:
    """Twelve rounds of a cook who goes the shortest way to each tile in turn, uses it, and thinks now and then."""
    rng = np.random.default_rng(worker)
    rows: list[Any] = []
    (x, y), facing = STARTS[player], 0
    for name in ROUNDS[player] * 12:
        goal = (int(name.split(":")[1]), int(name.split(":")[2]))
        while (x + STEPS[facing][0], y + STEPS[facing][1]) != goal:
            aim = nearest_stand(goal)
            step = (int(np.sign(aim[0] - x)), 0) if aim[0] != x else (0, int(np.sign(aim[1] - y)))
            if step == (0, 0):
                step = (goal[0] - x, goal[1] - y)
            if rng.random() < 0.2:
                rows.append([x, y, facing, "stay", ""])
            rows.append([x, y, facing, ACTIONS[STEPS.index(step)], ""])
            facing = STEPS.index(step)
            x, y = (x, y) if ROWS[y + step[1]][x + step[0]] != " " else (x + step[0], y + step[1])
        rows.append([x, y, facing, "interact", f"none>thing@{name}"])
    rows.append([x, y, facing, "stay", ""])
    return [
        [split, worker, 0, layout, t, player, x, y, *STEPS[f], "", action, event]
        for t, (x, y, f, action, event) in enumerate(rows)
    ]


def nearest_stand(goal: tuple[int, int]) -> tuple[int, int]:
    """The one floor cell beside a tile of this map."""
    (cell,) = [(goal[0] + dx, goal[1] + dy) for dx, dy in STEPS if free(goal[0] + dx, goal[1] + dy)]
    return cell


def free(x: int, y: int) -> bool:
    return 0 <= y < len(ROWS) and 0 <= x < len(ROWS[0]) and ROWS[y][x] == " "


def left_room(folder: Path) -> Kitchen:
    return kitchen(read_kitchens(folder)["random0"], (1, 1), 0.9)


def test_tiles_that_are_used_in_turn_are_found(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overcooked, "SHORT", {"draws": 50, "warmup": 50, "thin": 1, "workers": 1})
    headline, figure = overcooked.experiment(Options(out=folder, quick=True, data=folder))
    assert (headline["precision"], headline["recall"]) == (1.0, 1.0)
    assert headline["assignment_ari"] > 0.75
    assert headline["assignment_ari_identified"] > 0.75
    for side in headline["sides"]:
        assert {tile["tile"] for tile in side["tiles"] if tile["share"] >= 0.05} == set(ROUNDS[side["player"]])
        assert side["games"] == 1
    assert (headline["gamma"], headline["alpha"]) in [(row["gamma"], row["alpha"]) for row in headline["tried"]]
    assert len(figure.axes) == 4


def test_settings_are_those_that_agree_best_in_training_games(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def row(maps: Any, table: Any, split: str, gamma: float, alpha: float, seed: int) -> dict[str, Any]:
        asked.append(split)
        return {"gamma": gamma, "alpha": alpha, "assignment_ari": -alpha, "bits_per_decision": alpha}

    monkeypatch.setattr(overcooked, "SHORT", {"draws": 10, "warmup": 10, "thin": 1, "workers": 1})
    monkeypatch.setattr(overcooked, "row", row)
    headline, _ = overcooked.experiment(Options(out=folder, quick=True, data=folder))
    assert (headline["gamma"], headline["alpha"]) == (0.9, 3.0)
    assert headline["without_labels"]["chosen by prediction"]["alpha"] == 10
    assert asked == ["train", "train", "test", "test"]


def test_agreement_is_counted_where_a_label_can_be_told(folder: Path) -> None:
    maps, table = read_kitchens(folder), read_games(folder, ("random0",))
    settings = {"gamma": 0.9, "alpha": 100.0}
    length = {"draws": 50, "warmup": 50, "thin": 1}
    side = overcooked.learn(maps, table, "random0", 1, "train", settings, 0, length)
    assert side.posterior.likelihood is not None
    values, true = side.posterior.likelihood.dense, side.seen.next_tile
    assert values is not None
    pairs = [(i, int(true[i]), int(g)) for i, g in enumerate(overcooked.assignment(side.posterior)) if true[i] >= 0]
    told = [g == t or abs(values[i, t] - values[i, g]) > 1e-6 for i, t, g in pairs]
    assert 0 < sum(told) < len(told)
    assert (side.scores["labelled"], side.scores["identified"]) == (len(told), sum(told))
    assert side.scores["assignment_ari_identified"] > side.scores["assignment_ari"]


def test_rules_of_the_game(folder: Path) -> None:
    room = left_room(folder)
    assert list(room.cells) == [(1, 1), (1, 2), (2, 1), (2, 2)]
    for (x, y), c in room.cells.items():
        for facing in range(4):
            state = 4 * c + facing
            assert room.mdp.row(state, 4)[0].tolist() == [state]
            for action, (dx, dy) in enumerate(STEPS):
                there = (x + dx, y + dy) if free(x + dx, y + dy) else (x, y)
                assert room.mdp.row(state, action)[0].tolist() == [4 * room.cells[there] + action]
    tiles = {}
    sets: Any = room.candidates.goal_sets
    for name, members in zip(room.candidates.names, sets, strict=True):
        tiles[name] = [(list(room.cells)[s // 4], STEPS[s % 4]) for s in members]
    assert tiles == {
        "X:0:1": [((1, 1), (-1, 0))], "X:0:2": [((1, 2), (-1, 0))], "O:1:0": [((1, 1), (0, -1))],
        "X:1:3": [((1, 2), (0, 1))], "X:2:0": [((2, 1), (0, -1))], "S:2:3": [((2, 2), (0, 1))],
        "X:3:1": [((2, 1), (1, 0))], "X:3:2": [((2, 2), (1, 0))],
    }  # fmt: skip


def test_pairs_in_which_nothing_was_done_are_left_out_and_counted(folder: Path) -> None:
    room, (north, south, east, west) = left_room(folder), STEPS
    rows = [
        ((1, 1), north, "stay", ""),
        ((1, 1), north, "N", ""),  # faced already
        ((1, 1), north, "interact", "none>onion@O:1:0"),
        ((1, 1), north, "S", ""),
        ((1, 2), south, "E", ""),  # the recording says that nothing came of it
        ((1, 2), south, "E", ""),
        ((2, 2), east, "S", ""),
        ((2, 2), south, "interact", ""),  # nothing happened
        ((2, 2), south, "interact", "onion>none@S:2:3"),
        ((2, 2), south, "W", ""),
        ((1, 2), west, "N", ""),
    ]
    table = pd.DataFrame([
        ["test", 1, 0, "random0", t, 0, *cell, *facing, "", action, event]
        for t, (cell, facing, action, event) in enumerate(rows)
    ], columns=COLUMNS)  # fmt: skip
    seen = shown(table, room)
    demos, name = seen.demonstrations, room.candidates.names
    assert np.asarray(demos.times).tolist() == [2, 3, 5, 6, 7, 8, 9]
    assert [ACTIONS[a] for a in demos.actions] == ["interact", "S", "E", "S", "interact", "interact", "W"]
    cells = [(1, 1), (1, 1), (1, 2), (2, 2), (2, 2), (2, 2), (2, 2)]
    assert demos.states.tolist() == [
        4 * room.cells[cell] + f for cell, f in zip(cells, (0, 0, 1, 2, 1, 1, 1), strict=True)
    ]  # fmt: skip
    assert demos.final_states.tolist() == [4 * room.cells[1, 2] + 3]
    assert [name[g] if g >= 0 else "" for g in seen.next_tile] == ["O:1:0", *["S:2:3"] * 5, ""]
    assert {name[g]: int(n) for g, n in enumerate(seen.uses) if n} == {"O:1:0": 1, "S:2:3": 1}
    assert seen.use_shares.sum() == 1
    assert demos.source.notes == {
        "last row of a game": 1, "stay": 1, "steps against what is faced already": 1,
        "steps the model does not foretell": 1,
    }  # fmt: skip


def test_straight_ahead_is_the_tile_that_a_line_of_sight_meets(folder: Path) -> None:
    room = left_room(folder)
    states = np.array([4 * room.cells[1, 2] + f for f in (0, 0, 0, 2, 0)])
    ahead = overcooked.straight_ahead(room, states, np.array([0, 2, 3, 4, 1]))
    assert [room.candidates.names[g] for g in ahead] == ["O:1:0", "X:3:2", "X:0:2", "X:3:2", "X:1:3"]


def test_recorded_games_go_as_the_model_foretells() -> None:
    found, reason = find_data("overcooked_human", None)
    if found is None:
        pytest.skip(str(reason))
    maps, table = read_kitchens(found), read_games(found, ("asymmetric_advantages", "random0"))
    games = {"asymmetric_advantages": (9, 8), "random0": (6, 6)}
    for (layout, player, split), rows in table.groupby(["layout", "player", "split"]):
        seen = shown(rows, kitchen(maps[layout], start_of(rows), 0.9))
        assert seen.demonstrations.n_trajectories == games[layout][split == "test"], (layout, player)
        assert set(seen.demonstrations.source.notes) == {
            "last row of a game", "stay", "steps against what is faced already",
        }  # fmt: skip
        assert seen.uses.sum() == (rows["event"] != "").sum()
        assert seen.demonstrations.n_observations + sum(seen.demonstrations.source.notes.values()) == len(rows)
