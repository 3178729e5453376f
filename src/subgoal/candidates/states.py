"""Candidate subgoals of a discrete world: visited states, their successors, every state, sets that share features."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from subgoal.candidates.places import visited_places
from subgoal.candidates.record import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.local_world import LocalWorld, local_world
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.runtime.checks import Ints
from subgoal.runtime.errors import InputError

if TYPE_CHECKING:
    from subgoal.mdp.grids.features import FeatureGroups


def visited(demonstrations: Demonstrations, *, metric: Metric | None = None, by_visits: bool = False) -> Candidates:
    """Every visited place or state once (thesis Proposition 1), ends of trajectories included.

    The prior is uniform over them, or with ``by_visits`` in proportion to the number of visits (discrete worlds).
    """
    if demonstrations.is_discrete:
        states, visits = np.unique(_everywhere(demonstrations), return_counts=True)
        prior = np.log(visits / visits.sum()) if by_visits else None
        return Candidates.from_states(states, coordinates=demonstrations.coordinates, log_prior=prior)
    if by_visits:
        raise InputError("by_visits", found=True, wanted="False: positions in space are visited once")
    return visited_places(demonstrations, metric=metric)


def visited_and_successors(demonstrations: Demonstrations, mdp: TabularMDP | LocalWorld) -> Candidates:
    """Every visited state and every state that one action, whichever it is, may lead to from there."""
    world = local_world(mdp)
    states = np.unique(world.check("demonstrations.states", _everywhere(demonstrations)))
    ahead = world.rows(states).successor
    coordinates = mdp.coordinates if isinstance(mdp, TabularMDP) else demonstrations.coordinates
    return Candidates.from_states(np.union1d(states, ahead).astype(np.int64), coordinates=coordinates)


def every_state(mdp: TabularMDP) -> Candidates:
    """All states of the world."""
    check_world(mdp)
    return Candidates.from_states(np.arange(mdp.n_states), coordinates=mdp.coordinates)


def feature_subgoals(
    groups: FeatureGroups, demonstrations: Demonstrations | None = None, *, coordinates: Any = None
) -> Candidates:
    """The sets of states with equal features g(f) = {s : Φ(s) = f} (thesis Definition 3).

    With ``demonstrations`` only those whose features were met (Proposition 1), ends of trajectories included. Each
    lies at the mean ``coordinates`` (S, d) of its states and is called by its feature vector.
    """
    chosen = np.arange(len(groups.members))
    if demonstrations is not None:
        states = check_states("demonstrations.states", _everywhere(demonstrations), len(groups.group))
        chosen = np.unique(groups.group[states])
    names = [f"Φ = ({', '.join(f'{value:g}' for value in groups.vectors[f])})" for f in chosen]
    return Candidates.from_states([groups.members[f] for f in chosen], coordinates=coordinates, names=names)


def _everywhere(demonstrations: Demonstrations) -> Ints:
    """States of all observations, and those where trajectories ended."""
    if not demonstrations.is_discrete:
        raise InputError("demonstrations", found="positions", wanted="states of a discrete world")
    return np.concatenate([demonstrations.states, demonstrations.final_states])
