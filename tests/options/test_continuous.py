"""Options of a continuous world: where they begin, what they do, where they are over."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.world import action_grid
from subgoal.options import ContinuousOption, Option, continuous
from subgoal.options.continuous import option
from subgoal.runtime.errors import InputError
from tests.mdp.small_worlds import corridor
from tests.options.point import SPEED, STEP, goals, learned, planned, point_world, shown
from tests.options.test_tabular import there_and_back

pytestmark = pytest.mark.filterwarnings("ignore")


def swirl(states, actions, duration):
    """A point in a current: the best action is seldom at a corner of the bounds."""
    return states + (actions + np.stack([np.sin(states[:, 1]), np.cos(2 * states[:, 0])], axis=1)) * duration


def somewhere(count: int, seed: int = 0):
    return np.random.default_rng(seed).uniform(0, 3, (count, 2))


def plainly_valued(made: ContinuousOption, state, action) -> float:
    """Q, written out for one state and action."""
    x, goal, values, gamma = made.values.support, made.values.goals[0], made.values.values[:, 0], np.exp(-STEP)
    half = made.world.dynamics(state[None], action[None], STEP / 2)
    end = made.world.dynamics(state[None], action[None], STEP)[0]
    inner = np.exp(-((x[:, None] - x[None]) ** 2).sum(-1) / (2 * 1.5**2)) + 0.1 * np.eye(len(x))
    outer = np.exp(-((end - x) ** 2).sum(-1) / (2 * 1.5**2))
    reward = np.mean([np.exp(-((at - goal) ** 2).sum() / (2 * 0.7**2)) for at in (half[0], end)])
    after = outer @ np.linalg.inv(inner) @ values
    return (1 - gamma) * reward + gamma * min(max(after, 0), 1)


def test_action_values_look_one_step_ahead() -> None:
    made = planned([1.0, 2.0], swirl)
    states, actions = somewhere(3), np.random.default_rng(1).uniform(-SPEED, SPEED, (3, 4, 2))
    wanted = [[plainly_valued(made, s, a) for a in tried] for s, tried in zip(states, actions, strict=True)]
    np.testing.assert_allclose(made.action_values(states, actions), wanted, rtol=1e-9)


def test_the_policy_is_the_best_action_of_a_fine_grid() -> None:
    made = planned([1.0, 2.0], swirl)
    states = np.concatenate([somewhere(20), [1.0, 2.0] + 0.1 * somewhere(20)])
    grid = action_grid([-SPEED] * 2, [SPEED] * 2, 61)
    brute = made.action_values(states, np.broadcast_to(grid, (40, *grid.shape))).max(axis=1)
    found = made.action_values(states, made.policy(states)[:, None])[:, 0]
    assert (found >= brute - 1e-4).all()
    inside = (np.abs(made.policy(states)) < SPEED).all(axis=1)
    assert inside.sum() > 5


def test_refinement_never_lowers_the_value_and_stays_within_the_bounds() -> None:
    states = somewhere(50)
    before = np.full(50, -np.inf)
    for rounds in range(6):
        made = planned([1.0, 2.0], swirl, rounds=rounds)
        actions = made.policy(states)
        assert (np.abs(actions) <= SPEED).all()
        value = made.action_values(states, actions[:, None])[:, 0]
        assert (value >= before).all()
        before = value
    coarse = planned([1.0, 2.0], swirl, rounds=0)
    tests = coarse.world.test_actions
    worth = coarse.action_values(states, np.broadcast_to(tests, (50, *tests.shape)))
    np.testing.assert_array_equal(coarse.policy(states), tests[worth.argmax(axis=1)])


def test_more_starts_find_maxima_that_one_misses() -> None:
    """Two hills of value, of which the coarse test actions see the lower one first."""

    def folded(states, actions, duration):
        bump = np.exp(-(((actions - [0.9, 0.0]) / 0.35) ** 2).sum(axis=1))
        low = 0.6 * np.exp(-(((actions - [-1.0, 0.0]) / 0.6) ** 2).sum(axis=1))
        return states + np.stack([np.maximum(bump, low), 0 * bump], axis=1) * duration

    tests = [[-1, 0], [-2, 0], [-1, 1], [1.4, 0], [2, 0], [0, 2], [2, 2], [0, -2], [2, -2]]
    settings = {"low": [-SPEED] * 2, "high": [SPEED] * 2, "step": STEP, "test_actions": tests}
    at = np.array([[0.5, 1.0]])
    one, several = (planned([2.0, 1.0], folded, settings=settings, starts=s, rounds=6).policy(at)[0] for s in (1, 8))
    np.testing.assert_allclose(one, [-1, 0], atol=0.2)
    np.testing.assert_allclose(several, [0.9, 0], atol=0.1)


def test_many_states_are_worked_on_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    made, states = planned([1.0, 2.0], swirl), somewhere(11)
    whole = made.policy(states)
    monkeypatch.setattr(continuous, "ROWS", 3 * len(made.world.test_actions))
    np.testing.assert_allclose(made.policy(states), whole, atol=1e-9)
    assert made.policy(np.empty((0, 2))).shape == (0, 2)


def test_actions_of_many_dimensions_are_refined_along_each() -> None:
    def summed(states, actions, duration):
        return states + np.stack([actions[:, :2].sum(axis=1), actions[:, 2:].sum(axis=1)], axis=1) * duration

    settings = {"low": [-1.0] * 4, "high": [1.0] * 4, "step": STEP}
    made = planned([1.0, 2.0], summed, settings=settings)
    assert len(made.world.test_actions) == 81
    at = np.array([[0.9, 1.93]])
    coarse = planned([1.0, 2.0], summed, settings=settings, rounds=0)
    values = [each.action_values(at, each.policy(at)[:, None])[0, 0] for each in (coarse, made)]
    assert values[1] > values[0]
    np.testing.assert_allclose(at + STEP * made.policy(at).reshape(1, 2, 2).sum(axis=2), [[1, 2]], atol=0.06)


def test_it_may_begin_near_its_initiation_states_only() -> None:
    begin, states = somewhere(6, seed=3), somewhere(200, seed=4)
    made = planned([1.0, 2.0], initiation=begin, radius=0.4)
    wanted = [any(np.hypot(*(s - b)) < 0.4 for b in begin) for s in states]
    np.testing.assert_array_equal(made.may_begin(states), wanted)
    assert 0 < np.sum(wanted) < 200
    assert planned([1.0, 2.0]).may_begin(states).all()


def test_it_is_over_closer_than_its_radius_to_the_goal() -> None:
    made = planned([1.0, 2.0], radius=0.25, metric=Metric(np.array([1.0, 2.0]), np.full(2, np.inf)))
    np.testing.assert_array_equal(made.over([[1.2, 2], [1.25, 2], [1, 2.12], [1, 2.13], [1, 1.9]]), [1, 0, 1, 0, 1])


def test_angles_wrap() -> None:
    turned = Metric(np.ones(2), np.array([2 * np.pi, np.inf]))
    made = planned([3.1, 0.0], metric=turned, initiation=[[0.0, 3.0]])
    assert made.over([[-3.1, 0.0]])[0]
    assert made.may_begin([[2 * np.pi, 3.0]])[0]


def test_a_learned_subgoal_becomes_an_option() -> None:
    posterior, demos = learned(), shown()
    for g in goals():
        made = option(posterior, g, begin="served")
        served = np.asarray(demos.states)[posterior.best_assignment == g]
        np.testing.assert_array_equal(made.initiation, served)
        np.testing.assert_array_equal(made.goal, posterior.candidates.points[g])
        assert (made.candidate, made.name, made.names) == (g, f"candidate {g}", ("x", "y"))
        assert made.radius == posterior.candidates.radius
        at = somewhere(5)
        tried = np.broadcast_to(made.world.test_actions, (5, *made.world.test_actions.shape))
        ahead = made.world.ahead_of_tests(at, made.metric)
        known = posterior.likelihood.source.plan.action_values(ahead).reshape(5, len(made.world.test_actions), -1)
        np.testing.assert_allclose(made.action_values(at, tried), known[:, :, g], atol=1e-12)
        anywhere = option(posterior, g, radius=0.1)
        assert anywhere.initiation is None
        assert anywhere.radius == 0.1


def test_one_verb_makes_options_of_either_world() -> None:
    assert isinstance(subgoal.options.option(learned(), goals()[0]), ContinuousOption)
    discrete = subgoal.bnirl(there_and_back(), corridor(12, 0.9), draws=5, warmup=0)
    assert isinstance(subgoal.options.option(discrete, 0), Option)


def test_mistakes_are_told() -> None:
    posterior = learned()
    unused = next(g for g in range(posterior.candidates.n_candidates) if not (posterior.best_assignment == g).any())
    for keywords, match in (
        ({"candidate": 999}, "candidate: found 999"), ({"candidate": -1}, "candidate"),
        ({"candidate": goals()[0], "begin": "here"}, "begin"), ({"candidate": goals()[0], "radius": np.nan}, "radius"),
        ({"candidate": unused, "begin": "served"}, "serves nothing"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            option(posterior, **keywords)
    discrete = subgoal.bnirl(there_and_back(), corridor(12, 0.9), draws=5, warmup=0)
    with pytest.raises(InputError, match="gp_actions"):
        option(discrete, 0)
    made = planned([1.0, 2.0])
    for states in ([[1.0, 2.0, 3.0]], [1.0, 2.0], [[np.nan, 0.0]]):
        with pytest.raises(InputError, match="states"):
            made.policy(states)
    for fields in ({"starts": 0}, {"rounds": -1}, {"radius": 0}, {"initiation": [[1.0]]}):
        with pytest.raises(InputError, match=next(iter(fields))):
            planned([1.0, 2.0], **fields)
    with pytest.raises(InputError, match="values: found 2 goals"):
        plan = posterior.likelihood.source.plan.only([0, 1])
        ContinuousOption("two", np.zeros(2), plan, point_world(), Metric.euclidean(2), 0.3)
    told = repr(planned([1.0, 2.0], initiation=somewhere(3)))
    assert told == "ContinuousOption('a goal': begins near 3 states, ends within 0.3 of (1.00, 2.00))"
