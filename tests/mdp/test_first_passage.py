"""First-passage planning against policy iteration by dense linear solves, one goal at a time."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal._kernels import first_passage as loops
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.planners.first_passage import LANES, plan_subgoals
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError, PlanningError
from tests.mdp.small_worlds import corridor, world
from tests.oracles.subgoal_planning import subgoal_values

KINDS = [
    {},
    {"n_states": 1, "n_actions": 1},
    {"terminal": 2},
    {"illegal": True},
    {"one_way": True},
    {"n_states": 40, "n_actions": 5, "illegal": True, "terminal": 3},
]


def everything(n_states: int, seed: int) -> list[list[int]]:
    """Every single state, and a few sets."""
    generator = np.random.default_rng(seed)
    sets = [sorted({int(s) for s in generator.integers(n_states, size=3)}) for _ in range(3)]
    return [[s] for s in range(n_states)] + sets


@pytest.mark.parametrize("convention", ["continuing", "absorbing"])
@pytest.mark.parametrize("discount", [0.0, 0.5, 0.99])
@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_values_are_those_of_policy_iteration(kind: dict, discount: float, convention: str) -> None:
    for seed in range(4):
        mdp, dense = world(seed, discount, **kind)
        goals = everything(mdp.n_states, seed)
        plan = plan_subgoals(mdp, goals, states=np.arange(mdp.n_states), convention=convention)
        assert plan.status is PlanStatus.SOLVED
        assert plan.error_bound <= plan.tolerance
        for g, goal in enumerate(goals):
            value, q = subgoal_values(*dense, goal, discount, convention)
            # the oracle's own linear solve is exact to rounding times the condition 1/(1 - discount)
            slack = plan.error_bound + 1e-13 / (1 - discount) ** 2
            np.testing.assert_allclose(plan.value[:, g], value, rtol=0, atol=slack)
            np.testing.assert_array_equal(np.isfinite(plan.action_values[:, :, g]), np.isfinite(q))
            np.testing.assert_allclose(
                np.where(np.isfinite(q), plan.action_values[:, :, g], 0), np.where(np.isfinite(q), q, 0),
                rtol=0, atol=slack,
            )  # fmt: skip


def test_the_error_bound_is_kept_when_the_tolerance_is_loose() -> None:
    for seed in range(20):
        mdp, dense = world(seed, 0.95, n_states=30, n_actions=3)
        plan = plan_subgoals(mdp, np.arange(30), tolerance=0.05)
        exact = np.stack([subgoal_values(*dense, [g], 0.95, "continuing")[0] for g in range(30)], axis=1)
        assert np.abs(plan.value - exact).max() <= plan.error_bound <= 0.05


def test_the_error_bound_is_kept_where_values_settle_slowly() -> None:
    """Sets that cannot be held are paid again and again, and their values creep up to the end."""
    mdp = corridor(8, 0.95, stay=False)
    dense = mdp.matrix.toarray().reshape(8, 2, 8), mdp.available, mdp.terminal
    goals = [[0, 7], [2, 5], [1, 3]]
    for tolerance in (1.0, 0.1, 0.01):
        plan = plan_subgoals(mdp, goals, tolerance=tolerance)
        exact = np.stack([subgoal_values(*dense, goal, 0.95, "continuing")[0] for goal in goals], axis=1)
        assert tolerance / 1_000 < np.abs(plan.value - exact).max() <= plan.error_bound <= tolerance


def test_predecessors_are_the_states_that_lead_there() -> None:
    mdp, (table, _, _) = world(6, 0.9, n_states=15, illegal=True, terminal=2)
    rows = loops.compress_rows(mdp.offset, mdp.successor, mdp.probability, 3, 0.9, np.arange(mdp.n_states))
    edge, before = loops.find_predecessors(*rows[:3])
    leads = table.max(axis=1) > 0
    np.fill_diagonal(leads, False)
    for t in range(15):
        assert before[edge[t] : edge[t + 1]].tolist() == np.flatnonzero(leads[:, t]).tolist()


def test_a_corridor_by_hand() -> None:
    """d steps to a goal that can be held: γ^d/(1 − γ)."""
    plan = plan_subgoals(corridor(30, 0.9), [4])
    np.testing.assert_allclose(plan.value[:, 0], 0.9 ** abs(np.arange(30) - 4) / 0.1, rtol=1e-9)


def test_goal_conventions_differ_by_the_value_of_the_goal() -> None:
    mdp, _ = world(3, 0.9, n_states=12)
    goals = np.arange(12)
    held = plan_subgoals(mdp, goals).value
    once = plan_subgoals(mdp, goals, convention="absorbing").value
    np.testing.assert_allclose(held, once * held[goals, goals], atol=2e-8)
    mdp = corridor(12, 0.99)
    held = plan_subgoals(mdp, goals).value
    once = plan_subgoals(mdp, goals, convention="absorbing").value
    np.testing.assert_allclose(once, (1 - 0.99) * held, atol=1e-9)


def test_values_do_not_depend_on_workers_or_on_what_else_is_asked() -> None:
    mdp, _ = world(0, 0.95, n_states=120, n_actions=4)
    goals = np.arange(2 * LANES + 5)
    first = plan_subgoals(mdp, goals, workers=1)
    second = plan_subgoals(mdp, goals, workers=2)
    np.testing.assert_array_equal(first.value, second.value)
    rows = plan_subgoals(mdp, goals, states=[7, 3, 7])
    np.testing.assert_array_equal(rows.value, first.value[[7, 3, 7]])


def test_what_is_out_of_reach_is_said() -> None:
    mdp, (table, _, _) = world(1, 0.9, n_states=8, one_way=True)
    plan = plan_subgoals(mdp, np.arange(8))
    reach = np.linalg.matrix_power(np.eye(8) + table.max(axis=1), 8) > 0
    np.testing.assert_array_equal(plan.unreachable, ~reach)
    assert plan.unreachable.any()


def test_what_does_not_converge_raises_unless_told_otherwise() -> None:
    mdp = corridor(50, 0.9)
    with pytest.raises(PlanningError, match=r"NOT CONVERGED.*more sweeps"):
        plan_subgoals(mdp, [0], most_sweeps=1)
    plan = plan_subgoals(mdp, [0], most_sweeps=1, allow_unconverged=True)
    assert plan.status is PlanStatus.LIMIT
    assert not plan.error_bound <= plan.tolerance
    with pytest.raises(PlanningError, match=r"rounding.*larger tolerance"):
        plan_subgoals(corridor(50, 0.9999, stay=False), [0], tolerance=1e-14)


def test_the_default_tolerance_gives_way_to_rounding() -> None:
    """Near discount 1, where a goal cannot be held, no plan is as exact as the default asks; its bound says so."""
    mdp = corridor(20, 0.9999, stay=False)
    plan = plan_subgoals(mdp, np.arange(20))
    assert plan.status is PlanStatus.ROUNDING
    assert plan.tolerance < plan.error_bound < 0.1
    dense = (
        corridor(20, 0.9999, stay=False).matrix.toarray().reshape(20, 2, 20),
        np.ones((20, 2), bool),
        np.zeros(20, bool),
    )
    exact = np.stack([subgoal_values(*dense, [g], 0.9999, "continuing")[0] for g in range(20)], axis=1)
    assert np.abs(plan.value - exact).max() <= plan.error_bound


def test_rows_that_sum_to_a_little_more_than_one_are_in_the_error_bound() -> None:
    table = np.zeros((2, 1, 2))
    table[0, 0, 0] = 1 + 5e-9
    table[1, 0] = 0.5
    plan = plan_subgoals(TabularMDP.from_dense(table, 0.999), [0])
    assert abs(plan.value[0, 0] - 1 / (1 - 0.999 * (1 + 5e-9))) <= plan.error_bound


def test_small_values_are_exact_to_rounding_when_asked() -> None:
    mdp = corridor(300, 0.8)
    plan = plan_subgoals(mdp, [3, 250], states=np.arange(300), relative=True)
    for g, goal in enumerate((3, 250)):
        np.testing.assert_allclose(plan.value[:, g], 0.8 ** abs(np.arange(300) - goal) / 0.2, rtol=1e-11)
        assert (plan.optimal[:goal, :, g] == [False, True, False]).all()
    with pytest.raises(InputError, match="relative=True"):
        _ = plan_subgoals(mdp, [3], states=[0]).optimal


def test_small_values_satisfy_their_equation_in_a_noisy_maze() -> None:
    """Up and down between walls, with slip: far values are 1e-40 of near ones and settle in the same proportion."""
    free = np.ones((15, 15), bool)
    free[:-1, 1::4] = free[1:, 3::4] = False
    mdp = GridWorld(free, 0.5, slip=THESIS_SLIP).mdp
    everywhere = np.arange(mdp.n_states)
    for plan, exact in (
        (plan_subgoals(mdp, [0], states=everywhere, relative=True), True),
        (plan_subgoals(mdp, [0], states=everywhere), False),
    ):
        value = plan.value[1:, 0]
        off = np.abs(plan.action_values[1:, :, 0].max(axis=1) - value)
        assert value.min() < 1e-30
        assert (off <= 1e-9 * value).all() == exact


def test_a_discount_near_one_is_solved() -> None:
    plan = plan_subgoals(corridor(40, 0.9999), [0])
    np.testing.assert_allclose(plan.value[:, 0], 0.9999 ** np.arange(40) / 1e-4, rtol=1e-8)


def test_no_more_memory_than_is_said() -> None:
    """8·S·G for all values, and beside it nothing that grows with G."""
    import tracemalloc

    mdp = corridor(2_000, 0.9)
    used = {}
    for count in (100, 1_000):
        plan_subgoals(mdp, np.arange(count), workers=1)
        tracemalloc.start()
        plan = plan_subgoals(mdp, np.arange(count), workers=1)
        used[count] = tracemalloc.get_traced_memory()[1] - plan.value.nbytes
        tracemalloc.stop()
        assert plan.value.nbytes == 8 * 2_000 * count
    assert used[1_000] < used[100] + 300 * 900  # lists of goals and groups, some bytes each
    assert used[1_000] < 4 * 8 * 2_000 * LANES


@pytest.mark.parametrize(
    ("goals", "match"),
    [
        ([5], "goal 0.*found 5, wanted a state of 0 to 3"),
        ([-1], "found -1"),
        ([0.5], "wanted integers"),
        ([[0], []], "goal 1: found no state"),
        ([[0], np.empty(0, int)], "goal 1: found no state"),
        (9, "goal 0 at index 0: found 9"),
        ([], "none"),
        ([[0, 9]], "goal 0 at index 1: found 9"),
        (np.array([1, 7]), "goals at index 1: found 7"),
    ],
)
def test_goals_that_do_not_exist(goals, match: str) -> None:
    with pytest.raises(InputError, match=match):
        plan_subgoals(corridor(4, 0.9), goals)


def test_other_bad_arguments() -> None:
    mdp = corridor(4, 0.9)
    for keywords, match in (
        ({"states": [4]}, "states at index 0"),
        ({"convention": "episodic"}, "convention"),
        ({"tolerance": float("nan")}, "tolerance"),
        ({"most_sweeps": 0}, "most_sweeps"),
        ({"workers": 0}, "workers"),
        ({"states": [[1]]}, r"states: found shape \(1, 1\)"),
    ):
        with pytest.raises(InputError, match=match):
            plan_subgoals(mdp, [0], **keywords)
    ending = TabularMDP.from_dense(np.array([[[0.0, 1.0]], [[0.0, 0.0]]]), 1.0)
    with pytest.raises(InputError, match=r"discount.*below 1"):
        plan_subgoals(ending, [0])


def test_groups_hold_every_goal_once_and_near_ones_together() -> None:
    mdp = corridor(100, 0.9)
    rows = loops.compress_rows(mdp.offset, mdp.successor, mdp.probability, 3, 0.9, np.arange(mdp.n_states))
    edge, before = loops.find_predecessors(*rows[:3])
    places = np.random.default_rng(0).permutation(100)[:40]
    label = loops.near_groups(places, edge, before, 10, 1000)
    np.testing.assert_array_equal(np.bincount(label), [10, 10, 10, 10])
    first = places[label == 0]
    others = places[label > 0]
    assert np.abs(first - places[0]).max() <= np.abs(others - places[0]).min() + 1
    close = loops.near_groups(places, edge, before, 10, 7)
    assert close.min() == 0
    for k in range(close.max() + 1):
        assert np.ptp(places[close == k]) <= 6


def test_compiled_loops_equal_their_python_forms() -> None:
    mdp, _ = world(5, 0.9, n_states=25, n_actions=3, illegal=True, terminal=1)
    rows = (mdp.offset, mdp.successor, mdp.probability, 3, 0.9, np.arange(mdp.n_states))
    compressed = loops.compress_rows(*rows)
    for ours, theirs in zip(compressed, loops.compress_rows.py_func(*rows), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    before = loops.find_predecessors(*compressed[:3])
    for ours, theirs in zip(before, loops.find_predecessors.py_func(*compressed[:3]), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    goals = np.array([3, 17, 9])
    order = loops.distance_order(goals, *before)
    np.testing.assert_array_equal(order, loops.distance_order.py_func(goals, *before))
    np.testing.assert_array_equal(
        loops.near_groups(goals, *before, 2, 9), loops.near_groups.py_func(goals, *before, 2, 9)
    )
    mark, member = np.full(25, -1), np.eye(3, dtype=bool)
    mark[goals] = np.arange(3)
    values = []
    for settle in (loops.settle, loops.settle.py_func):
        value = np.zeros((25, 3))
        settle(order, 1e-10, False, 500, *compressed, *before, mark, member, False, value)
        values.append(value)
    np.testing.assert_allclose(values[0], values[1], rtol=1e-13)
    out = np.empty((2, 2, 3, 3))
    for made, action_rows in zip(out, (loops.action_rows, loops.action_rows.py_func), strict=True):
        action_rows(goals[:2], *rows[:5], values[0], made)
    np.testing.assert_allclose(out[0], out[1], rtol=1e-13)
