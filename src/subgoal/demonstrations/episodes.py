"""Demonstrations out of Gymnasium: episodes recorded while they are played, and data sets of Minari."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError

UNREADABLE = (OSError, ValueError, KeyError, TypeError, AttributeError, RuntimeError, AssertionError)
"""What Minari and HDF5 raise on data sets that are missing, torn or foreign."""


def record_episodes(env: Any) -> Any:
    """``env`` wrapped in an ``EpisodeRecorder``: play it as before, then ask for ``demonstrations()``.

    The recorder is a Gymnasium wrapper. It keeps the pairs of observation and action of every episode, where each
    ended, and whether it was cut off (by a time limit, by a reset, or because it is still running). Spaces may be
    ``Discrete``, whose values are counted from 0, or ``Box`` of one dimension.

    Raises ``InputError`` for other spaces, and ``MissingExtraError`` without Gymnasium.
    """
    return _recorder_class()(env)


def read_minari(dataset: Any) -> Demonstrations:
    """The episodes of a Minari data set, or of the one on this machine with this id; nothing is downloaded.

    Spaces are as in ``record_episodes``; trajectories are named by the ids of their episodes. An episode that did not
    terminate is ``truncated``.

    Raises
    ------
    ReadError
        There is no such data set, or it cannot be read.
    InputError
        Spaces of another kind, no steps at all.
    MissingExtraError
        Minari is not installed.
    """
    dataset = _opened(dataset)
    seen = _Episodes(_reader(dataset.observation_space, "observation"), _reader(dataset.action_space, "action"))
    for episode in _stored(dataset):
        seen.begin(episode.observations[0], str(episode.id))
        for action, after, over in zip(episode.actions, episode.observations[1:], episode.terminations, strict=True):
            seen.add(action, after, terminated=bool(over))
        seen.close(truncated=True)
    return seen.demonstrations(str(dataset.id))


def _opened(dataset: Any) -> Any:
    try:
        minari = import_module("minari")
    except ImportError:
        raise MissingExtraError("minari", "minari") from None
    if isinstance(dataset, str):
        try:
            dataset = minari.load_dataset(dataset)
        except UNREADABLE as problem:
            hint = f"minari download {dataset}"
            raise ReadError(dataset, found=str(problem), wanted="a data set of Minari", hint=hint) from None
    if not isinstance(dataset, minari.MinariDataset):
        raise InputError("dataset", found=type(dataset).__name__, wanted="a MinariDataset or the id of one")
    return dataset


def _stored(dataset: Any) -> Iterator[Any]:
    """The episodes, one at a time, each with as many values as it must have."""
    episodes = iter(dataset.iterate_episodes())
    while True:
        try:
            episode = next(episodes)
        except StopIteration:
            return
        except UNREADABLE as problem:
            raise ReadError(str(dataset.id), found=str(problem), wanted="episodes that can be read") from None
        lengths = len(episode.observations), len(episode.actions), len(episode.terminations)
        if lengths != (lengths[1] + 1, lengths[1], lengths[1]):
            found = "{} observations, {} actions and {} terminations".format(*lengths)
            wanted = "one observation more than actions"
            raise ReadError(str(dataset.id), where=f"episode {episode.id}", found=found, wanted=wanted)
        yield episode


@dataclass
class _Episodes:
    """Episodes under way and done, in lists that grow."""

    read_state: Callable[[Any], Any]
    read_action: Callable[[Any], Any]
    states: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    lengths: list[int] = field(default_factory=list)
    final: list[Any] = field(default_factory=list)
    truncated: list[bool] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    label: str | None = None
    current: Any = None
    steps: int = 0
    empty: int = 0

    def begin(self, observation: Any, label: str) -> None:
        """An episode starts; one that is still running is cut off."""
        self.close(truncated=True)
        self.current, self.label, self.steps = self.read_state(observation), label, 0

    def add(self, action: Any, after: Any, *, terminated: bool) -> None:
        """One step, and the end of the episode if it is ``terminated``."""
        self.states.append(self.current)
        self.actions.append(self.read_action(action))
        self.current, self.steps = self.read_state(after), self.steps + 1
        if terminated:
            self.close(truncated=False)

    def close(self, *, truncated: bool) -> None:
        """The running episode, if there is one, is over."""
        if self.label is not None and self.steps:
            self.lengths.append(self.steps)
            self.final.append(self.current)
            self.truncated.append(truncated)
            self.labels.append(self.label)
        elif self.label is not None:
            self.empty += 1
        self.label = None

    def demonstrations(self, name: str) -> Demonstrations:
        """All closed episodes, and the running one as far as it has come."""
        running = self.label is not None and self.steps > 0
        if not self.states:
            raise InputError("episodes", found="no steps", wanted="at least one")
        return Demonstrations(
            states=np.array(self.states),
            actions=np.array(self.actions),
            offset=np.cumsum([0, *self.lengths, *([self.steps] if running else [])]),
            final_states=np.array([*self.final, *([self.current] if running else [])]),
            truncated=np.array([*self.truncated, *([True] if running else [])]),
            trajectory_names=(*self.labels, *([str(self.label)] if running else [])),
            time_unit="step",
            source=Source(name).noting(episodes_without_a_step=self.empty),
        )


def _reader(space: Any, what: str) -> Callable[[Any], Any]:
    """How values of a space are kept: integers from 0, or vectors of floats."""
    try:
        from gymnasium import spaces
    except ImportError:
        raise MissingExtraError("gymnasium", "gym") from None
    if isinstance(space, spaces.Discrete):
        return lambda value: _counted(int(value) - int(space.start), int(space.n), what)
    if isinstance(space, spaces.Box) and len(space.shape) == 1:
        return lambda value: np.array(value, float)
    raise InputError(f"{what} space", found=str(space), wanted="Discrete, or Box of one dimension")


def _counted(number: int, count: int, what: str) -> int:
    if not 0 <= number < count:
        raise InputError(what, found=f"number {number} of its space", wanted=f"0 to {count - 1}")
    return number


@cache
def _recorder_class() -> Any:
    """The wrapper, made when it is first wanted, so that Gymnasium is not loaded before."""
    try:
        import gymnasium
    except ImportError:
        raise MissingExtraError("gymnasium", "gym") from None

    class EpisodeRecorder(gymnasium.Wrapper[Any, Any, Any, Any]):
        """Keeps what is seen and done in ``env``; see ``record_episodes``."""

        def __init__(self, env: Any) -> None:
            super().__init__(env)
            self._seen = _Episodes(_reader(env.observation_space, "observation"), _reader(env.action_space, "action"))
            self._begun = 0

        def reset(self, **options: Any) -> Any:
            """Begin an episode."""
            observation, info = self.env.reset(**options)
            self._seen.begin(observation, f"episode {self._begun}")
            self._begun += 1
            return observation, info

        def step(self, action: Any) -> Any:
            """One step, recorded; raises ``InputError`` where no episode is running."""
            if self._seen.label is None:
                raise InputError("step", found="no episode under way", wanted="a reset before it")
            observation, reward, terminated, truncated, info = self.env.step(action)
            self._seen.add(action, observation, terminated=bool(terminated))
            if truncated:
                self._seen.close(truncated=True)
            return observation, reward, terminated, truncated, info

        def demonstrations(self) -> Demonstrations:
            """What was recorded so far; raises ``InputError`` if that is nothing."""
            spec = self.env.spec
            return self._seen.demonstrations("episodes" if spec is None else str(spec.id))

    return EpisodeRecorder
