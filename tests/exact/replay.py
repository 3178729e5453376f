"""Exact transition law of the shipped moves: their Python form is run once for every outcome of every draw."""

from __future__ import annotations

import sys
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np

LOOPS = "subgoal._kernels"
Chooser = Callable[[np.ndarray, int, Any], int]


@contextmanager
def python_form(module: ModuleType, chooser: Chooser | None = None) -> Iterator[ModuleType]:
    """The module, and those whose loops it calls, with compiled functions replaced by their Python forms.

    Every draw is made by ``chooser``, where one is given.
    """
    kept = [(each, name, loop) for each in with_called(module) for name, loop in loops_in(each)]
    draws = {} if chooser is None else primitives(chooser)
    try:
        for each, name, loop in kept:
            setattr(each, name, draws.get(name, plain(loop)))
        yield module
    finally:
        for each, name, loop in kept:
            setattr(each, name, loop)


def primitives(chooser: Chooser) -> dict[str, Callable[..., Any]]:
    """Those of ``draws``, each made by ``chooser``."""

    def choose_listed(first: int, following: np.ndarray, sizes: np.ndarray, total: int, generator: Any) -> int:
        listed = [first]
        while following[listed[-1]] >= 0:
            listed.append(int(following[listed[-1]]))
        assert sizes[listed].sum() == total
        return listed[chooser(sizes[listed].astype(float), len(listed), generator)]

    return {
        "choose": chooser,
        "choose_of": lambda weights, count, _, generator: chooser(weights, count, generator),
        "choose_listed": choose_listed,
        "opens": lambda _, __, seated, mass, generator: chooser(np.array([seated, mass]), 2, generator) == 1,
    }


def plain(loop: Any) -> Any:
    """The Python form of a loop, which it is itself where compilation is off."""
    return getattr(loop, "py_func", loop)


def loops_in(module: ModuleType) -> list[tuple[str, Any]]:
    """Names and loops that a module can call."""
    held = [(name, value) for name, value in vars(module).items() if callable(value)]
    return [(name, value) for name, value in held if str(plain(value).__module__).startswith(LOOPS)]


def with_called(module: ModuleType) -> list[ModuleType]:
    """The module, those of loops that it names, all from which it has loops, and those from which these have."""
    found = [module]
    for each in found:
        named = (value for value in vars(each).values() if isinstance(value, ModuleType))
        homes = [value for value in named if value.__name__.startswith(LOOPS)]
        homes += [sys.modules[plain(loop).__module__] for _, loop in loops_in(each)]
        found += [home for home in dict.fromkeys(homes) if home not in found]
    return found


def outcomes(module: ModuleType, move: Callable[[], Hashable]) -> dict[Hashable, float]:
    """Probability of every result of ``move``, by depth-first replay of all draws of positive weight."""
    law: dict[Hashable, float] = {}
    waiting: list[tuple[int, ...]] = [()]
    while waiting:
        prefix = waiting.pop()
        path: list[int] = []
        probability = 1.0

        def chooser(values: np.ndarray, count: int, generator: Any) -> int:
            nonlocal probability
            weights = values[:count] / values[:count].sum()
            step = len(path)  # noqa: B023
            if step < len(prefix):  # noqa: B023
                pick = prefix[step]  # noqa: B023
            else:
                positive = np.flatnonzero(weights > 0)
                pick = int(positive[0])
                waiting.extend((*path, int(other)) for other in positive[1:])  # noqa: B023
            path.append(pick)  # noqa: B023
            probability *= float(weights[pick])
            return pick

        with python_form(module, chooser):
            result = move()
        law[result] = law.get(result, 0.0) + probability
    return law


def matrix(states: list[Hashable], row: Callable[[Any], dict[Hashable, float]]) -> np.ndarray:
    """(S, S) transition matrix from the law of one step out of each state."""
    place = {state: k for k, state in enumerate(states)}
    transition = np.zeros((len(states), len(states)))
    for k, state in enumerate(states):
        for target, probability in row(state).items():
            transition[k, place[target]] += probability
    return transition


def stationary(transition: np.ndarray) -> np.ndarray:
    """The invariant distribution of an ergodic transition matrix."""
    size = len(transition)
    equations = np.vstack([transition.T - np.eye(size), np.ones(size)])
    return np.asarray(np.linalg.lstsq(equations, np.append(np.zeros(size), 1.0), rcond=None)[0])
