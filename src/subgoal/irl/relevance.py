"""How much demonstrations have to do with each state: the state relevance of thesis 3.3.1."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.tabular import TabularMDP, check_states
from subgoal.runtime.checks import Floats, frozen, positive, real_array
from subgoal.runtime.errors import InputError

Covariance = Callable[[Floats, Floats], Floats]
"""From coordinates (M, d) and (K, d) to (M, K): how similar each of the one is to each of the other."""
BLOCK = 2**22
"""Numbers that are held at a time."""


def relevance(
    demonstrations: Demonstrations, world: TabularMDP | Any, covariance: Covariance, *, multiplicity: bool = False
) -> Floats:
    """(S,) ρ(s) of thesis (3.10): the sum of a covariance function to the demonstrated states, over its maximum.

    Between 0 and 1, and 1 somewhere. The thesis divides by the maximum of ρ itself, which is circular; it is that of
    the sum here.

    Parameters
    ----------
    demonstrations:
        Of a discrete world of S states.
    world:
        A ``TabularMDP`` with coordinates, or the coordinates (S, d) themselves.
    covariance:
        ``squared_exponential``, ``exponential`` or ``constant``; or any function of two arrays of coordinates, (M, d)
        and (K, d), that gives (M, K) numbers of at least 0.
    multiplicity:
        Whether a state counts as often as it was visited. If not, each visited state counts once, and states where the
        demonstrator lingers do not drown the way there.

    Raises
    ------
    InputError
        No coordinates, states that have none, a covariance function that gives another shape, NaN, infinity, something
        negative, or nothing anywhere.
    """
    coordinates = _coordinates(world)
    states = check_states("demonstrations.states", demonstrations.states, len(coordinates))
    seen, counts = np.unique(states, return_counts=True)
    weights = counts.astype(float) if multiplicity else np.ones(seen.size)
    rows = max(1, BLOCK // seen.size)
    total = np.empty(len(coordinates))
    for begin in range(0, len(coordinates), rows):
        here = coordinates[begin : begin + rows]
        total[begin : begin + rows] = _checked(covariance, here, coordinates[seen]) @ weights
    if not total.max() > 0:
        raise InputError("covariance", found="0 everywhere", wanted="something above 0 for some state")
    return np.asarray(frozen(total / total.max()))


def squared_exponential(width: float) -> Covariance:
    """exp(−d²/(2σ²)) at distance d, ``width`` σ in units of the coordinates.

    The radial basis function that thesis 3.4 speaks of. In (3.12) as printed, e^(−d)/2σ², σ cancels in (3.10), so that
    a narrow and a wide one would be the same.
    """
    sigma = positive("width", width)
    return lambda here, there: np.asarray(np.exp(-0.5 * (cdist(here, there) / sigma) ** 2))


def exponential(width: float) -> Covariance:
    """exp(−d/(2σ²)) at distance d, as thesis 3.3.1 prints it; ``width`` σ is a square root of a length."""
    sigma = positive("width", width)
    return lambda here, there: np.asarray(np.exp(-cdist(here, there) / (2 * sigma**2)))


def constant() -> Covariance:
    """1 at all distances: every state is as relevant as any other, and what is left is PolicyWalk."""
    return lambda here, there: np.ones((len(here), len(there)))


def _coordinates(world: Any) -> Floats:
    given = world.coordinates if isinstance(world, TabularMDP) else world
    if given is None:
        wanted = "coordinates, for similarity to be that of places"
        raise InputError("world", found="a world without coordinates", wanted=wanted, hint="give an array (S, d)")
    return real_array("coordinates", given, ndim=2)


def _checked(covariance: Covariance, here: Floats, there: Floats) -> Floats:
    table = real_array("covariance", covariance(here, there), ndim=2)
    if table.shape != (len(here), len(there)):
        raise InputError("covariance", found=f"shape {table.shape}", wanted=f"shape {(len(here), len(there))}")
    if not (table >= 0).all():
        raise InputError("covariance", found=f"{table.min()}", wanted="numbers of at least 0")
    return table
