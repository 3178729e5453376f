"""A continuous world as a Gymnasium environment."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from subgoal.dynamics import REAR_DRIVE, gym
from subgoal.dynamics.gym import continuous_env
from subgoal.dynamics.world import ContinuousWorld
from subgoal.runtime.errors import InputError, MissingExtraError

WORLD = ContinuousWorld(lambda s, a, t: s + a * t, [-1.0, -2.0], [1.0, 2.0], 0.5)
CAR = ContinuousWorld(REAR_DRIVE, *REAR_DRIVE.bounds, step=0.2)


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(
    "made",
    [
        lambda: continuous_env(CAR, np.zeros(4), low=[-5, -5, -20, -1], high=[5, 5, 20, 5]),
        lambda: continuous_env(CAR, np.eye(4), disturbance=0.1),
        lambda: continuous_env(WORLD, [0.0, 0.0], reward=lambda state, action: -float(action @ action)),
    ],
)
def test_gymnasiums_own_check_passes(made) -> None:
    check_env(made(), skip_render_check=True)


def test_a_step_holds_the_action_for_half_a_step_of_the_world() -> None:
    env = continuous_env(WORLD, [0.0, 1.0])
    np.testing.assert_array_equal(env.reset(seed=0)[0], [0, 1])
    state, paid, terminated, truncated, info = env.step(np.array([1.0, -2.0]))
    np.testing.assert_allclose(state, [0.25, 0.5])
    assert (paid, terminated, truncated, info) == (0.0, False, False, {})
    other = continuous_env(WORLD, [0.0, 1.0], every=0.1)
    other.reset()
    np.testing.assert_allclose(other.step(np.array([1.0, -2.0]))[0], [0.1, 0.8])


def test_what_was_seen_does_not_change_afterwards() -> None:
    env = continuous_env(WORLD, [0.0, 1.0])
    first, _ = env.reset()
    first[:] = 9
    np.testing.assert_allclose(env.step(np.zeros(2))[0], [0, 1])


def test_it_begins_in_one_of_the_starts_or_where_it_is_told() -> None:
    starts = np.arange(8.0).reshape(4, 2)
    env = continuous_env(WORLD, starts)
    seen = {tuple(env.reset(seed=k)[0]) for k in range(40)}
    assert seen == {tuple(row) for row in starts}
    np.testing.assert_array_equal(env.reset(options={"start": [7.0, 7.5]})[0], [7, 7.5])


def test_the_reward_is_of_the_state_in_which_one_acts() -> None:
    env = continuous_env(WORLD, [1.0, 2.0], reward=lambda state, action: state.sum() + action[0])
    env.reset()
    assert env.step(np.array([0.5, 1.0]))[1] == 3.5


def test_outside_its_limits_the_episode_is_over() -> None:
    env = continuous_env(WORLD, [0.0, 0.0], low=[-1, -0.4], high=[1, 0.4])
    env.reset()
    state, _, terminated, *_ = env.step(np.array([0.0, 2.0]))
    assert terminated
    np.testing.assert_allclose(state, [0, 0.4])
    env.reset()
    assert not env.step(np.array([0.0, 1.0]))[2]


def test_pushes_are_random_and_reproducible() -> None:
    env = continuous_env(WORLD, [0.0, 0.0], disturbance=[0.3, 0.0])

    def walk(seed: int):
        env.reset(seed=seed)
        return np.array([env.step(np.zeros(2))[0] for _ in range(2000)])

    walked = walk(1)
    np.testing.assert_array_equal(walked, walk(1))
    np.testing.assert_allclose(np.diff(walked[:, 0]).std(), 0.3 * np.sqrt(0.25), rtol=0.05)
    assert not walked[:, 1].any()


def test_mistakes_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    for arguments, keywords, match in (
        ((REAR_DRIVE, [0.0] * 4), {}, "world: found Car"), ((WORLD, [np.nan, 0.0]), {}, "start"),
        ((WORLD, [0.0, 0.0]), {"low": [1, 1]}, "start"), ((WORLD, [0.0, 0.0]), {"low": [1]}, "low and high"),
        ((WORLD, [0.0, 0.0]), {"low": [1, 1], "high": [0, 2]}, "low and high"),
        ((WORLD, [0.0, 0.0]), {"disturbance": -1}, "disturbance"), ((WORLD, [0.0, 0.0]), {"every": 0}, "every"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            continuous_env(*arguments, **keywords)
    env = continuous_env(WORLD, [0.0, 0.0], low=[-1, -1], high=[1, 1])
    with pytest.raises(InputError, match="start"):
        env.reset(options={"start": [3.0, 0.0]})
    env.reset()
    for action in ([5.0, 0.0], [np.nan, 0.0], [0.0]):
        with pytest.raises(InputError, match="action"):
            env.step(np.array(action))
    gym._env_class.cache_clear()
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(MissingExtraError, match="gym"):
        continuous_env(WORLD, [0.0, 0.0])
