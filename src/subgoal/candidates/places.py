"""Candidate places in space: every visited place, an ε-net of them, or a file of the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from subgoal.candidates.record import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.demonstrations.thinning import epsilon_net_indices
from subgoal.runtime.checks import Floats, positive, real_array
from subgoal.runtime.errors import InputError, ReadError, data_row

DEFAULT_NET = 0.03
SEPARATORS = (",", ";", "\t", "|")


def epsilon_net(
    demonstrations: Demonstrations, radius: float | None = None, *, metric: Metric | None = None
) -> Candidates:
    """Visited places no closer than ``radius`` to each other (thesis Alg. 5 lines 2-7), every end point among them.

    ``radius`` None is 3 % of the largest extent of the states in the metric. In a discrete world whose states have
    coordinates it is a net of these, and the candidates are states.
    """
    if demonstrations.is_discrete and demonstrations.coordinates is not None:
        states = np.concatenate([demonstrations.final_states, demonstrations.states])
        places = np.asarray(demonstrations.coordinates[states])
    else:
        states, places = None, np.vstack([demonstrations.final_states, _continuous(demonstrations)])
    metric = Metric.euclidean(places.shape[1]) if metric is None else metric
    if radius is None:
        radius = DEFAULT_NET * float((np.ptp(places, axis=0) * metric.weights).max())
    radius = positive("radius", radius, zero=True)
    ends = np.arange(demonstrations.n_trajectories)
    kept = epsilon_net_indices(places, radius, metric, ends)
    if states is None:
        return Candidates(points=places[kept], radius=radius, metric=metric)
    _, first = np.unique(states[kept], return_index=True)
    kept = kept[np.sort(first)]
    return Candidates.from_states(states[kept], points=places[kept], radius=radius, metric=metric)


def visited_places(demonstrations: Demonstrations, *, metric: Metric | None = None) -> Candidates:
    """Every visited place once (thesis Proposition 1), end points included."""
    places = np.vstack([demonstrations.final_states, _continuous(demonstrations)])
    return Candidates(points=np.unique(places, axis=0), metric=metric)


def read_candidates(path: str | Path, position: Sequence[str], *, metric: Metric | None = None) -> Candidates:
    """Places from a CSV file: the ``position`` columns, optionally ``name`` and ``log_prior`` (or ``prior``) columns.

    Raises ``ReadError`` for a file that is not such a table.
    """
    import pandas as pd

    try:
        with Path(path).open(encoding="utf-8-sig") as stream:
            separator = max(SEPARATORS, key=stream.readline().count)
        table = pd.read_csv(path, sep=separator, encoding="utf-8-sig")
    except (OSError, ValueError) as problem:
        raise ReadError("candidates file", found=str(problem), wanted="a readable CSV table", where=str(path)) from None
    if not isinstance(table.index, pd.RangeIndex):
        raise ReadError("candidates file", where=str(path), found="rows longer than the header",
                        wanted="as many fields as columns")  # fmt: skip
    missing = [name for name in position if name not in table.columns]
    if missing:
        raise ReadError(
            "candidates file",
            where=str(path),
            found=f"columns {list(table.columns)}",
            wanted=f"columns {list(position)}",
        )
    prior = None
    if "log_prior" in table.columns:
        prior = table["log_prior"].to_numpy()
    elif "prior" in table.columns:
        given = real_array("column prior", table["prior"].to_numpy(), ndim=1)
        if not (given > 0).all():
            row = int(np.argmax(~(given > 0)))
            raise ReadError(
                "column prior", where=f"{data_row(row)}, of {path}", found=given[row], wanted="numbers above 0"
            )
        prior = np.log(given)
    names = tuple(table["name"].astype(str)) if "name" in table.columns else ()
    return Candidates(points=table[list(position)].to_numpy(), names=names, log_prior=prior, metric=metric)


def _continuous(demonstrations: Demonstrations) -> Floats:
    states = np.asarray(demonstrations.states)
    if states.ndim != 2:
        raise InputError("demonstrations", found="discrete states", wanted="positions (N, d)",
                         hint="subgoal.bnirl(demonstrations, mdp), in Python")  # fmt: skip
    return states
