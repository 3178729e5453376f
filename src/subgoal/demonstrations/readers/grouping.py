"""The column that says which group each trajectory of a table belongs to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from subgoal.runtime.checks import Ints
from subgoal.runtime.errors import ReadError, data_row


def numbered(column: Any) -> tuple[Ints, list[str]]:
    """(M,) number of the value of each row, in order of first appearance (−1 where it is missing), and the values."""
    import pandas as pd

    codes, labels = pd.factorize(pd.Series(column), use_na_sentinel=True)
    return codes.astype(np.int64), [str(label) for label in labels]


def group_of_each(
    path: Any, name: str, column: Any, *, rows: Ints, trajectory: Ints, labels: Sequence[str]
) -> list[str]:
    """The group of each trajectory, in the order of ``labels``.

    Parameters
    ----------
    name, column:
        The column (M,) that says it.
    rows:
        The rows that are used; others are not looked at. Trajectories without any have the group "".
    trajectory, labels:
        (M,) number of the trajectory of each row, and the names of the trajectories.

    Raises ``ReadError`` for a row without a value, and for a trajectory with two, naming the row.
    """
    codes, values = numbered(column)
    blank = np.array([not value.strip() for value in values] + [True])[codes]
    own, of = codes[rows], trajectory[rows]
    if blank[rows].any():
        row = rows[int(np.argmax(blank[rows]))]
        raise ReadError(
            str(path), where=f"column {name!r}, {data_row(row)}", found="no value",
            wanted=f"the group of trajectory {labels[trajectory[row]]!r}",
        )  # fmt: skip
    there, at = np.unique(of, return_index=True)
    first = np.full(len(labels), -1)
    first[there] = own[at]
    other = own != first[of]
    if other.any():
        k = int(np.argmax(other))
        raise ReadError(
            str(path), where=f"column {name!r}, {data_row(rows[k])}",
            found=f"{values[own[k]]!r} after {values[first[of[k]]]!r} in trajectory {labels[of[k]]!r}",
            wanted="one group for each trajectory",
            hint="trajectory= with the column that tells trajectories apart, whose values no two groups share",
        )  # fmt: skip
    return [values[g] if g >= 0 else "" for g in first]
