"""The labyrinth experiment on made walks whose goals are known, and its measures against counts by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments import labyrinth
from experiments.common import Options, find_data
from experiments.labyrinth_world import (
    HOME,
    NODES,
    WALKS,
    chance,
    decisions,
    markov,
    read_maze,
    some_bouts,
    walks,
    water_deliveries,
    world,
)
from subgoal.demonstrations.records import Demonstrations

WATER = 100


def way(node: int) -> list[int]:
    """Nodes from the first junction to ``node``, by the arithmetic of the tree."""
    passed = [node]
    while passed[0]:
        passed.insert(0, (passed[0] - 1) // 2)
    return passed


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """24 bouts that go to the water and home again, with a detour now and then; nodes lie on a line."""
    rng = np.random.default_rng(5)
    lines = ["session,bout,step,node,frame_in_bout,frame_abs,rewards"]
    for bout in range(24):
        visits = way(WATER) + way(WATER)[-2::-1]
        if bout % 4 == 0:
            aside = way(int(rng.integers(63, 127)))
            visits = aside + aside[-2::-1] + visits[1:]
        lines += [f"D9a,{bout},{k},{n},{k},{k},{int(n == WATER)}" for k, n in enumerate([*visits, HOME])]
    (tmp_path / WALKS).write_text("\n".join(lines) + "\n")
    nodes = [f"{n},,0,{n},0,{int(n == WATER)}" for n in range(HOME + 1)]
    (tmp_path / NODES).write_text("\n".join(["node,parent,level,x,y,is_water_port", *nodes]) + "\n")
    return tmp_path


def test_water_and_home_are_found_on_walks_to_water_and_home(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(labyrinth, "SHORT", {"draws": 20, "warmup": 20, "thin": 1, "workers": 1})
    monkeypatch.setattr(labyrinth, "QUICK", {"draws": 50, "warmup": 50, "thin": 1, "workers": 1})
    headline, figure = labyrinth.experiment(Options(out=folder, quick=True, data=folder))
    assert {item["node"] for item in headline["subgoals"][:2]} == {WATER, HOME}
    assert (headline["water_port"], headline["water_deliveries"]) == (WATER, 24)
    assert (headline["training"]["bouts"], headline["held_out"]["bouts"]) == (18, 6)
    assert headline["bits_per_decision"]["chance"] == pytest.approx(-np.log2(3), abs=1e-12)
    assert headline["bits_per_decision"]["BNIRL, mixture"] > -1.2
    assert headline["bits_per_decision"]["Markov chain, second order"] > -0.7
    best = max(headline["tried"], key=lambda entry: entry["bits_per_decision"])
    assert (headline["gamma"], headline["alpha"]) == (best["gamma"], best["alpha"])
    assert len(figure.axes) == 2


def test_every_corridor_of_the_world_is_one_of_the_maze(folder: Path) -> None:
    mdp = world(0.9, read_maze(folder))
    for node in range(HOME):
        led = {int(mdp.row(node, a)[0][0]) for a in range(3) if mdp.available[node, a]}
        parent = (node - 1) // 2 if node else HOME
        assert led == ({parent, 2 * node + 1, 2 * node + 2} if node < 63 else {parent})
    assert mdp.terminal.tolist() == [False] * HOME + [True]
    demos = walks(folder, "D9a", read_maze(folder))
    for d in range(demos.n_trajectories):
        a, b = demos.offset[d], demos.offset[d + 1]
        follows = [*demos.states[a + 1 : b], demos.final_states[d]]
        for state, action, reached in zip(demos.states[a:b], demos.actions[a:b], follows, strict=True):
            assert mdp.row(int(state), int(action))[0].tolist() == [reached]


def bouts(*trajectories: list[tuple[int, int]]) -> Demonstrations:
    pairs = [pair for each in trajectories for pair in each]
    offset = np.append(0, np.cumsum([len(each) for each in trajectories]))
    return Demonstrations(np.array([s for s, _ in pairs]), np.array([a for _, a in pairs]), offset)


def test_markov_chains_count_actions_by_node_and_by_the_node_before() -> None:
    learned = bouts([(0, 0), (1, 0), (3, 2), (1, 1)], [(0, 0), (1, 0)])
    asked = bouts([(0, 2), (1, 0)], [(1, 0), (2, 1), (70, 2)])
    first = markov(learned, asked, 1, 0.5)
    np.testing.assert_allclose(first[0], np.array([2.5, 0.5, 0.5]) / 3.5, atol=1e-15)
    np.testing.assert_allclose(first[1], np.array([2.5, 1.5, 0.5]) / 4.5, atol=1e-15)
    np.testing.assert_allclose(first[3], np.full(3, 1 / 3), atol=1e-15)
    assert first[4].tolist() == [0, 0, 1]
    second = markov(learned, asked, 2, 0.5)
    np.testing.assert_allclose(second[0], np.array([2.5, 0.5, 0.5]) / 3.5, atol=1e-15)
    np.testing.assert_allclose(second[1], np.array([2.5, 0.5, 0.5]) / 3.5, atol=1e-15)
    np.testing.assert_allclose(second[2], np.full(3, 1 / 3), atol=1e-15)  # nobody came to 1 from home
    assert decisions(asked).tolist() == [True, True, True, True, False]
    assert chance(asked)[4].tolist() == [0, 0, 1]


def test_quarters_and_folds_share_the_bouts_out(folder: Path) -> None:
    demos = walks(folder, "D9a", read_maze(folder))
    for quarter in range(4):
        learned, asked = labyrinth.quarters(demos, quarter)
        assert asked.trajectory_names == demos.trajectory_names[6 * quarter : 6 * quarter + 6]
        assert sorted(learned.trajectory_names + asked.trajectory_names) == sorted(demos.trajectory_names)
    held = [name for _, asked in labyrinth.folds(demos) for name in asked.trajectory_names]
    assert sorted(held) == sorted(demos.trajectory_names)
    chosen = some_bouts(demos, [3, 1])
    rows = np.r_[demos.offset[3] : demos.offset[4], demos.offset[1] : demos.offset[2]]
    np.testing.assert_array_equal(chosen.states, demos.states[rows])
    ends = some_bouts(bouts([(0, 0)], [(5, 1)], [(9, 2)]), [2, 0])
    assert (ends.final_states.tolist(), ends.trajectory_names) == ([9, 0], ("T2", "T0"))


def test_standard_error_is_that_of_the_mean_over_bouts_as_clusters() -> None:
    """For bouts of equal length the clustered error is the spread of their means, by their number."""
    asked = bouts([(0, 0), (1, 1)], [(0, 1), (1, 0)], [(0, 2), (1, 2)])
    table = np.array([[0.5, 0.25, 0.25]] * 6)
    means = np.array([-1.5, -1.5, -2.0])
    wanted = np.sqrt(((means - means.mean()) ** 2).sum()) / 3
    assert labyrinth.standard_error(table, asked) == pytest.approx(wanted, rel=1e-12)


def test_recorded_sessions() -> None:
    found, reason = find_data("mouse_labyrinth", None)
    if found is None:
        pytest.skip(str(reason))
    maze = read_maze(found)
    assert (maze.water, maze.places.shape, len(np.unique(maze.places, axis=0))) == (116, (128, 2), 128)
    assert [water_deliveries(found, name) for name in ("D9a", "A1b", "D9b")] == [34, 11, 0]
    learned, asked = labyrinth.quarters(walks(found, "D9a", maze), 3)
    assert (learned.n_trajectories, asked.n_trajectories) == (35, 12)
    assert (int(decisions(learned).sum()), int(decisions(asked).sum())) == (2365, 474)
