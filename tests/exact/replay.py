"""Exact transition law of the shipped moves: their Python form is run once for every outcome of every draw."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

import numpy as np

Chooser = Callable[[np.ndarray, int, Any], int]


@contextmanager
def python_form(module: ModuleType, chooser: Chooser) -> Iterator[ModuleType]:
    """The module with its compiled functions replaced by their Python forms, and every draw made by ``chooser``."""
    compiled = {name: value for name, value in vars(module).items() if hasattr(value, "py_func")}
    try:
        for name, function in compiled.items():
            setattr(module, name, function.py_func)
        module.choose = chooser  # type: ignore[attr-defined]
        yield module
    finally:
        for name, function in compiled.items():
            setattr(module, name, function)


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
