"""Features and the groups of states that share them."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.candidates import feature_subgoals, visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bnirl import bnirl
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp.grids.features import feature_groups, manhattan, one_hot
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.runtime.errors import InputError


def room() -> GridWorld:
    free = np.ones((4, 5), bool)
    free[1, 2] = False
    return GridWorld(free, discount=0.9, slip=THESIS_SLIP)


def test_manhattan_distance_cell_by_cell() -> None:
    grid, anchors = room(), [(0, 0), (4, 3)]
    table = manhattan(grid, anchors)
    for s, (x, y) in enumerate(grid.cells):
        assert table[s].tolist() == [abs(x - a) + abs(y - b) for a, b in anchors]
    for anchor, match in (([(2, 1)], "inside a wall"), ([(5, 0)], "outside the map")):
        with pytest.raises(InputError, match=match):
            manhattan(grid, anchor)


def test_groups_are_the_states_with_equal_features() -> None:
    features = np.array([[1, 0], [0, 2], [1, 0], [0, 0], [0, 2]])
    groups = feature_groups(features)
    assert [each.tolist() for each in groups.members] == [[3], [1, 4], [0, 2]]
    np.testing.assert_array_equal(groups.vectors[groups.group], features)
    assert not groups.is_injective
    assert feature_groups(one_hot(6)).is_injective
    assert [each.tolist() for each in feature_groups([2, 1, 2]).members] == [[1], [0, 2]]


@pytest.mark.parametrize("features", [[[np.nan]], [[np.inf]], np.empty((0, 2)), "abc"])
def test_bad_features(features) -> None:
    with pytest.raises(InputError, match="features"):
        feature_groups(features)


def walk(grid: GridWorld) -> Demonstrations:
    states = grid.states([(0, 0), (1, 1), (1, 2), (2, 3), (3, 3), (4, 3), (4, 3)])
    actions = [grid.action(name) for name in ("NE", "N", "NE", "E", "E", "stay", "stay")]
    return Demonstrations(states, np.array(actions), [0, 7], coordinates=grid.mdp.coordinates)


def test_only_met_features_are_candidates_when_asked() -> None:
    grid = room()
    groups = feature_groups(manhattan(grid, [(0, 0)]))
    everything = feature_subgoals(groups, coordinates=grid.mdp.coordinates)
    met = feature_subgoals(groups, walk(grid), coordinates=grid.mdp.coordinates)
    assert everything.n_candidates == 8
    assert met.names == ("Φ = (0)", "Φ = (2)", "Φ = (3)", "Φ = (5)", "Φ = (6)", "Φ = (7)")
    np.testing.assert_allclose(met.points[-1], [4, 3])
    cells = grid.cells[met.goal_sets[2]]
    assert (cells.sum(axis=1) == 3).all()


@pytest.mark.filterwarnings("ignore")
def test_injective_features_are_states() -> None:
    """Six generic anchors tell all cells apart: feature subgoals and state subgoals are one and the same."""
    grid = room()
    groups = feature_groups(manhattan(grid, [(0, 0), (4, 0), (0, 3), (3, 1), (1, 2), (2, 2)]))
    assert groups.is_injective
    demos = walk(grid)
    states, features = visited(demos), feature_subgoals(groups, demos, coordinates=grid.mdp.coordinates)
    place = {int(members[0]): g for g, members in enumerate(features.goal_sets)}
    order = [place[int(members[0])] for members in states.goal_sets]
    first, second = (planned_actions(demos, each, grid.mdp).dense for each in (states, features))
    np.testing.assert_allclose(second[:, order], first, atol=1e-6)
    shares = [
        bnirl(demos, grid.mdp, candidates=each, draws=1500, warmup=100, thin=2).expected_shares
        for each in (states, features)
    ]
    np.testing.assert_allclose(shares[1][order], shares[0], atol=0.05)
