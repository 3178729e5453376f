"""Options inside Gymnasium environments."""

from __future__ import annotations

import sys

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.wrappers import TimeLimit

from subgoal.dynamics.gym import continuous_env
from subgoal.options.execution import execute
from subgoal.options.gym import check_spaces, run_in_env
from subgoal.runtime.errors import InputError, MissingExtraError
from tests.options.point import SPEED, planned, point_world

pytestmark = pytest.mark.filterwarnings("ignore")


class Walled(gymnasium.Env):
    """The point in single precision, seen from elsewhere, which dies beyond y = 1."""

    def __init__(self, seen: int = 2, low: float = -SPEED, shape: int = 2, **box) -> None:
        self.observation_space = spaces.Box(-np.inf, np.inf, (seen,), np.float32)
        self.action_space = spaces.Box(low, SPEED, (shape,), np.float32)
        self.seen = seen

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = self.np_random.uniform(-0.2, 0.2, 2)
        return self.observation(), {}

    def step(self, action):
        assert self.action_space.contains(action)
        self.at = self.at + action * 0.1
        return self.observation(), 0.0, bool(self.at[1] > 1), False, {}

    def observation(self):
        return np.concatenate([self.at, np.zeros(self.seen - 2)]).astype(np.float32)


def test_in_an_environment_of_its_world_an_option_does_as_outside() -> None:
    made, start = planned([1.0, 2.0]), [0.2, 0.1]
    inside = run_in_env(made, continuous_env(point_world(), start), steps=40, hold=True, every=0.1)
    outside = execute(made, point_world(), start=start, duration=4.0, hold=True)
    np.testing.assert_allclose(inside.states, outside.states, atol=1e-9)
    np.testing.assert_allclose(inside.actions, outside.actions, atol=1e-9)
    np.testing.assert_allclose(inside.final_states, outside.final_states, atol=1e-9)
    np.testing.assert_allclose(inside.times, outside.times)
    assert inside.truncated.all()


def test_it_ends_at_its_goal_unless_it_is_held() -> None:
    made = planned([1.0, 0.0])
    ended = run_in_env(made, Walled(), steps=50, episodes=3)
    assert made.over(ended.final_states).all()
    assert not made.over(ended.states).any()
    assert not ended.truncated.any()
    assert ended.times is None
    assert ended.n_trajectories == 3
    held = run_in_env(made, Walled(), steps=50, hold=True)
    assert held.n_observations == 50
    assert held.truncated.all()


def test_an_episode_that_is_over_or_cut_off_ends_it() -> None:
    over = run_in_env(planned([0.0, 2.0]), Walled(), steps=50)
    assert 1 < over.final_states[0, 1] < 1.3
    assert not over.truncated.any()
    cut = run_in_env(planned([1.0, 0.0]), TimeLimit(Walled(), 3), steps=50)
    assert cut.n_observations == 3
    assert cut.truncated.all()


def test_episodes_hang_on_the_seed_and_their_number() -> None:
    made = planned([1.0, 0.0])
    one, two, other = (run_in_env(made, Walled(), steps=9, hold=True, episodes=n, seed=s)
                       for n, s in ((1, 4), (2, 4), (1, 5)))  # fmt: skip
    np.testing.assert_array_equal(two.states[:9], one.states)
    assert np.abs(two.states[9] - one.states[0]).max() > 1e-3
    assert np.abs(other.states[0] - one.states[0]).max() > 1e-3


def test_a_state_can_be_made_of_the_observation() -> None:
    made = planned([1.0, 0.0])
    done = run_in_env(made, Walled(seen=5), steps=50, state=lambda seen: seen[:2])
    assert made.over(done.final_states).all()
    with pytest.raises(InputError, match=r"observation space: found Box.*wanted a Box of shape \(2,\).*state="):
        run_in_env(made, Walled(seen=5), steps=50)
    with pytest.raises(InputError, match="states"):
        run_in_env(made, Walled(seen=5), steps=50, state=lambda seen: seen)


def test_spaces_that_do_not_fit_are_told() -> None:
    made = planned([1.0, 0.0])
    for env, match in (
        (Walled(shape=3), "action space: found Box.*shape"), (Walled(low=-1.0), r"action space: found \[-1"),
        (gymnasium.make("CartPole-v1"), "action space: found Discrete"), (None, "action space: found None"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=match):
            check_spaces(made, env)
    check_spaces(made, Walled(low=-3.0))
    with pytest.raises(InputError, match="initiation set"):
        run_in_env(planned([1.0, 0.0], initiation=[[3.0, 3.0]]), Walled(), steps=5)
    for keywords in ({"steps": 0}, {"episodes": 0}, {"every": 0.0}, {"seed": -1}):
        with pytest.raises(InputError, match=next(iter(keywords))):
            run_in_env(made, Walled(), **{"steps": 5, **keywords})


def test_without_gymnasium_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(MissingExtraError, match="gym"):
        run_in_env(planned([1.0, 0.0]), object(), steps=3)
