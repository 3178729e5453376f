"""The softmax likelihood (4.2) against dense planning, and the rules that it must obey."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import log_softmax

import subgoal
from subgoal._kernels.softmax import softmax_tile
from subgoal.candidates import Candidates, every_state, visited, visited_and_successors
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import BudgetError, InputError, StorageError
from tests.mdp.small_worlds import corridor, world
from tests.oracles.subgoal_planning import subgoal_values


def walks(mdp: TabularMDP, seed: int, n: int = 30) -> Demonstrations:
    """Unordered pairs of states and legal actions."""
    generator = np.random.default_rng(seed)
    states = generator.choice(np.flatnonzero(~mdp.terminal), size=n)
    actions = [generator.choice(np.flatnonzero(mdp.available[s])) for s in states]
    return Demonstrations.from_arrays(states, np.array(actions))


@pytest.mark.parametrize("convention", ["continuing", "absorbing"])
@pytest.mark.parametrize("confidence", [0.3, 10.0, 300.0])
def test_the_table_is_a_log_softmax_of_exact_action_values(confidence: float, convention: str) -> None:
    for seed in range(3):
        mdp, dense = world(seed, 0.9, n_states=9, illegal=True, terminal=1)
        demos = walks(mdp, seed)
        candidates = Candidates.from_states([[0], [3], [8], [1, 2]])
        table = planned_actions(demos, candidates, mdp, confidence=confidence, convention=convention)
        for g, goal in enumerate(candidates.goal_sets):
            q = subgoal_values(*dense, goal.tolist(), 0.9, convention)[1]
            wanted = log_softmax(confidence * q[demos.states], axis=1)[np.arange(30), demos.actions]
            error = table.source.largest_error(confidence) + 1e-12 * confidence
            np.testing.assert_allclose(table.dense[:, g], wanted, rtol=1e-12, atol=error)


def test_probabilities_of_the_legal_actions_sum_to_one() -> None:
    mdp, _ = world(4, 0.95, n_states=8, illegal=True)
    pairs = np.argwhere(mdp.available)
    demos = Demonstrations.from_arrays(pairs[:, 0], pairs[:, 1])
    table = planned_actions(demos, every_state(mdp), mdp, confidence=4.0)
    total = np.zeros((8, 8))
    np.add.at(total, pairs[:, 0], np.exp(table.dense))
    np.testing.assert_allclose(total, 1, rtol=1e-13)


def test_an_error_of_the_values_moves_log_probabilities_by_at_most_twice_alpha_times_it() -> None:
    """Spec of the bound: ‖Q̃ − Q‖ ≤ e gives |log π̃ − log π| ≤ 2αe."""
    mdp, _ = world(2, 0.9, n_states=10, n_actions=4)
    demos = walks(mdp, 1)
    exact = planned_actions(demos, every_state(mdp), mdp, confidence=7.0)
    for tolerance in (1e-1, 1e-2, 1e-3):
        loose = planned_actions(demos, every_state(mdp), mdp, confidence=7.0, tolerance=tolerance)
        gap = np.abs(loose.source.plan.action_values - exact.source.plan.action_values).max()
        moved = np.abs(loose.dense - exact.dense).max()
        assert moved <= 2 * 7.0 * gap + 1e-12
        assert moved <= loose.source.largest_error(7.0) <= 2 * 7.0 * tolerance


def test_where_a_goal_is_out_of_reach_the_density_is_uniform_and_this_is_noted() -> None:
    mdp, _ = world(1, 0.9, n_states=8, one_way=True)
    demos = Demonstrations.from_arrays(np.array([7, 7, 6]), np.array([0, 1, 2]))
    table = planned_actions(demos, Candidates.from_states([0, 7]), mdp)
    np.testing.assert_allclose(table.dense[:, 0], -np.log(3))
    assert table.demonstrations.source.notes["pairs of observation and candidate out of reach"] >= 3


def test_another_confidence_and_tiles_give_the_same_numbers() -> None:
    mdp, _ = world(3, 0.9, n_states=10)
    demos = walks(mdp, 3)
    held = planned_actions(demos, every_state(mdp), mdp, confidence=5.0)
    other = planned_actions(demos, every_state(mdp), mdp, confidence=2.0)
    np.testing.assert_array_equal(held.at(2.0).dense, other.dense)
    tiled = planned_actions(demos, every_state(mdp), mdp, confidence=5.0, dense_entries=1)
    assert tiled.dense is None
    np.testing.assert_array_equal(np.concatenate([tile for _, tile in tiled.tiles()]), held.dense)


def test_goal_conventions_differ_by_the_scale_of_the_confidence() -> None:
    """Where goals can be held, absorbing values are (1 − γ) times continuing ones: α must be larger by 1/(1 − γ)."""
    mdp = corridor(9, 0.95)
    demos = Demonstrations.from_arrays(np.array([0, 1, 5, 8]), np.array([1, 1, 0, 0]))
    goals = Candidates.from_states([3, 7])
    held = planned_actions(demos, goals, mdp, confidence=2.0)
    once = planned_actions(demos, goals, mdp, confidence=2.0 / (1 - 0.95), convention="absorbing")
    np.testing.assert_allclose(held.dense, once.dense, atol=1e-6)


def test_arrivals_and_uninformative_pairs() -> None:
    table = np.zeros((3, 2, 3))
    table[0, 0, 1] = table[0, 1, 0] = table[1, 0, 2] = table[2, 1, 0] = table[2, 0, 2] = 1
    mdp = TabularMDP.from_dense(table, 0.9)
    demos = Demonstrations.from_arrays(np.array([0, 1, 2]), np.array([0, 0, 1]))
    made = planned_actions(demos, Candidates.from_states([[1], [0, 2]]), mdp)
    np.testing.assert_array_equal(made.arrived.toarray(), [[False, True], [True, False], [False, True]])
    np.testing.assert_array_equal(made.source.uninformative, [False, True, False])
    np.testing.assert_array_equal(made.dense[1], 0)
    assert made.demonstrations.source.notes["observations with one legal action"] == 1


@pytest.mark.parametrize(
    ("states", "actions", "match"),
    [
        ([0, 9], [0, 0], r"demonstrations\.states at index 1: found 9"),
        ([0, -1], [0, 0], r"demonstrations\.states at index 1: found -1"),
        ([0, 1], [0, 3], r"demonstrations\.actions at observation 1: found 3, wanted 0 to 2"),
        ([0, 1], [0, -1], r"demonstrations\.actions at observation 1"),
        ([3, 0], [0, 0], r"observation 0.*where episodes are over"),
        ([0, 1], [0, 1], r"observation 1: found 1, wanted a legal action of state 1"),
        ([0.5, 1.0], [0, 1], "real numbers"),
        ([0, 1], [0.5, 1.0], "real numbers"),
    ],
)
def test_pairs_that_the_world_does_not_have(states, actions, match: str) -> None:
    table = np.zeros((4, 3, 4))
    table[0, :, 1] = table[1, [0, 2], 2] = table[2, :, 3] = 1
    mdp = TabularMDP.from_dense(table, 0.9)
    with pytest.raises(InputError, match=match):
        planned_actions(
            Demonstrations.from_arrays(np.array(states), np.array(actions)), Candidates.from_states([2]), mdp
        )


def test_other_bad_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    mdp = corridor(4, 0.9)
    demos = walks(mdp, 0)
    with pytest.raises(InputError, match="places in space"):
        planned_actions(demos, Candidates(np.arange(3.0)), mdp)
    with pytest.raises(InputError, match="found TabularMDP, wanted Demonstrations, then the world"):
        planned_actions(mdp, Candidates.from_states([0]), demos)
    with pytest.raises(InputError, match="goal 1 at index 0: found 4"):
        planned_actions(demos, Candidates.from_states([0, 4]), mdp)
    monkeypatch.setattr("subgoal.likelihood.planned_actions.LARGEST_PLAN", 100)
    with pytest.raises(BudgetError, match="fewer candidates"):
        planned_actions(demos, every_state(mdp), mdp)


def test_the_compiled_loop_equals_its_python_form() -> None:
    generator = np.random.default_rng(0)
    values = generator.normal(size=(4, 3, 5))
    values[1, 2] = -np.inf
    rows, actions = np.array([0, 1, 3]), np.array([2, 0, 1])
    made = np.empty((2, 3, 5))
    softmax_tile(values, rows, actions, np.full(5, 3.0), made[0])
    softmax_tile.py_func(values, rows, actions, np.full(5, 3.0), made[1])
    np.testing.assert_allclose(made[0], made[1], rtol=1e-13)
    np.testing.assert_allclose(made[0], log_softmax(3.0 * values[rows], axis=1)[np.arange(3), actions], rtol=1e-12)


def test_candidate_states() -> None:
    mdp = corridor(10, 0.9)
    demos = Demonstrations.from_arrays(
        np.array([2, 3, 3, 7]), np.array([1, 2, 1, 0]), [0, 3, 4], final_states=np.array([4, 6])
    )
    names = [int(s[0]) for s in visited(demos).goal_sets]
    assert names == [2, 3, 4, 6, 7]
    np.testing.assert_allclose(np.exp(visited(demos).log_prior), 0.2)
    np.testing.assert_allclose(np.exp(visited(demos, by_visits=True).log_prior), np.array([1, 2, 1, 1, 1]) / 6)
    assert [int(s[0]) for s in visited_and_successors(demos, mdp).goal_sets] == [1, 2, 3, 4, 5, 6, 7, 8]
    still = Demonstrations.from_arrays(np.array([5]), np.array([0]))
    around = visited_and_successors(still, corridor(10, 0.9, stay=False))
    assert [int(s[0]) for s in around.goal_sets] == [4, 5, 6]
    assert every_state(mdp).n_candidates == 10
    np.testing.assert_array_equal(every_state(mdp).points.ravel(), np.arange(10))
    with pytest.raises(InputError, match="by_visits"):
        visited(Demonstrations.from_arrays(np.zeros((2, 2)), np.ones((2, 2))), by_visits=True)


@pytest.mark.parametrize(
    ("goals", "keywords", "match"),
    [
        ([[0, 1], [2]], {"coordinates": np.zeros((2, 2))}, "state 2"),
        ([[0], []], {}, "candidate 1"),
        ([[0], [-1]], {}, "candidate 1"),
        ([[0.5]], {}, "candidate 0"),
        ([], {}, "0 sets"),
        ([0, 1], {"points": [[1.0, 2.0]]}, "2 sets, wanted 1"),
    ],
)
def test_bad_sets_of_states(goals, keywords: dict, match: str) -> None:
    with pytest.raises(InputError, match=match):
        Candidates.from_states(goals, **keywords)


def test_sets_lie_at_the_mean_of_their_states_unless_told_otherwise() -> None:
    places = np.arange(8.0).reshape(4, 2)
    made = Candidates.from_states([[3, 1], 2], coordinates=places, names=["two", "one"])
    np.testing.assert_array_equal(made.points, [[4, 5], [4, 5]])
    assert [each.tolist() for each in made.goal_sets] == [[1, 3], [2]]
    np.testing.assert_array_equal(Candidates.from_states([[3, 1], 2]).points, [[1], [2]])
    np.testing.assert_array_equal(Candidates.from_states([3], points=[[9.0, 9.0]]).points, [[9, 9]])


def test_saving_keeps_goal_sets_and_coordinates(tmp_path) -> None:
    mdp = corridor(6, 0.9)
    demos = Demonstrations.from_arrays(
        np.array([0, 1, 5]), np.array([1, 1, 0]), [0, 3], coordinates=np.arange(12.0).reshape(6, 2)
    )
    candidates = Candidates.from_states([[2], [3, 4]], coordinates=demos.coordinates)
    with pytest.warns(UserWarning):
        posterior = subgoal.sample(planned_actions(demos, candidates, mdp), draws=5, warmup=2)
    again = subgoal.load(subgoal.save(posterior, tmp_path / "p.npz"))
    assert [each.tolist() for each in again.candidates.goal_sets] == [[2], [3, 4]]
    np.testing.assert_array_equal(again.demonstrations.coordinates, demos.coordinates)
    np.testing.assert_array_equal(again.demonstrations.places, demos.coordinates[[0, 1, 5]])
    assert again.likelihood is None
    with pytest.raises(StorageError, match="without its world"):
        subgoal.save(again, tmp_path / "q.npz")
    with_world = subgoal.load(tmp_path / "p.npz", mdp=mdp)
    np.testing.assert_array_equal(with_world.likelihood.dense, posterior.likelihood.dense)
    for other in ({"mdp": corridor(6, 0.8)}, {"mdp": mdp, "convention": "absorbing"}):
        with pytest.raises(StorageError, match="another world"):
            subgoal.load(tmp_path / "p.npz", **other)


def test_a_world_is_no_use_to_a_posterior_without_plans(tmp_path) -> None:
    with pytest.warns(UserWarning):
        posterior = subgoal.sample(subgoal.LogLikelihood.from_table(np.zeros((3, 2))), draws=5, warmup=0)
    subgoal.save(posterior, tmp_path / "p.npz")
    with pytest.raises(StorageError, match="planned actions"):
        subgoal.load(tmp_path / "p.npz", mdp=corridor(6, 0.8))
