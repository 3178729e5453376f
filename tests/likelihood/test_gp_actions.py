"""The density of continuous actions by Gaussian-process planning."""

from __future__ import annotations

import signal
from dataclasses import replace
from functools import partial

import array_api_strict
import numpy as np
import pytest

from subgoal.candidates import Candidates, epsilon_net
from subgoal.checks import check_likelihood
from subgoal.continuous import Averager, ContinuousWorld, GaussianSmoother, gp_actions
from subgoal.demonstrations import Demonstrations, Metric
from subgoal.likelihood import gp_values
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.mdp import PlanningWarning
from subgoal.runtime.errors import InputError, PlanningError, StoppedError
from subgoal.runtime.progress import Silent
from tests.likelihood.point_mass import HIGH, LOW, plane, push, there_and_back

DEMOS, legs, CORNERS = there_and_back()
NET = epsilon_net(DEMOS, 0.5)


@pytest.fixture(scope="module")
def table():
    return gp_actions(DEMOS, NET, plane(), hold=0.0)


def test_densities_sum_to_one_over_the_test_actions(table):
    source, world = table.source, table.source.world
    volume = np.prod(world.high - world.low)
    for i, g in ((0, 3), (20, 0), (50, 5)):
        state = np.repeat(DEMOS.states[i : i + 1], len(world.test_actions), axis=0)
        every = Demonstrations.from_arrays(state, world.test_actions)
        density = np.exp(same_likelihood(table, every).rows(0, len(state))[:, g])
        assert density.mean() * volume == pytest.approx(1.0, abs=1e-12)
    assert source.log_flat(0, 1)[0] == pytest.approx(-np.log(volume))


def test_it_is_the_formula_by_hand(table):
    source = table.source
    i, g, alpha = 11, 4, table.confidence
    q = source.tested(i, i + 1)[0, :, g]
    wanted = alpha * source.taken[i, g] - np.log(np.exp(alpha * q).mean()) - np.log(4.0)
    assert table.rows(i, i + 1)[0, g] == pytest.approx(wanted, abs=1e-12)


def test_values_come_from_the_model_and_the_reward(table):
    """One action by hand: the mean reward of the two moments of a step, and the value where it ends."""
    source, plan = table.source, table.source.plan
    i, g = 30, 2
    half = push(DEMOS.states[i], DEMOS.actions[i], 0.25)
    end = push(DEMOS.states[i], DEMOS.actions[i], 0.5)
    near = [np.exp(-((x - NET.points[g]) ** 2).sum() / (2 * 0.7**2)) for x in (half, end)]
    after = plan.values_at(end[None])[0, g]
    wanted = (1 - plan.discount) * np.mean(near) + plan.discount * after
    assert source.taken[i, g] == pytest.approx(wanted, abs=1e-12)
    assert plan.discount == pytest.approx(np.exp(-0.5 / 3.0))


def test_test_actions_are_valued_as_if_they_had_been_taken(table):
    source = table.source
    for u in (0, 17, 80):
        every = replace(DEMOS, actions=np.tile(source.world.test_actions[u], (DEMOS.n_observations, 1)))
        wanted = same_likelihood(table, every).source.taken
        np.testing.assert_allclose(source.tested(0, DEMOS.n_observations)[:, u], wanted, atol=1e-12)


def test_each_leg_speaks_for_its_corner(table):
    nearest = NET.metric.distance(CORNERS[:, None], NET.points[None]).argmin(axis=1)
    score = np.array([[table.dense[legs == k][:, g].sum() for g in nearest] for k in range(3)])
    assert (score.argmax(axis=1) == [0, 1, 2]).all()


def test_it_keeps_the_contract_of_a_likelihood(table):
    report = check_likelihood(table)
    assert "not run" not in repr([check.measured for check in report.checks])
    failed = [check for check in report.checks if check.passed is False]
    assert not failed, report


def test_what_is_not_held_in_memory_is_made_again_the_same(table, monkeypatch):
    monkeypatch.setattr(gp_values, "HELD", 0)
    again = gp_actions(DEMOS, NET, plane(), hold=0.0, dense_entries=0)
    assert again.dense is None
    np.testing.assert_allclose(again.rows(0, DEMOS.n_observations), table.dense, atol=1e-10)


def test_candidates_that_cannot_be_held_are_dropped_and_counted():
    """In a wind that is stronger than the engine, a place far upwind cannot be held."""
    far = Candidates(points=np.vstack([NET.points, [[40.0, 40.0]]]), radius=0.5)
    table = gp_actions(DEMOS, far, plane(), support=NET)
    assert [40.0, 40.0] not in table.candidates.points.tolist()
    dropped = far.n_candidates - table.n_candidates
    assert table.demonstrations.source.notes["candidates dropped that cannot be held"] == dropped >= 1
    assert table.candidates.log_prior == pytest.approx(-np.log(table.n_candidates))


def test_a_candidate_that_cannot_be_reached_is_flat_and_explains_nothing():
    """Errata E28: a flat Q is every action's best explanation in the printed form, and nobody's in the right one."""
    far = Candidates(points=np.vstack([NET.points, [[40.0, 40.0]]]), radius=0.5)
    table = gp_actions(DEMOS, far, plane(), support=NET, hold=0.0)
    printed = literal_maximum(table).dense
    n = DEMOS.n_observations
    assert (printed[:, -1] == printed.max(axis=1)).all()
    for k, g in enumerate(NET.metric.distance(CORNERS[:, None], NET.points[None]).argmin(axis=1)):
        assert table.dense[legs == k, g].sum() > table.dense[legs == k, -1].sum() + 3
    np.testing.assert_allclose(table.dense[:, -1], table.source.log_flat(0, n), atol=1e-6)


def test_planning_may_be_done_by_another_array_library(table):
    other = gp_actions(DEMOS, NET, plane(), hold=0.0, place=array_api_strict.asarray)
    assert isinstance(other.source.plan.values, np.ndarray)
    np.testing.assert_allclose(other.dense, table.dense, atol=1e-9)


def test_it_says_how_well_it_has_planned(table):
    told = table.planner
    assert "Gaussian-process dynamic programming" in told
    assert "Bellman residual" in told
    assert "not proved" in told
    assert "a contraction" in gp_actions(DEMOS, NET, plane(), smoother=Averager(), hold=0.0).planner
    apart = NET.metric.distance(DEMOS.states[:, None], NET.points[None]).min(axis=1)
    np.testing.assert_array_equal(table.source.held_out, apart > 1e-9)
    residual = table.source.bellman_residuals()
    assert residual.shape == (int(table.source.held_out.sum()), NET.n_candidates)
    assert residual.mean() < 0.05


def test_not_converging_raises_unless_asked_otherwise():
    wild = partial(gp_actions, DEMOS, NET, plane(horizon=20.0), smoother=GaussianSmoother(2.5, 1e-6), most_sweeps=3)
    with pytest.raises(PlanningError, match=r"NOT CONVERGED.*most_sweeps"):
        wild()
    with pytest.warns(PlanningWarning, match="NOT CONVERGED"):
        wild(hold=0.0, allow_unconverged=True)


def test_a_world_plans_with_whole_steps_of_its_model():
    """A model that was learned of whole steps is asked for whole steps: half a step twice would be another model."""
    asked = []

    def leap(states, actions, duration):
        asked.append(duration)
        return push(states, actions, duration)

    world = ContinuousWorld(leap, LOW, HIGH, step=0.5, points=4)
    world.ahead(DEMOS.states[:3], DEMOS.actions[:3], NET.metric)
    assert asked == [0.125, 0.25, 0.375, 0.5]


def test_every_state_may_be_a_support_state():
    table = gp_actions(DEMOS, NET, plane(), support=Candidates(points=DEMOS.states), hold=0.0)
    assert not table.source.held_out.any()
    assert "Bellman" not in table.planner


class Stopping(Silent):
    """As if Ctrl-C were pressed in the fifth sweep."""

    def update(self, done, total):
        if done == 5:
            signal.raise_signal(signal.SIGINT)


def test_planning_stops_after_the_sweep_in_hand():
    with pytest.raises(StoppedError, match="stopped after 5 sweeps"):
        gp_actions(DEMOS, NET, plane(), progress=Stopping())


def test_scores_have_mean_zero_under_the_model(table):
    """Over actions drawn from the density itself."""
    world, theta = table.source.world, np.full(DEMOS.n_observations, 3)
    told = table.source.assigned(theta)
    chance = np.exp(table.confidence * told.tested)
    chance /= chance.sum(axis=1, keepdims=True)
    total = np.zeros(2)
    for m, action in enumerate(world.test_actions):
        every = replace(DEMOS, actions=np.tile(action, (DEMOS.n_observations, 1)))
        total += chance[5, m] * same_likelihood(table, every).source.assigned(theta).score(15.0)[5]
    np.testing.assert_allclose(total, 0, atol=1e-10)


def test_observations_with_one_candidate_each_have_its_column(table):
    theta = np.arange(DEMOS.n_observations) % NET.n_candidates
    wanted = table.dense[np.arange(theta.size), theta]
    told = table.source.assigned(theta)
    np.testing.assert_allclose(told.log_density(table.confidence), wanted, atol=1e-12)
    rows = np.array([4, 9])
    each = np.full(2, table.confidence)
    np.testing.assert_allclose(told.some(rows).log_density(each), wanted[rows], atol=1e-12)


def broken(value):
    return lambda states, actions, duration: np.full_like(states, value)


@pytest.mark.parametrize(
    ("world", "said"),
    [
        (plane(), None),
        (ContinuousWorld(broken(np.nan), LOW, HIGH, step=0.5), "finite numbers"),
        (ContinuousWorld(lambda s, a, t: s[:, :1], LOW, HIGH, step=0.5), "shape"),
        (ContinuousWorld(lambda s, a, t: s.astype(int), LOW, HIGH, step=0.5), "floats"),
        (ContinuousWorld(lambda s, a, t: s * 0.9, LOW, HIGH, step=0.5), "whatever is done"),
        (ContinuousWorld(push, LOW / 2, HIGH / 2, step=0.5), "actions"),
        (ContinuousWorld(push, LOW[:1], HIGH[:1], step=0.5), "columns"),
        ("a world", "ContinuousWorld"),
    ],
)
def test_worlds_that_do_not_fit_are_refused(world, said):
    if said is None:
        assert gp_actions(DEMOS, NET, world, hold=0.0).n_candidates == NET.n_candidates
        return
    with pytest.raises(InputError, match=said):
        gp_actions(DEMOS, NET, world)


def test_other_input_that_does_not_fit_is_refused():
    few = Candidates(points=NET.points[:2])
    with pytest.raises(InputError, match="more states than dimensions"):
        gp_actions(DEMOS, few, plane())
    with pytest.raises(InputError, match="can be held"):
        gp_actions(DEMOS, NET, plane(), hold=1.0, width=0.2)
    for hold in (-0.1, 1.1, np.nan):
        with pytest.raises(InputError, match="share of the future"):
            gp_actions(DEMOS, NET, plane(), hold=hold)
    with pytest.raises(InputError, match="places in space"):
        gp_actions(DEMOS, Candidates.from_states([0, 1]), plane())
    with pytest.raises(InputError, match="discrete"):
        gp_actions(Demonstrations.from_arrays([0, 1], [0, 1]), NET, plane())
    with pytest.raises(InputError, match="wanted 3 columns"):
        gp_actions(DEMOS, Candidates(points=np.eye(3)), plane())


def test_equal_candidates_are_two_columns_alike():
    twice = Candidates(points=np.vstack([NET.points, NET.points[:1]]), metric=Metric.euclidean(2))
    table = gp_actions(DEMOS, twice, plane(), hold=0.0)
    np.testing.assert_allclose(table.dense[:, 0], table.dense[:, -1], atol=1e-9)
