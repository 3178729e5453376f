"""Dynamics learned from recordings: exact where the law is affine, near elsewhere, and told how wrong they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import WhiteKernel

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics import ALL_DRIVE, Dynamics, GaussianDynamics, checked_dynamics, drive, learn_dynamics
from subgoal.dynamics.learned_pairs import transitions
from subgoal.runtime.errors import InputError
from tests.dynamics.recorded import STEP, A, B, C, affine, pendulum, pendulum_step

KINDS = pytest.mark.parametrize("kind", ["linear", "gp", "neighbours"])
CIRCLE = Metric.of(2, None, (2 * np.pi, np.inf))


def asked(count: int = 30, seed: int = 7) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(seed)
    return generator.normal(0, 1.5, size=(count, 2)), generator.normal(size=(count, 1))


def test_an_affine_law_is_found_exactly_in_spite_of_jumps_between_trajectories() -> None:
    states, actions = asked()
    learned = learn_dynamics(affine(), kind="linear")
    np.testing.assert_allclose(learned(states, actions, STEP), states @ A.T + actions @ B.T + C, atol=1e-6)
    np.testing.assert_allclose(learned.model.weights.T, np.hstack([A - np.eye(2), B]), atol=1e-6)
    assert learned.step == pytest.approx(STEP)
    assert isinstance(learned, Dynamics)


def test_several_steps_are_the_step_repeated_and_a_part_of_one_is_that_part_of_its_increment() -> None:
    states, actions = asked()
    learned = learn_dynamics(affine(), kind="linear")
    once = learned(states, actions, STEP)
    twice = learned(once, actions, STEP)
    np.testing.assert_array_equal(learned(states, actions, 0), states)
    np.testing.assert_array_equal(learned(states, actions, 2 * STEP * (1 + 1e-8)), twice)
    np.testing.assert_array_equal(learned(states, actions, 2 * STEP * (1 - 1e-8)), twice)
    np.testing.assert_allclose(learned(states, actions, 1.3 * STEP), once + 0.3 * (twice - once), atol=1e-12)


def test_a_longer_step_is_of_mean_actions() -> None:
    demos = affine((40,))
    moves = transitions(demos, 4 * STEP, Metric.euclidean(2))
    assert (moves.every, moves.step) == (4, pytest.approx(4 * STEP))
    np.testing.assert_array_equal(moves.increments, demos.states[4:] - demos.states[:-4])
    np.testing.assert_allclose(moves.actions, [demos.actions[i : i + 4].mean(axis=0) for i in range(36)], atol=1e-12)


def test_a_longer_step_of_held_actions_is_the_step_repeated() -> None:
    """Many trajectories of five pairs, each under one action: A⁴ s + (A³ + A² + A + I)(B a + c)."""
    states, actions = asked(60)
    at = [states]
    for _ in range(4):
        at.append(at[-1] @ A.T + actions @ B.T + C)
    ran, held = np.stack(at, axis=1).reshape(-1, 2), np.repeat(actions, 5, axis=0)
    demos = Demonstrations(ran, held, 5 * np.arange(61), times=np.tile(STEP * np.arange(5), 60))
    learned = learn_dynamics(demos, kind="linear", step=4 * STEP)
    np.testing.assert_allclose(learned(states, actions, 4 * STEP), at[-1], atol=1e-6)


def test_no_transition_crosses_from_one_trajectory_into_the_next() -> None:
    demos = affine((20, 30, 25))
    for every in (1, 3):
        moves = transitions(demos, every * STEP, Metric.euclidean(2))
        assert len(moves.row) == 75 - 3 * every
        assert (demos.trajectory[moves.row] == demos.trajectory[moves.row + every]).all()
        np.testing.assert_array_equal(moves.states, demos.states[moves.row])


def test_a_trajectory_that_is_shorter_than_a_step_has_no_transition() -> None:
    moves = transitions(affine((20, 2, 1, 25)), 3 * STEP, Metric.euclidean(2))
    assert set(moves.trajectory) == {0, 3}


def test_neighbours_are_the_mean_of_five_by_their_distance() -> None:
    demos = affine(noise=0.1)
    learned = learn_dynamics(demos, kind="neighbours")
    moves = transitions(demos, None, Metric.euclidean(2))
    seen = np.hstack([moves.states, moves.actions])
    for state, action in zip(*asked(10), strict=True):
        gaps = np.sqrt((((np.hstack([state, action]) - seen) / seen.std(axis=0)) ** 2).sum(axis=1))
        near = np.argsort(gaps)[:5]
        wanted = state + (moves.increments[near] / gaps[near, None]).sum(axis=0) / (1 / gaps[near]).sum()
        np.testing.assert_allclose(learned(state[None], action[None], STEP)[0], wanted, rtol=1e-9)


def test_where_something_was_seen_neighbours_say_it_again() -> None:
    demos = affine()
    learned = learn_dynamics(demos, kind="neighbours")
    np.testing.assert_allclose(learned(demos.states[3:9], demos.actions[3:9], STEP), demos.states[4:10], atol=1e-12)


def test_gaussian_processes_are_those_of_scikit_learn() -> None:
    """Mean and variance, noise included, of each dimension, at the hyper-parameters found."""
    demos = pendulum(200, noise=0.05)
    learned = learn_dynamics(demos, kind="gp")
    moves = transitions(demos, None, Metric.euclidean(2))
    seen = np.hstack([moves.states, moves.actions])
    states, actions = asked()
    at = np.hstack([states, actions])
    told = learned(states, actions, STEP) - states, learned.variance(states, actions, STEP)
    for k, process in enumerate(learned.model.processes):
        y = (moves.increments[:, k] - moves.increments[:, k].mean()) / moves.increments[:, k].std()
        theirs = GaussianProcessRegressor(process.covariance + WhiteKernel(process.noise), optimizer=None)
        theirs.fit((seen - seen.mean(axis=0)) / seen.std(axis=0), y)
        mean, deviation = theirs.predict((at - seen.mean(axis=0)) / seen.std(axis=0), return_std=True)
        scale = moves.increments[:, k].std()
        np.testing.assert_allclose(told[0][:, k], mean * scale + moves.increments[:, k].mean(), atol=1e-6 * scale)
        np.testing.assert_allclose(told[1][:, k], (deviation * scale) ** 2, rtol=1e-5)


def test_gaussian_processes_know_how_sure_they_are() -> None:
    """Of noisy transitions never seen, 95 % within two deviations (±4 %); far from what was seen, less sure."""
    learned = learn_dynamics(pendulum(400, noise=0.05), kind="gp", metric=CIRCLE)
    fresh = transitions(pendulum(600, noise=0.05, seed=9), None, CIRCLE)
    off = CIRCLE.difference(learned(fresh.states, fresh.actions, STEP), fresh.states + fresh.increments)
    spread = np.sqrt(learned.variance(fresh.states, fresh.actions, STEP))
    within = (abs(off) < 2 * spread).mean()
    assert 0.91 < within < 0.99
    assert (learned.variance([[0.0, 50.0]], [[0.0]], STEP) > 3 * np.mean(spread**2, axis=0)).all()


def test_variances_over_several_steps_are_carried_on_by_the_law() -> None:
    """An affine law with noise q: after three steps q (I + A Aᵀ + A² A²ᵀ); within 15 %."""
    learned = learn_dynamics(affine((300, 250), noise=0.1), kind="gp")
    wanted = 0.01 * sum(np.linalg.matrix_power(A, k) @ np.linalg.matrix_power(A, k).T for k in range(3)).diagonal()
    states, actions = asked(20)
    told = learned.variance(0.3 * states, 0.3 * actions, 3 * STEP)
    np.testing.assert_allclose(told, np.tile(wanted, (20, 1)), rtol=0.15)
    once, half = learned.variance(states, actions, STEP), learned.variance(states, actions, 0.5 * STEP)
    np.testing.assert_allclose(half, once / 2, rtol=1e-9)
    assert not learned.variance(states, actions, 0).any()


def test_variances_of_the_second_step_follow_the_slope_of_the_learned_mean() -> None:
    """Against 4,000 draws of the first step sent through the second, for a law that is not affine."""
    learned = learn_dynamics(pendulum(400, noise=0.02), kind="gp", metric=CIRCLE)
    state, action = np.array([[2.0, 1.0]]), np.array([[0.5]])
    generator = np.random.default_rng(3)
    drawn = learned(state, action, STEP) + generator.normal(size=(4000, 2)) * np.sqrt(
        learned.variance(state, action, STEP)
    )
    held = np.tile(action, (4000, 1))
    wanted = np.var(learned(drawn, held, STEP), axis=0) + learned.variance(drawn, held, STEP).mean(axis=0)
    np.testing.assert_allclose(learned.variance(state, action, 2 * STEP)[0], wanted, rtol=0.1)


@KINDS
def test_angles_wrap(kind: str) -> None:
    """Over the top there is no jump, and answers lie in the turn of the recording."""
    for lowest in (-np.pi, 0.0):
        demos = pendulum(lowest=lowest)
        learned = learn_dynamics(demos, kind=kind, metric=CIRCLE)
        top = lowest + 2 * np.pi
        states, actions = np.array([[top - 0.01, 2.0], [lowest + 0.01, -2.0]]), np.zeros((2, 1))
        told = learned(states, actions, STEP)
        assert ((told[:, 0] >= lowest) & (told[:, 0] < top)).all()
        wanted = pendulum_step(states, actions, STEP)
        assert abs(CIRCLE.difference(told, wanted)).max() < (0.3 if kind == "linear" else 0.15)
        turned = learned(states + np.array([2 * np.pi, 0]), actions, STEP)
        np.testing.assert_allclose(CIRCLE.difference(told, turned), 0, atol=1e-9)


def test_without_periods_the_jump_is_taken_for_a_motion() -> None:
    plain, wrapped = (learn_dynamics(pendulum(), kind="gp", metric=metric) for metric in (None, CIRCLE))
    assert wrapped.held_out.error[0] < 0.2 * plain.held_out.error[0]


def test_the_best_is_the_one_that_errs_least() -> None:
    for demos, kinds in ((affine(), {"linear"}), (pendulum(), {"gp"})):
        learned = learn_dynamics(demos, metric=None if kinds == {"linear"} else CIRCLE)
        assert list(learned.tried) == ["linear", "gp", "neighbours"]
        assert learned.kind in kinds
        assert learned.held_out.overall == min(each.overall for each in learned.tried.values())


def test_only_gaussian_processes_have_variances() -> None:
    assert isinstance(learn_dynamics(affine(), kind="gp"), GaussianDynamics)
    assert not hasattr(learn_dynamics(affine(), kind="linear"), "variance")


def test_errors_held_out_are_those_of_new_recordings() -> None:
    """With noise 0.1 the best there is has an error of 0.1; persistence errs by what changes."""
    demos = affine((400, 400), noise=0.1)
    told = learn_dynamics(demos, kind="linear").held_out
    np.testing.assert_allclose(told.error, 0.1, rtol=0.25)
    moves = transitions(demos, None, Metric.euclidean(2))
    np.testing.assert_allclose(told.persistence, np.sqrt(np.mean(moves.increments**2, axis=0)), rtol=0.3)
    np.testing.assert_allclose(told.share, told.error / moves.increments.std(axis=0), rtol=0.3)
    assert told.overall == pytest.approx(np.sqrt(np.mean(told.share**2)))
    assert (learn_dynamics(demos, kind="neighbours").held_out.error > 0.1).all()


@KINDS
def test_learning_is_reproducible(kind: str) -> None:
    states, actions = asked()
    demos = pendulum(700, noise=0.05)
    one, two = (learn_dynamics(demos, kind=kind, seed=4) for _ in range(2))
    np.testing.assert_array_equal(one(states, actions, STEP), two(states, actions, STEP))
    np.testing.assert_array_equal(one.held_out.error, two.held_out.error)
    assert not np.array_equal(one.held_out.error, learn_dynamics(demos, kind=kind, seed=5).held_out.error)


def test_the_model_of_a_car_that_drifts_is_learned_from_four_demonstrations() -> None:
    """0.2 s ahead: under 20 % of what changes is missed where held out, under 35 % of each dimension in a new drive."""
    learned = learn_dynamics(drive(ALL_DRIVE, trajectories=4).demonstrations, kind="gp", step=0.2)
    assert learned.held_out.overall < 0.2
    assert learned.names == ALL_DRIVE.names
    fresh = drive(ALL_DRIVE, seed=50).demonstrations
    states, actions = fresh.states[::20], fresh.actions[::20]
    true = ALL_DRIVE(states, actions, 0.2)
    told = checked_dynamics(learned, states, actions, 0.2)
    scale = np.sqrt(np.mean((true - states) ** 2, axis=0))
    assert (np.sqrt(np.mean((told - true) ** 2, axis=0)) < 0.35 * scale).all()


def test_a_learned_model_says_what_it_is() -> None:
    told = repr(learn_dynamics(affine(noise=0.1), kind="linear"))
    assert told.startswith("LearnedDynamics(linear, a step is 0.1 s, held-out error ")
    with pytest.raises(InputError, match=r"actions: found shape \(1, 2\), wanted \(B, 1\), as learned from"):
        learn_dynamics(affine(), kind="linear")([[0.0, 0.0]], [[0.0, 0.0]], STEP)
    with pytest.raises(InputError, match=r"states: found shape \(1, 3\)"):
        learn_dynamics(affine(), kind="linear")([[0.0, 0.0, 0.0]], [[0.0]], STEP)
    with pytest.raises(InputError, match=r"duration: found -0\.1"):
        learn_dynamics(affine(), kind="linear")([[0.0, 0.0]], [[0.0]], -0.1)


def still(demos: Demonstrations, what: str) -> Demonstrations:
    values = np.array(getattr(demos, what))
    values[:, -1] = 2.5
    return replace(demos, **{what: values})


def test_what_cannot_be_learned_from_is_refused() -> None:
    demos = affine()
    uneven = np.array(demos.times)
    uneven[5:60] += 0.07
    for wrong, fields, message in (
        (replace(demos, times=None), {}, "demonstrations: found no times.*dataclasses.replace"),
        (replace(demos, times=uneven), {}, "times: found steps from 0.1 to 0.17.*resample with rate="),
        (still(demos, "states"), {}, "demonstrations.states at dimension 1: found 2.5 throughout"),
        (still(demos, "actions"), {}, "demonstrations.actions at dimension 0: found 2.5 throughout"),
        (affine((5, 4)), {}, "demonstrations: found 7 transitions of 0.1, wanted at least 8"),
        (affine((1, 1)), {}, "found one pair in each trajectory"),
        (demos, {"step": 0.25}, "step: found 0.25, wanted a multiple of the time between two pairs, 0.1. Try: 0.2"),
        (demos, {"step": 0.03}, "step: found 0.03.*Try: 0.1"),
        (demos, {"step": np.nan}, "step: found nan"),
        (demos, {"step": 9.0}, "demonstrations: found 0 transitions of 9"),
        (demos, {"holdout": 0.0}, "holdout: found 0.0"),
        (demos, {"holdout": 0.6}, "holdout: found 0.6, wanted a number above 0, at most a half"),
        (affine((9,)), {"holdout": 0.5}, "holdout: found . transitions beside what is held out, wanted at least 5"),
        (demos, {"kind": "forest"}, "kind: found 'forest', wanted 'linear', 'gp', 'neighbours', 'best'"),
        (demos, {"metric": Metric.euclidean(3)}, "period: found 3 numbers, wanted 2"),
        (demos, {"seed": -1}, "seed: found -1"),
    ):
        with pytest.raises(InputError, match=message):
            learn_dynamics(wrong, **fields)
    discrete = Demonstrations(np.arange(30) % 5, np.arange(30) % 2, np.array([0, 30]), times=np.arange(30.0))
    with pytest.raises(InputError, match="found states of a discrete world"):
        learn_dynamics(discrete)
