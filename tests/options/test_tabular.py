"""Options of a discrete world: they go to their goal, end there, and can hold it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.mdp.tabular import TabularMDP
from subgoal.options.tabular import Option, ended_at, execute, goal_option, option
from subgoal.runtime.errors import InputError
from tests.answers.test_predictions import there_and_back
from tests.mdp.small_worlds import corridor, world

pytestmark = pytest.mark.filterwarnings("ignore")


def test_an_option_walks_straight_to_its_goal_and_ends_there() -> None:
    mdp = corridor(10, 0.9)
    made = execute(goal_option(mdp, 7), mdp, start=[2, 9], trajectories=2, steps=50)
    np.testing.assert_array_equal(made.states, [2, 3, 4, 5, 6, 9, 8])
    np.testing.assert_array_equal(made.actions, [1, 1, 1, 1, 1, 0, 0])
    np.testing.assert_array_equal(made.final_states, [7, 7])
    assert not made.truncated.any()


def test_a_held_option_stays_at_its_goal() -> None:
    mdp = corridor(10, 0.9)
    made = execute(goal_option(mdp, 7), mdp, start=5, steps=6, hold=True)
    np.testing.assert_array_equal(made.states, [5, 6, 7, 7, 7, 7])
    assert made.truncated.all()
    held = execute(goal_option(mdp, [7, 8]), mdp, start=8, steps=9, hold=True)
    assert set(held.states) <= {7, 8}


def test_the_policy_is_uniform_over_ties_and_where_the_goal_is_out_of_reach() -> None:
    mdp, _ = world(1, 0.9, n_states=8, one_way=True)
    made = goal_option(mdp, 2)
    np.testing.assert_allclose(made.policy.sum(axis=1), 1)
    np.testing.assert_array_equal(made.termination, np.arange(8) == 2)
    assert not made.initiation[3:].any()
    np.testing.assert_allclose(made.policy[3:], 1 / 3)


@pytest.mark.parametrize(("length", "discount"), [(60, 0.5), (500, 0.95)])
def test_an_option_knows_the_way_far_from_its_goal(length: int, discount: float) -> None:
    """There the values of all actions are within the tolerance of a plan of each other."""
    mdp = corridor(length, discount)
    made = goal_option(mdp, 0)
    assert made.initiation.all()
    np.testing.assert_array_equal(made.policy[1:].argmax(axis=1), 0)
    np.testing.assert_array_equal(made.policy[1:].max(axis=1), 1)
    done = execute(made, mdp, start=length - 1, steps=length)
    assert not done.truncated[0]
    assert done.n_observations == length - 1


def test_where_the_discount_leaves_nothing_an_option_does_not_begin() -> None:
    made = goal_option(corridor(1_200, 0.5), 0)
    assert made.initiation[:1_000].all()
    assert not made.initiation[1_100:].any()


def test_a_learned_subgoal_becomes_an_option() -> None:
    mdp = corridor(12, 0.9)
    posterior = subgoal.bnirl(there_and_back(), mdp, confidence=10.0, draws=100, warmup=50)
    for goal in list(subgoal.subgoals(posterior))[:2]:
        place = int(posterior.candidates.goal_sets[goal.candidate][0])
        anywhere = option(posterior, goal.candidate)
        assert anywhere.initiation.all()
        done = execute(anywhere, mdp, start=5, steps=20)
        assert done.final_states[0] == place
        served = option(posterior, goal.candidate, begin="served").initiation
        mine = posterior.demonstrations.states[posterior.best_assignment == goal.candidate]
        np.testing.assert_array_equal(np.flatnonzero(served), np.unique(mine))


def test_executions_hang_on_seed_and_index() -> None:
    mdp, _ = world(5, 0.95, n_states=30)
    one = goal_option(mdp, 3)
    few = execute(one, mdp, start=[9, 8], trajectories=2, steps=30, seed=4)
    many = execute(one, mdp, start=[9, 8, 7, 6], trajectories=4, steps=30, seed=4)
    np.testing.assert_array_equal(few.states, many.states[: few.n_observations])


def test_ending_a_world_elsewhere_keeps_the_other_rows() -> None:
    mdp, (table, _, _) = world(0, 0.9, n_states=6)
    ends = np.array([False, True, False, False, True, False])
    cut = ended_at(mdp, ends)
    np.testing.assert_array_equal(cut.matrix.toarray().reshape(table.shape), table * ~ends[:, None, None])
    np.testing.assert_array_equal(cut.terminal, ends)


def test_bad_input() -> None:
    mdp = corridor(5, 0.9)
    made = goal_option(mdp, 4)
    for start, match in ((4, "not over"), (5, "found 5"), (-1, "found -1")):
        with pytest.raises(InputError, match=match):
            execute(made, mdp, start=start, steps=5)
    with pytest.raises(InputError, match="goal 0"):
        goal_option(mdp, 9)
    with pytest.raises(InputError, match="option: found 5 states, wanted 7"):
        execute(made, corridor(7, 0.9), start=0, steps=3)
    with pytest.raises(InputError, match=r"start: found shape \(2,\)"):
        execute(made, mdp, start=[0, 1], steps=3, trajectories=3)
    with pytest.raises(InputError, match="initiation"):
        Option("x", np.ones(3, bool), np.ones((4, 2)), np.ones(4, bool))
    posterior = subgoal.bnirl(there_and_back(), corridor(12, 0.9), draws=5, warmup=0)
    for keywords, match in (({"candidate": 99}, "candidate"), ({"candidate": 0, "begin": "here"}, "begin")):
        with pytest.raises(InputError, match=match):
            option(posterior, **keywords)
    other = subgoal.sample(subgoal.LogLikelihood.from_table(np.zeros((2, 2))), draws=5, warmup=0)
    with pytest.raises(InputError, match="planned_actions"):
        option(other, 0)
    assert repr(made) == "Option('goal': begins in 5 states, ends in 1 of 5)"
    table = np.zeros((3, 1, 3))
    table[0, 0, 1] = table[1, 0, 1] = table[2, 0, 0] = 1
    one_way = TabularMDP.from_dense(table, 0.9)
    with pytest.raises(InputError, match="initiation set"):
        execute(goal_option(one_way, 0), one_way, start=1, steps=3)


def test_the_report_of_a_discrete_world(tmp_path: Path) -> None:
    posterior = subgoal.bnirl(there_and_back(), corridor(12, 0.9), draws=20, warmup=10)
    page = subgoal.report(posterior, tmp_path / "report.html")
    assert page.stat().st_size > 1_000_000
