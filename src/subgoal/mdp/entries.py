"""A tabular world from loose entries: (row, successor, probability), in any order, successors repeated or not."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from subgoal.mdp.tabular import TabularMDP


def assembled(
    row: Any, successor: Any, probability: Any, *, n_states: int, n_actions: int, discount: float, **fields: Any
) -> TabularMDP:
    """The world whose row s·A + a has these entries; repeated successors are added up.

    Actions without entries are not available; ``fields`` are those of ``TabularMDP``, which checks what comes out.
    """
    triples = (np.asarray(probability, float), (np.asarray(row, np.int64), np.asarray(successor, np.int64)))
    table = sparse.csr_array(sparse.coo_array(triples, shape=(n_states * n_actions, n_states)))
    table.sum_duplicates()
    available = (np.diff(table.indptr) > 0).reshape(n_states, n_actions)
    fields = {"terminal": ~available.any(axis=1), **fields}
    offset = table.indptr.astype(np.int64)
    return TabularMDP(offset, table.indices, table.data, n_actions, discount, available=available, **fields)
