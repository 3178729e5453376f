"""State features: indicators, distances to anchors, and states grouped by the features they share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from subgoal.mdp.grids.grid import GridWorld
from subgoal.runtime.checks import Floats, Ints, frozen, real_array, whole
from subgoal.runtime.errors import InputError


def one_hot(n_states: int) -> sparse.csr_array:
    """(S, S) sparse: feature k is 1 in state k, so that feature subgoals are state subgoals."""
    return sparse.csr_array(sparse.eye_array(whole("n_states", n_states)))


def manhattan(grid: GridWorld, anchors: Any) -> Ints:
    """(S, k) distance ‖s − s_k‖₁ in cells from each state to ``anchors`` (k, 2) cells (x, y); thesis (4.16).

    Walls are not looked at, as in the thesis. Raises ``InputError`` for anchors that are not cells of the map.
    """
    cells = grid.cells[grid.states(anchors)]
    return np.asarray(np.abs(grid.cells[:, None] - cells[None]).sum(axis=2))


@dataclass(frozen=True, eq=False, repr=False)
class FeatureGroups:
    """States with equal feature vectors: what feature subgoals (thesis Definition 3) are made of.

    Attributes
    ----------
    group:
        (S,) the group of each state.
    vectors:
        (F, k) the different feature vectors, in lexicographic order.
    """

    group: Ints
    vectors: Floats

    def __repr__(self) -> str:
        return f"FeatureGroups({len(self.vectors)} feature vectors over {self.group.size} states)"

    @cached_property
    def members(self) -> tuple[Ints, ...]:
        """The states of each group: g(f) = {s : Φ(s) = f}."""
        order = np.argsort(self.group, kind="stable")
        edges = np.cumsum(np.bincount(self.group, minlength=len(self.vectors)))[:-1]
        return tuple(frozen(part) for part in np.split(order, edges))

    @property
    def is_injective(self) -> bool:
        """Whether no two states share their features, so that feature subgoals are state subgoals."""
        return len(self.vectors) == self.group.size


def feature_groups(features: Any) -> FeatureGroups:
    """Group states by their discrete features (S, k), dense or sparse. Raises ``InputError`` for NaN and infinity."""
    given: Any = features
    is_sparse: bool = sparse.issparse(given)
    table = real_array("features", given.toarray() if is_sparse else given, ndim=(1, 2))
    table = table[:, None] if table.ndim == 1 else table
    if not table.size:
        raise InputError("features", found=f"shape {table.shape}", wanted="(S, k), one of each at least")
    vectors, group = np.unique(table, axis=0, return_inverse=True)
    return FeatureGroups(frozen(group.ravel()), frozen(vectors))
