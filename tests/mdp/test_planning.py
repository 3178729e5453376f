"""Planners against each other, a dense oracle and exact fractions; their error bounds; properties."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal._kernels import backups as loops
from subgoal.mdp.planners.bellman import Bellman
from subgoal.mdp.planners.iteration import action_values, modified_policy_iteration, policy_iteration, value_iteration
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.policy import greedy_actions
from subgoal.mdp.tabular import TabularMDP
from tests.mdp.random_worlds import ITERATIVE, PLANNERS, World, optimum, random_world
from tests.oracles import exact_planning as oracle


@pytest.mark.parametrize("seed", range(30))
def test_the_oracle_is_the_best_of_all_policies(seed: int) -> None:
    world = random_world(seed, states=3)
    best = oracle.best_by_enumeration(world.table, world.gains, world.ending, world.discount)
    np.testing.assert_allclose(optimum(world), best, rtol=1e-10, atol=1e-12 * abs(best).max())


@pytest.mark.parametrize("block", range(10))
def test_all_planners_agree_on_200_random_worlds(block: int) -> None:
    """Within 1e-8 of the largest value there can be; each is asked for 1e-9, so that a sum of two is allowed for."""
    for seed in range(20 * block, 20 * block + 20):
        world = random_world(seed)
        most = abs(world.reward).max() / (1 - world.discount)
        wanted = optimum(world)
        for planner in PLANNERS:
            plan = planner(world.mdp, world.reward, tolerance=1e-9 * most)
            assert plan.status is PlanStatus.SOLVED, (seed, planner)
            assert abs(plan.value - wanted).max() <= 1e-8 * most, (seed, planner)
            check_greedy(world, plan, 1e-8 * most)


def check_greedy(world: World, plan, slack: float) -> None:
    """The policy takes available actions whose values are the largest."""
    terminal = world.mdp.terminal
    assert (plan.policy[terminal] == -1).all() and (plan.policy[~terminal] >= 0).all()
    np.testing.assert_array_equal(plan.value[terminal], world.ending[terminal])
    exact = optimum(world)
    own = oracle.evaluate(world.table, world.gains, world.ending, plan.policy, world.discount)
    assert (own >= exact - slack / (1 - world.discount)).all()


@pytest.mark.parametrize("planner", ITERATIVE)
def test_the_error_bound_holds_after_every_sweep(planner) -> None:
    """The exact values are known to 1e-13 of their size, which is added; bounds of the first sweeps are far above."""
    for seed in range(40):
        world = random_world(seed)
        exact = optimum(world)
        start = np.random.default_rng(seed).normal(size=exact.size) * abs(exact).max()
        for sweeps in range(1, 40, 3):
            plan = planner(world.mdp, world.reward, initial=start, most_sweeps=sweeps, allow_unconverged=True)
            assert abs(plan.value - exact).max() <= plan.error_bound + 1e-13 * abs(exact).max(), (seed, sweeps)
            assert plan.sweeps <= sweeps


def test_the_error_bound_of_value_iteration_is_attained() -> None:
    """With one state, d = ||V_{k+1} − V_k|| leaves the error γ d / (1 − γ) exactly: none smaller would hold."""
    mdp = TabularMDP.from_dense(np.ones((1, 1, 1)), 0.9)
    plan = value_iteration(mdp, [1.0], most_sweeps=5, allow_unconverged=True)
    assert plan.value[0] == pytest.approx((1 - 0.9**5) / 0.1, rel=1e-14)
    assert plan.error_bound == pytest.approx(10 - plan.value[0], rel=1e-12)
    assert plan.error_bound == pytest.approx(0.9 * 0.9**4 / 0.1, rel=1e-12)


def test_the_error_bound_knows_rows_that_sum_to_more_than_one() -> None:
    """As above with P = 1 + 9e-9, which makes the bound 9e-6 larger at γ = 0.999."""
    row = 1 + 9e-9
    mdp = TabularMDP.from_dense(np.full((1, 1, 1), row), 0.999)
    plan = value_iteration(mdp, [1.0], most_sweeps=5, allow_unconverged=True)
    assert plan.error_bound == pytest.approx(1 / (1 - 0.999 * row) - plan.value[0], rel=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_the_bounds_of_macqueen_know_rows_that_sum_to_one_only_nearly(sign: int) -> None:
    """Two states alone, whose sums differ by 1.8e-8, which makes their values differ by 0.018 at γ = 0.999."""
    rows = np.array([1 + 9e-9, 1 - 9e-9])
    mdp = TabularMDP.from_dense(np.diag(rows)[:, None], 0.999)
    plan = modified_policy_iteration(mdp, [sign, sign], most_sweeps=1, allow_unconverged=True)
    assert plan.error_bound == pytest.approx(0.009, rel=1e-2)
    assert (abs(plan.value - sign / (1 - 0.999 * rows)) <= plan.error_bound * (1 + 1e-6)).all()


def test_the_error_bound_at_discount_one_holds_where_it_is_tight() -> None:
    """Every step costs 1 and ends with chance 0.1: V_k = −10 (1 − 0.9^k)."""
    table = np.zeros((2, 1, 2))
    table[0, 0] = 0.9, 0.1
    mdp = TabularMDP.from_dense(table, 1.0)
    for sweeps in range(2, 100):
        plan = value_iteration(mdp, [-1.0, 0.0], most_sweeps=sweeps, allow_unconverged=True)
        assert plan.value[0] == pytest.approx(-10 * (1 - 0.9**sweeps))
        assert 10 + plan.value[0] <= plan.error_bound <= 2.2 * (10 + plan.value[0])


def test_modified_policy_iteration_stops_when_all_values_grow_alike() -> None:
    """A world of one reward everywhere is solved after the first backup: lowest and highest change are the same."""
    table = np.random.default_rng(0).dirichlet(np.ones(6), (6, 2))
    plan = modified_policy_iteration(TabularMDP.from_dense(table, 0.999), np.ones(6))
    assert plan.sweeps == 1
    np.testing.assert_allclose(plan.value, 1000, rtol=1e-12)


@pytest.mark.parametrize("planner", [*ITERATIVE, policy_iteration])
@pytest.mark.parametrize("excess", [0.0, 4e-9, -4e-9])
def test_the_error_bound_includes_rounding(planner, excess: float) -> None:
    """Exact fractions, on the floats as they are: also where rows sum to one only nearly."""
    for seed in range(12):
        world = random_world(seed, states=4)
        world = world._replace(table=world.table * (1 + excess))
        plan = planner(world.mdp, world.reward, tolerance=0, allow_unconverged=True)
        policy = policy_iteration(world.mdp, world.reward, tolerance=0, allow_unconverged=True).policy
        exact, optimal = oracle.exact_values(world.table, world.gains, world.ending, world.discount, policy)
        assert optimal
        assert max(abs(float(v) - x) for v, x in zip(exact, plan.value, strict=True)) <= plan.error_bound
        size = abs(plan.value).max() + abs(world.reward).max()
        assert plan.error_bound <= 100 * 2**-53 * size / (1 - world.discount)


def shortest_path(seed: int, top: float) -> World:
    """Every action costs something and may end in one of two endings, of which one is worth ``top``."""
    generator = np.random.default_rng(seed)
    table = generator.dirichlet(np.full(6, 0.4), (6, 3))
    table[:4, 0] = 0.8 * table[:4, 0] + 0.2 * np.eye(6)[5]
    table[:4, 1] = np.eye(6)[:4]
    table[4:] = 0
    reward = -generator.uniform(0.1, 1, 6)
    reward[4:] = top - generator.uniform(0, 3), top
    return World(table / np.maximum(table.sum(axis=2, keepdims=True), 1e-300), reward, 1.0)


@pytest.mark.parametrize("top", [0.0, 7.5, -3.0])
def test_shortest_paths_at_discount_one(top: float) -> None:
    """Among the actions is one that stays for ever at a cost; bounds are checked by exact fractions."""
    for seed in range(8):
        world = shortest_path(seed, top)
        plans = [planner(world.mdp, world.reward) for planner in PLANNERS]
        exact, optimal = oracle.exact_values(world.table, world.gains, world.ending, 1.0, plans[3].policy)
        assert optimal
        for plan in plans:
            assert plan.status is PlanStatus.SOLVED
            gap = max(abs(float(v) - x) for v, x in zip(exact, plan.value, strict=True))
            assert gap <= plan.error_bound <= 1e-6 * abs(world.reward).max()
        for planner in ITERATIVE:
            for sweeps in range(1, 60, 4):
                plan = planner(world.mdp, world.reward, most_sweeps=sweeps, allow_unconverged=True)
                gap = max(abs(float(v) - x) for v, x in zip(exact, plan.value, strict=True))
                assert gap <= plan.error_bound


seeds = st.integers(0, 10_000)


@settings(max_examples=40, deadline=None)
@given(seeds, st.floats(0, 10))
def test_higher_rewards_never_lower_values(seed: int, more: float) -> None:
    world = random_world(seed)
    extra = more * np.random.default_rng(seed).random(world.reward.shape)
    lower = policy_iteration(world.mdp, world.reward)
    upper = policy_iteration(world.mdp, world.reward + extra)
    assert (upper.value - lower.value >= -(lower.error_bound + upper.error_bound)).all()


@settings(max_examples=40, deadline=None)
@given(seeds, st.floats(1e-3, 1e3), st.floats(-10, 10))
def test_scaling_and_shifting_rewards(seed: int, scale: float, shift: float) -> None:
    """k R + c has the values k V + c / (1 − γ) where nothing ends; where something ends, scaling holds alone."""
    world = random_world(seed, per_action=False)
    shift = 0.0 if world.mdp.terminal.any() else shift
    plain = policy_iteration(world.mdp, world.reward)
    moved = policy_iteration(world.mdp, scale * world.reward + shift)
    wanted = scale * plain.value + shift / (1 - world.discount)
    slack = scale * plain.error_bound + moved.error_bound + 1e-14 * abs(wanted).max()
    assert abs(moved.value - wanted).max() <= slack


@settings(max_examples=40, deadline=None)
@given(seeds, st.integers(0, 1000))
def test_relabelling_states_and_actions_relabels_the_plan(seed: int, shuffle: int) -> None:
    world = random_world(seed)
    generator = np.random.default_rng(shuffle)
    states, actions = generator.permutation(len(world.table)), generator.permutation(world.table.shape[1])
    table = world.table[states][:, actions][:, :, states]
    reward = world.reward[states] if world.reward.ndim == 1 else world.reward[states][:, actions]
    plain = policy_iteration(world.mdp, world.reward)
    moved = policy_iteration(World(table, reward, world.discount).mdp, reward)
    assert abs(moved.value - plain.value[states]).max() <= plain.error_bound + moved.error_bound
    sure = greedy_actions(action_values(world.mdp, plain.value, world.reward), 1e-6 * abs(world.reward).max())
    unique = (sure.sum(axis=1) == 1)[states]
    named = np.append(np.argsort(actions), -1)[plain.policy[states]]
    np.testing.assert_array_equal(moved.policy[unique], named[unique])


@pytest.mark.parametrize("seed", range(8))
def test_sweeps_are_repeated_backups(seed: int) -> None:
    """After n sweeps: n times the maximum of dense products, in the states that do not end."""
    world = random_world(seed, discount=0.9)
    legal = world.table.any(axis=2)
    start = np.where(legal.any(axis=1), np.random.default_rng(seed).normal(size=len(legal)), world.ending)
    table = Bellman.of(world.mdp, world.reward).table
    policy = np.where(legal.any(axis=1), legal.argmax(axis=1), -1)
    for sweeps in (1, 2, 5):
        best, fixed = start, start
        for _ in range(sweeps):
            before = best, fixed
            best = np.where(legal, world.gains + 0.9 * world.table @ best, -np.inf).max(axis=1)
            best = np.where(legal.any(axis=1), best, world.ending)
            own = (world.gains + 0.9 * world.table @ fixed)[np.arange(len(legal)), policy]
            fixed = np.where(legal.any(axis=1), own, world.ending)
        out, spare = np.empty_like(start), np.empty_like(start)
        size = 1e-13 * (1 + abs(world.reward).max())
        made = loops.sweep_jacobi(sweeps, -1.0, *table, start, out, spare)
        np.testing.assert_allclose(out, best, atol=size)
        assert made == (sweeps, pytest.approx(abs(best - before[0]).max(), abs=10 * size))
        made = loops.sweep_policy(sweeps, -1.0, *loops.policy_rows(policy, *table), start, out, spare)
        np.testing.assert_allclose(out, fixed, atol=size)
        assert made == (sweeps, pytest.approx(abs(fixed - before[1]).max(), abs=10 * size))


def python_form(loop):
    """The loop itself where compilation is off."""
    return getattr(loop, "py_func", loop)


@pytest.mark.parametrize("seed", range(8))
def test_compiled_loops_are_their_python_forms(seed: int) -> None:
    world = random_world(seed)
    bellman = Bellman.of(world.mdp, world.reward)
    table, value = bellman.table, np.random.default_rng(seed).normal(size=len(world.table))
    policy = bellman.backup(value).policy

    def told(loop, *arguments, results: int, types=(float, float)):
        out = [np.full(value.size, -7, dtype) for dtype in types[:results]]
        return [*np.atleast_1d(loop(*arguments, *out)), *out[: 1 if types[-1] is float else 2]]

    for sweeps, stop in [(0, 0.0), (1, 0.0), (5, 0.0), (50, 0.1)]:
        for loop, rows, results in [
            (loops.sweep_jacobi, table, 2),
            (loops.sweep_in_place, table, 1),
            (loops.sweep_policy, loops.policy_rows(policy, *table), 2),
        ]:
            arguments = (sweeps, stop, *rows, value)
            compiled, plain = (told(f, *arguments, results=results) for f in (loop, python_form(loop)))
            for one, other in zip(compiled, plain, strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13 * abs(world.reward).max())
    ours, theirs = (f(policy, *table) for f in (loops.policy_rows, python_form(loops.policy_rows)))
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_array_equal(one, other)
    for kept in (policy, np.full(value.size, -1)):
        arguments = (1e-9, *table, value, kept)
        loop = loops.greedy_backup
        compiled, plain = (told(f, *arguments, results=2, types=(float, np.int64)) for f in (loop, python_form(loop)))
        for one, other in zip(compiled, plain, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13 * abs(world.reward).max())


def test_an_action_that_is_kept_stays_among_equals_only() -> None:
    mdp = TabularMDP.from_dense(np.full((1, 3, 1), 1.0), 0.5)
    bellman = Bellman.of(mdp, [[1.0, 1.0, 0.5]])
    assert [bellman.backup(np.zeros(1), np.array([kept])).policy[0] for kept in (-1, 0, 1, 2)] == [0, 0, 1, 0]
