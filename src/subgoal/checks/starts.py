"""States of a sampler whose law is the posterior: from them one sweep must lead to the posterior again."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from subgoal.checks.enumeration import Enumerated, enumerated
from subgoal.partition.protocol import Arrays, Sampler
from subgoal.runtime.checks import Floats, Ints

Begin = Callable[[Ints, np.random.Generator], Arrays]
"""(θ, generator) -> a state at assignment θ (N,), whatever else it has drawn from its law given θ."""


def usual_begin(sampler: Sampler, names: frozenset[str], law: Enumerated) -> Begin | None:
    """How to start samplers whose state has one of three usual forms; None for others.

    ``theta`` (N,); ``label`` and ``dish`` (N,) of tables and their candidates; ``theta`` and ``hotter`` (L−1, N) of a
    ladder whose ``powers`` are the sampler's.
    """
    if names == {"theta"}:
        return lambda theta, _: {"theta": theta.astype(np.int32)}
    if names == {"label", "dish"}:
        mass = law.concentration * np.exp(law.likelihood.log_prior)
        return lambda theta, generator: seated_by_restaurants(theta, mass, generator)
    powers = getattr(sampler, "powers", None)
    if names == {"theta", "hotter"} and powers is not None:
        return _ladder(law, powers)
    return None


def _ladder(law: Enumerated, powers: tuple[float, ...]) -> Begin:
    table, prior = np.asarray(law.likelihood.dense), np.exp(law.likelihood.log_prior)
    hotter = [enumerated(table, law.concentration, prior, power) for power in powers[1:]]

    def begin(theta: Ints, generator: np.random.Generator) -> Arrays:
        levels = [level.drawn(1, generator)[0] for level in hotter]
        return {"theta": theta.astype(np.int32), "hotter": np.array(levels, np.int32).reshape(-1, theta.size)}

    return begin


def seated_by_restaurants(theta: Ints, mass: Floats, generator: np.random.Generator) -> Arrays:
    """Tables given candidates: those of g sit by a Chinese restaurant of concentration ηp_g, ``mass`` (G,)."""
    label, dish = np.zeros(theta.size, np.int64), np.zeros(theta.size, np.int64)
    sizes: list[int] = []
    for i, g in enumerate(theta):
        weight = np.array([size * float(dish[t] == g) for t, size in enumerate(sizes)] + [mass[g]])
        t = int(np.searchsorted(np.cumsum(weight), generator.random() * weight.sum(), side="right"))
        if t == len(sizes):
            sizes.append(0)
            dish[t] = g
        sizes[t] += 1
        label[i] = t
    return {"label": label, "dish": dish}
