"""Episodes recorded in Gymnasium and read from Minari: pairs, ends, what is cut off, what is refused."""

from __future__ import annotations

import builtins
from importlib import import_module

import numpy as np
import pytest

from subgoal.demonstrations import episodes
from subgoal.demonstrations.episodes import read_minari, record_episodes
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError

gymnasium = pytest.importorskip("gymnasium")
spaces = gymnasium.spaces


class Corridor(gymnasium.Env):
    """Cells 5 to 9, as its space counts; action 3 goes on, 2 stays; cell 9 ends it, or the clock after 4 steps."""

    observation_space = spaces.Discrete(5, start=5)
    action_space = spaces.Discrete(2, start=2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell, self.clock = (options or {}).get("cell", 5), 0
        return self.cell, {}

    def step(self, action):
        self.cell, self.clock = self.cell + action - 2, self.clock + 1
        return self.cell, 0.0, self.cell == 9, self.clock == 4, {}


class Point(gymnasium.Env):
    """A place in the plane that moves by its action; the same buffer is given out every time."""

    observation_space = spaces.Box(-9, 9, (2,))
    action_space = spaces.Box(-1, 1, (2,))

    def reset(self, *, seed=None, options=None):
        self.place = np.zeros(2, np.float32)
        return self.place, {}

    def step(self, action):
        self.place += action
        return self.place, 0.0, False, False, {}


def play(env, actions, **reset):
    env.reset(**reset)
    for action in actions:
        env.step(action)


def test_pairs_ends_and_cuts() -> None:
    env = record_episodes(Corridor())
    play(env, [3, 3], options={"cell": 7})  # arrives
    play(env, [2, 3, 2, 3])  # out of time
    play(env, [3, 3, 3, 3])  # arrives when time is out
    play(env, [2])  # reset
    play(env, [3, 2])  # still running
    demos = env.demonstrations()
    np.testing.assert_array_equal(demos.states, [2, 3, 0, 0, 1, 1, 0, 1, 2, 3, 0, 0, 1])
    np.testing.assert_array_equal(demos.actions, [1, 1, 0, 1, 0, 1, 1, 1, 1, 1, 0, 1, 0])
    np.testing.assert_array_equal(demos.offset, [0, 2, 6, 10, 11, 13])
    np.testing.assert_array_equal(demos.final_states, [4, 2, 4, 0, 1])
    np.testing.assert_array_equal(demos.truncated, [False, True, False, True, True])
    assert demos.trajectory_names == tuple(f"episode {k}" for k in range(5))
    assert demos.time_unit == "step" and demos.source.name == "episodes" and not demos.source.notes


def test_recording_goes_on_after_it_was_asked() -> None:
    env = record_episodes(Corridor())
    play(env, [3])
    assert env.demonstrations().truncated.tolist() == [True]
    for action in (3, 3, 3):
        env.step(action)
    demos = env.demonstrations()
    assert demos.n_observations == 4 and demos.truncated.tolist() == [False] and demos.final_states.tolist() == [4]


def test_places_are_copied_out_of_the_buffer() -> None:
    env = record_episodes(Point())
    play(env, [np.array([0.5, 0], np.float32), np.array([0, 0.25], np.float32)])
    demos = env.demonstrations()
    np.testing.assert_array_equal(demos.states, [[0, 0], [0.5, 0]])
    np.testing.assert_array_equal(demos.actions, [[0.5, 0], [0, 0.25]])
    np.testing.assert_array_equal(demos.final_states, [[0.5, 0.25]])


def test_episodes_without_a_step_are_counted() -> None:
    env = record_episodes(Corridor())
    env.reset()
    env.reset()
    with pytest.raises(InputError, match="episodes: found no steps"):
        env.demonstrations()
    play(env, [3])
    assert env.demonstrations().source.notes == {"episodes without a step": 2}
    assert env.demonstrations().trajectory_names == ("episode 2",)


def test_a_step_outside_an_episode_is_refused() -> None:
    env = record_episodes(Corridor())
    with pytest.raises(InputError, match="step: found no episode under way"):
        env.step(3)
    play(env, [3, 3], options={"cell": 7})
    with pytest.raises(InputError, match="step: found no episode under way"):
        env.step(3)
    play(env, [2] * 4)
    with pytest.raises(InputError, match="step: found no episode under way"):
        env.step(3)


def test_values_outside_their_space_are_refused() -> None:
    env = record_episodes(Corridor())
    env.reset()
    with pytest.raises(InputError, match="action: found number 2 of its space, wanted 0 to 1"):
        env.step(4)
    with pytest.raises(InputError, match="observation: found number -1 of its space, wanted 0 to 4"):
        env.reset(options={"cell": 4})


@pytest.mark.parametrize(
    "space",
    [spaces.Box(0, 1, (2, 2)), spaces.Box(0, 1, ()), spaces.MultiDiscrete([2, 2]), spaces.Dict(x=spaces.Discrete(2))],
)
@pytest.mark.parametrize("what", ["observation", "action"])
def test_other_spaces_are_refused(space, what: str) -> None:
    env = Corridor()
    setattr(env, f"{what}_space", space)
    with pytest.raises(InputError, match=f"{what} space: found .*, wanted Discrete, or Box of one dimension"):
        record_episodes(env)


@pytest.mark.parametrize(("name", "kinds"), [("FrozenLake-v1", "ii"), ("CartPole-v1", "fi"), ("Pendulum-v1", "ff")])
def test_what_is_recorded_is_what_was_seen(name: str, kinds: str) -> None:
    env = record_episodes(gymnasium.make(name, max_episode_steps=12))
    env.action_space.seed(0)
    states, actions, cut = [], [], []
    for k in range(6):
        seen, _ = env.reset(seed=k)
        terminated = truncated = False
        while not (terminated or truncated):
            states.append(seen)
            actions.append(env.action_space.sample())
            seen, _, terminated, truncated, _ = env.step(actions[-1])
        cut.append(not terminated)
    demos = env.demonstrations()
    np.testing.assert_array_equal(demos.states, np.array(states, demos.states.dtype))
    np.testing.assert_array_equal(demos.actions, np.array(actions, demos.actions.dtype))
    assert demos.truncated.tolist() == cut and demos.source.name == name
    assert demos.states.dtype.kind + demos.actions.dtype.kind == kinds
    np.testing.assert_array_equal(demos.final_states[-1], np.array(seen, demos.states.dtype))


@pytest.fixture
def minari(tmp_path, monkeypatch: pytest.MonkeyPatch):
    """Minari with an empty store of its own."""
    package = pytest.importorskip("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return package


def write(minari, name: str, observation_space, action_space, told):
    """A data set of episodes (observations, actions, terminated)."""
    buffers = [
        import_module("minari.data_collector").EpisodeBuffer(
            id=k, observations=list(seen), actions=list(done), rewards=[0.0] * len(done),
            terminations=[False] * (len(done) - 1) + [over], truncations=[False] * (len(done) - 1) + [not over],
        )
        for k, (seen, done, over) in enumerate(told)
    ]  # fmt: skip
    return minari.create_dataset_from_buffers(
        name, buffers, observation_space=observation_space, action_space=action_space
    )


@pytest.mark.filterwarnings("ignore")
def test_minari_with_numbered_states(minari) -> None:
    told = [([5, 6, 9], [3, 3], True), ([7, 7], [2], False)]
    made = write(minari, "corridor/test-v0", spaces.Discrete(5, start=5), spaces.Discrete(2, start=2), told)
    for demos in (read_minari("corridor/test-v0"), read_minari(made)):
        np.testing.assert_array_equal(demos.states, [0, 1, 2])
        np.testing.assert_array_equal(demos.actions, [1, 1, 0])
        np.testing.assert_array_equal(demos.offset, [0, 2, 3])
        np.testing.assert_array_equal(demos.final_states, [4, 2])
        np.testing.assert_array_equal(demos.truncated, [False, True])
        assert demos.trajectory_names == ("0", "1") and demos.source.name == "corridor/test-v0"


@pytest.mark.filterwarnings("ignore")
def test_minari_with_positions(minari) -> None:
    generator = np.random.default_rng(0)
    told = [
        (generator.normal(size=(n + 1, 3)).astype(np.float32), generator.normal(size=(n, 2)).astype(np.float32), n == 4)
        for n in (2, 4)
    ]
    write(minari, "reach-v0", spaces.Box(-9, 9, (3,)), spaces.Box(-9, 9, (2,)), told)
    demos = read_minari("reach-v0")
    np.testing.assert_array_equal(demos.states, np.vstack([told[0][0][:-1], told[1][0][:-1]]))
    np.testing.assert_array_equal(demos.actions, np.vstack([told[0][1], told[1][1]]))
    np.testing.assert_array_equal(demos.final_states, np.vstack([told[0][0][-1], told[1][0][-1]]))
    assert demos.truncated.tolist() == [True, False]


@pytest.mark.filterwarnings("ignore")
def test_bad_data_sets(minari, tmp_path) -> None:
    with pytest.raises(ReadError, match=r"nothing/here-v0: found .*Try: minari download nothing/here-v0"):
        read_minari("nothing/here-v0")
    with pytest.raises(ReadError, match="no id at all"):
        read_minari("no id at all")
    with pytest.raises(InputError, match="dataset: found int"):
        read_minari(3)
    write(minari, "square-v0", spaces.Box(0, 1, (2, 2)), spaces.Discrete(2), [(np.zeros((2, 2, 2)), [0], True)])
    with pytest.raises(InputError, match="observation space: found Box"):
        read_minari("square-v0")
    write(minari, "odd-v0", spaces.Discrete(2), spaces.Discrete(2), [([0, 1], [7], True)])
    with pytest.raises(InputError, match="action: found number 7 of its space"):
        read_minari("odd-v0")
    write(minari, "short-v0", spaces.Discrete(2), spaces.Discrete(2), [([0, 1, 1], [1], True)])
    with pytest.raises(ReadError, match="short-v0 at episode 0: found 3 observations, 1 actions and 1 terminations"):
        read_minari("short-v0")
    write(minari, "torn-v0", spaces.Discrete(2), spaces.Discrete(2), [([0, 1], [1], True)])
    (stored,) = (tmp_path / "torn-v0").rglob("*.hdf5")
    stored.write_bytes(stored.read_bytes()[:100])
    with pytest.raises(ReadError, match="torn-v0"):
        read_minari("torn-v0")


@pytest.mark.parametrize(("package", "ask"), [("minari", lambda: read_minari("x")), ("gymnasium", lambda: None)])
def test_a_missing_package_is_named(package: str, ask, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name, *rest):
        if name.split(".")[0] == package:
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr(episodes, "import_module", without)
    episodes._recorder_class.cache_clear()
    extra = {"minari": "minari", "gymnasium": "gym"}[package]
    with pytest.raises(MissingExtraError, match=rf"{package} is not installed.*subgoal\[{extra}\]"):
        ask() or record_episodes(None)
    if package == "gymnasium":
        with pytest.raises(MissingExtraError, match="gymnasium is not installed"):
            episodes._reader(spaces.Discrete(2), "action")
