"""Options of a continuous world, carried out."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal import options
from subgoal.options import execution
from subgoal.options.continuous import option
from subgoal.options.execution import execute
from subgoal.options.tabular import goal_option
from subgoal.runtime.errors import InputError
from tests.mdp.small_worlds import corridor
from tests.options.point import SPEED, STEP, glide, goals, learned, planned, point_world, shown

pytestmark = pytest.mark.filterwarnings("ignore")

STARTS = np.array([[0.2, 0.1], [2.9, 2.8], [1.5, -0.3]])


def near_the_demonstration():
    states = np.asarray(shown().states)
    return states + np.random.default_rng(1).uniform(-0.4, 0.4, states.shape)


@pytest.mark.parametrize("which", [0, 1])
def test_a_learned_option_drives_to_its_goal_from_everywhere_near_the_demonstration(which: int) -> None:
    made = option(learned(), goals()[which])
    start = near_the_demonstration()
    start = start[~made.over(start)]
    assert len(start) > 20
    done = execute(made, point_world(), start=start, duration=8)
    assert not done.truncated.any()
    assert made.over(done.final_states).all()
    assert not made.over(done.states).any()


def test_a_held_option_stays_at_its_goal() -> None:
    made = option(learned(), goals()[0])
    done = execute(made, point_world(), start=near_the_demonstration(), duration=8, hold=True)
    assert done.truncated.all()
    np.testing.assert_array_equal(np.diff(done.offset), 80)
    assert made.over(np.asarray(done.states).reshape(-1, 80, 2)[:, 50:].reshape(-1, 2)).all()
    assert made.over(done.final_states).all()


def test_until_it_ends_a_held_option_does_the_same() -> None:
    made = planned([1.0, 2.0])
    held, ended = (execute(made, point_world(), start=STARTS, duration=5, hold=hold) for hold in (True, False))
    for k in range(3):
        a, length = held.offset[k], np.diff(ended.offset)[k]
        own = slice(ended.offset[k], ended.offset[k + 1])
        np.testing.assert_allclose(held.states[a : a + length], ended.states[own], atol=1e-12)
        np.testing.assert_allclose(held.states[a + length], ended.final_states[k], atol=1e-12)
    assert len(set(np.diff(ended.offset))) > 1


def test_each_state_follows_from_the_one_before_by_the_policy_and_the_world() -> None:
    def drifting(states, actions, duration):
        return states + (actions - [-0.3, 0.0]) * duration

    made = planned([1.0, 2.0])
    done = execute(made, drifting, start=STARTS[:2], duration=0.7, hold=True, every=0.1)
    np.testing.assert_array_equal(done.offset, [0, 7, 14])
    np.testing.assert_allclose(done.times, np.tile(0.1 * np.arange(7), 2))
    np.testing.assert_array_equal(done.states[[0, 7]], STARTS[:2])
    np.testing.assert_allclose(done.actions, made.policy(done.states), atol=1e-9)
    after = drifting(np.asarray(done.states), np.asarray(done.actions), 0.1)
    np.testing.assert_allclose(done.states[1:7], after[:6])
    np.testing.assert_allclose(done.final_states, after[[6, 13]])


def test_decisions_are_half_a_step_apart_and_cover_the_duration() -> None:
    done = execute(planned([1.0, 2.0]), point_world(), start=STARTS[0], duration=0.45, hold=True)
    np.testing.assert_allclose(done.times, STEP / 2 * np.arange(5))
    assert execute(planned([1.0, 2.0]), glide, start=STARTS[0], duration=0.3, hold=True).n_observations == 3


def test_starts_are_worked_on_together_as_one_by_one() -> None:
    made = planned([1.0, 2.0])
    how = {"duration": 2.0, "disturbance": [0.2, 0.0], "hold": True}
    whole = execute(made, point_world(), start=STARTS, seed=5, **how)
    first = execute(made, point_world(), start=STARTS[:2], seed=5, **how)
    np.testing.assert_allclose(whole.states[: first.n_observations], first.states, atol=1e-9)
    other = execute(made, point_world(), start=STARTS, seed=6, **how)
    assert (np.abs(other.final_states[:, 0] - whole.final_states[:, 0]) > 1e-6).all()
    again = execute(made, point_world(), start=STARTS, seed=5, **how)
    np.testing.assert_array_equal(again.states, whole.states)


def test_pushes_grow_with_the_root_of_time() -> None:
    made = planned([1.0, 2.0])
    for every in (0.1, 0.02):
        pushes = execution._pushes([0.3, 0.0], (4, 2), 5000, 1) * np.sqrt(every)
        np.testing.assert_allclose(pushes.std(axis=(0, 1)), [0.3 * np.sqrt(every), 0], rtol=0.02)
        done = execute(made, glide, start=STARTS, duration=20 * every, hold=True, every=every, disturbance=[0.3, 0])
        expected = glide(np.asarray(done.states), np.asarray(done.actions), every)
        same = execution._pushes([0.3, 0.0], (3, 2), 20, 0) * np.sqrt(every)
        for k in range(3):
            rows = slice(20 * k, 20 * k + 19)
            np.testing.assert_allclose(done.states[1:][rows] - expected[rows], same[k, :19], atol=1e-12)
        assert np.abs(same[0, :, 0] - same[1, :, 0]).min() > 0


def test_an_option_holds_its_goal_against_pushes() -> None:
    made = planned([1.0, 2.0], radius=0.5)
    done = execute(made, glide, start=np.tile(STARTS, (5, 1)), duration=6, hold=True, disturbance=0.2)
    assert made.over(np.asarray(done.states).reshape(15, 60, 2)[:, 30:].reshape(-1, 2)).mean() > 0.99


def test_one_verb_runs_options_of_either_world() -> None:
    made = planned([1.0, 2.0])
    done = options.execute(made, point_world(), start=STARTS, duration=4.0)
    np.testing.assert_array_equal(done.states, execute(made, point_world(), start=STARTS, duration=4.0).states)
    walked = options.execute(goal_option(corridor(5, 0.9), 3), corridor(5, 0.9), start=1, steps=9)
    np.testing.assert_array_equal(walked.states, [1, 2])
    with pytest.raises(InputError, match="option: found str"):
        options.execute("go", corridor(5, 0.9), start=1, steps=9)


def test_mistakes_are_told() -> None:
    made = planned([1.0, 2.0], initiation=[[0.0, 0.0]], radius=0.3)
    with pytest.raises(InputError, match=r"start at row 1: found \(0, 0\.4\), wanted a state of the initiation set"):
        execute(made, glide, start=[[0.1, 0.0], [0.0, 0.4]], duration=1)
    with pytest.raises(InputError, match="not over, or hold=True"):
        execute(planned([1.0, 2.0]), glide, start=[1.0, 2.1], duration=1)
    assert execute(planned([1.0, 2.0]), glide, start=[1.0, 2.1], duration=1, hold=True).n_observations == 10
    free = planned([1.0, 2.0])
    for keywords, match in (
        ({"duration": 0}, "duration"), ({"every": np.nan}, "every"), ({"disturbance": -1}, "disturbance"),
        ({"disturbance": [1, 2, 3]}, "disturbance"), ({"start": [[np.nan, 0]]}, "start"), ({"start": [1.0]}, "states"),
        ({"seed": -1, "disturbance": 1}, "seed"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            execute(free, glide, **{"start": [0.0, 0.0], "duration": 1, **keywords})
    with pytest.raises(InputError, match="dynamics"):
        execute(free, lambda s, a, t: s * np.nan, start=[0.0, 0.0], duration=1)


def test_actions_stay_within_their_bounds() -> None:
    done = execute(planned([1.0, 2.0]), glide, start=STARTS, duration=2)
    assert np.abs(done.actions).max() == SPEED
