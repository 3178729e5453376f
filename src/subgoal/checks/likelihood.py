"""``check_likelihood``: is a likelihood a table of complete log densities, however it is asked."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.special import logsumexp

from subgoal.checks.completeness import Remake, complete
from subgoal.checks.report import Found, Report, tried
from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError

ROUNDING = 1e-9
MOST_ENTRIES = 2**22
"""Of the first rows, this many entries are looked at."""


def check_likelihood(likelihood: LogLikelihood, *, remake: Remake | None = None) -> Report:
    """Hold a likelihood against what samplers and answers take for granted.

    Parameters
    ----------
    likelihood:
        The N × G table; of a large one the first rows are looked at.
    remake:
        Demonstrations -> the same likelihood of other pairs, for sources of your own: with it the density is summed
        over the actions. Not needed for action comparison by direction in the plane, nor for planned actions.

    Returns a ``Report``; a check that fails, or a likelihood that raises, is in it. Raises ``InputError`` only for
    something that is no ``LogLikelihood``.
    """
    given: Any = likelihood
    if not isinstance(given, LogLikelihood):
        raise InputError("likelihood", found=type(given).__name__, wanted="a LogLikelihood")
    rows = max(1, min(likelihood.n_observations, MOST_ENTRIES // likelihood.n_candidates))
    checks = (
        tried("shape of the rows", "(N, G)", lambda: _shape(likelihood, rows)),
        tried("prior", f"sums to one within {ROUNDING:g}", lambda: _prior(likelihood)),
        tried("values", "no NaN, no +inf, no row impossible", lambda: _values(likelihood, rows)),
        tried("rows one by one = all at once", "no difference", lambda: _single(likelihood, rows)),
        tried("tiles = whole table", "no difference", lambda: _tiles(likelihood, rows)),
        tried("another confidence and back", "no difference", lambda: _at(likelihood, rows)),
        tried("arrived", "(N, G) sparse booleans", lambda: _arrived(likelihood)),
        tried("densities are complete", "1 within 1e-4", lambda: complete(likelihood, remake)),
    )
    return Report(repr(likelihood), checks)


def _shape(likelihood: LogLikelihood, rows: int) -> Found:
    found, wanted = np.shape(likelihood.rows(0, rows)), (rows, likelihood.n_candidates)
    prior = np.shape(likelihood.log_prior)
    return found == wanted and prior == wanted[1:], f"rows {found}, log_prior {prior}"


def _prior(likelihood: LogLikelihood) -> Found:
    total = float(logsumexp(likelihood.log_prior))
    return abs(total) <= ROUNDING, f"log of the sum {total:.1e}"


def _values(likelihood: LogLikelihood, rows: int) -> Found:
    values = np.asarray(likelihood.rows(0, rows))
    bad = np.isnan(values) | np.isposinf(values)
    impossible = np.isneginf(values).all(axis=1)
    if bad.any():
        i, g = (int(k) for k in np.argwhere(bad)[0])
        return False, f"{values[i, g]} for observation {i}, candidate {g}"
    if impossible.any():
        return False, f"observation {int(np.argmax(impossible))} is impossible under every candidate"
    return True, f"{rows:,} rows, from {values.min():.3g} to {values.max():.3g}"


def _same(one: Any, other: Any) -> Found:
    a, b = np.asarray(one), np.asarray(other)
    if a.shape != b.shape:
        return False, f"shapes {a.shape} and {b.shape}"
    different = int((a != b).sum())
    return not different, f"{different:,} of {a.size:,} entries differ"


def _single(likelihood: LogLikelihood, rows: int) -> Found:
    some = np.unique(np.linspace(0, rows - 1, 20).astype(int))
    each = np.concatenate([likelihood.rows(i, i + 1) for i in some.tolist()])
    return _same(each, likelihood.rows(0, rows)[some])


def _tiles(likelihood: LogLikelihood, rows: int) -> Found:
    """As many tiles as there are rows to look at, of the table never held and of the table held."""
    tiled = replace(likelihood, dense_entries=0)
    parts, first = [], 0
    for start, tile in tiled.tiles():
        if start != first:
            return False, f"a tile starts at row {start}, after row {first}"
        first = start + len(tile)
        parts.append(tile)
        if first >= rows:
            break
    wanted = likelihood.rows(0, first) if likelihood.dense is None else likelihood.dense[:first]
    return _same(np.concatenate(parts), wanted)


def _at(likelihood: LogLikelihood, rows: int) -> Found:
    confidence = likelihood.confidence
    fixed = isinstance(likelihood.source, FixedTable)
    if isinstance(confidence, (int, float, np.ndarray)) and not fixed:
        other = likelihood.at(2.0 * confidence)
        if np.array_equal(other.rows(0, rows), likelihood.rows(0, rows)) and not _silent(likelihood, rows):
            return False, "twice the confidence changes nothing"
        return _same(other.at(confidence).rows(0, rows), likelihood.rows(0, rows))
    return _same(likelihood.at(confidence).rows(0, rows), likelihood.rows(0, rows))


def _silent(likelihood: LogLikelihood, rows: int) -> bool:
    return bool(np.asarray(likelihood.source.uninformative)[:rows].all())


def _arrived(likelihood: LogLikelihood) -> Found:
    found: Any = likelihood.arrived
    wanted = (likelihood.n_observations, likelihood.n_candidates)
    sort, shape = np.dtype(found.dtype), tuple(found.shape)
    right = bool(sparse.issparse(found)) and shape == wanted and sort == np.bool_
    return right, f"{type(found).__name__} of {sort}, shape {shape}, {int(found.sum()):,} True"
