"""Fewer observations by Gaussian processes (thesis 8.1.2): those from which the rest of a recording can be reproduced.

The thesis thinks of a process from demonstrated states to actions. Where a demonstrator comes by the same place twice
and goes different ways there is no such function, so that here positions and actions are functions of time;
``thin_by_regression`` takes either.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel

from subgoal.demonstrations.records import Demonstrations
from subgoal.gaussian.covariances import NoisyCovariance, noisy_covariance
from subgoal.gaussian.evidence import ascend, evidence_slope
from subgoal.gaussian.regression import observations
from subgoal.runtime.checks import Bools, Floats, Ints, frozen, real_array
from subgoal.runtime.errors import InputError

MOST_FITTED, WINDOWS, WINDOW = 150, 3, 50
"""Hyper-parameters are learned from at most so many evenly spaced observations, and windows of so many in a row."""
MOST_ITERATIONS = 50
START = 5.0
"""Length scale at which the search begins, in spacings of the observations: a search from longer ones may overshoot."""
NOISE = (1e-4, 1e-2)
"""Least and largest variance of an observation, in squared tolerances."""


class Reproduction(enum.Enum):
    """Whether the rest follows from what is kept; the value says it in words."""

    WITHIN_TOLERANCE = "every observation is reproduced within the tolerance"
    TOO_ROUGH = "NOT REPRODUCED: all are kept and the tolerance is exceeded. Try: a larger one, or a rougher covariance"


@dataclass(frozen=True, eq=False)
class Thinned:
    """Which of n observations were kept, and what they say of the others.

    Attributes
    ----------
    rows:
        (K,) numbers of those kept, rising.
    reproduced:
        (n, c) or (n,) posterior mean at every input, given those kept.
    error:
        (c,) largest absolute difference from what was observed, by column; a number for values (n,).
    status:
        Whether that is within the tolerance.
    covariance, noise:
        Learned by the evidence, for values divided by their tolerance.
    """

    rows: Ints
    reproduced: Floats
    error: Any
    status: Reproduction
    covariance: Kernel
    noise: float

    @property
    def saved(self) -> float:
        """Share of the observations that are not needed."""
        return 1 - len(self.rows) / len(self.reproduced)


@dataclass(frozen=True, eq=False)
class ThinnedDemonstrations:
    """Demonstrations with the pairs that are kept, and what these say of the others.

    Attributes
    ----------
    demonstrations:
        The K pairs that are kept, as they were recorded; the counts are in ``source.notes``.
    rows:
        (K,) their numbers among the N given.
    states, actions:
        (N, d), (N, k) what is reproduced from them.
    state_error, action_error:
        (d,), (k,) largest absolute difference from what was recorded.
    status:
        (D,) of each trajectory.
    """

    demonstrations: Demonstrations
    rows: Ints
    states: Floats
    actions: Floats
    state_error: Floats
    action_error: Floats
    status: tuple[Reproduction, ...]

    @property
    def saved(self) -> float:
        """Share of the observations that are not needed."""
        return 1 - len(self.rows) / len(self.states)


def thin_by_regression(inputs: Any, values: Any, tolerance: Any, *, covariance: Kernel | None = None) -> Thinned:
    """Keep observations, each time the one that is reproduced worst, until none is further off than ``tolerance``.

    Greedy, so that a few more may be kept than must be. O(n·K²) time and O(n·K) memory.

    Parameters
    ----------
    inputs:
        (n,) times, rising or not, or (n, d) places. The first and the last are always kept.
    values:
        (n, c) or (n,).
    tolerance:
        Largest absolute error, above 0; a number, or (c,). Infinity leaves a column out of account.
    covariance:
        Of values divided by their tolerance, a WhiteKernel added; it is where the search for the greatest evidence
        starts. Default: Matérn 5/2 with noise between 1 % and 10 % of the tolerance.

    Raises ``InputError`` for wrong shapes, NaN, infinity, no observations, and a tolerance that is not above 0.
    """
    given = real_array("inputs", inputs, ndim=(1, 2))
    x, y = observations(given[:, None] if given.ndim == 1 else given, values)
    columns = y[:, None] if y.ndim == 1 else y
    limit = _tolerance("tolerance", tolerance, columns.shape[1])
    counted = np.isfinite(limit)
    if not counted.any():
        raise InputError("tolerance", found="infinity throughout", wanted="a number for one column at least")
    centre, unit = columns.mean(axis=0), np.where(counted, limit, 1.0)
    scaled = (columns - centre) / unit
    model, rows, mean = _fewest(x, scaled, counted, covariance)
    reproduced = centre + mean * unit
    error = np.abs(reproduced - columns).max(axis=0)
    within = bool((np.abs(scaled - mean)[:, counted] <= 1).all())
    return Thinned(
        rows=frozen(np.sort(rows)), reproduced=frozen(reproduced.reshape(y.shape)), noise=model.noise,
        error=float(error[0]) if y.ndim == 1 else frozen(error), covariance=model.signal,
        status=Reproduction.WITHIN_TOLERANCE if within else Reproduction.TOO_ROUGH,
    )  # fmt: skip


def thin_trajectories(
    demonstrations: Demonstrations, tolerance: Any, action_tolerance: Any, *, covariance: Kernel | None = None
) -> ThinnedDemonstrations:
    """Keep of every trajectory the pairs from which its positions and actions follow as functions of time.

    Parameters
    ----------
    demonstrations:
        Positions and real actions. Without times, pairs are taken to be equally far apart. Angles that wrap are not
        known as such: a jump costs a few pairs.
    tolerance, action_tolerance:
        Largest absolute error of a position in its units and of an action in its; a number, or one per column.
        Infinity does not ask for them.
    covariance:
        As in ``thin_by_regression``; of the time since the trajectory began.

    Raises ``InputError`` for a discrete world, discrete actions, and a tolerance that is not above 0.
    """
    states, actions = _continuous(demonstrations)
    width = states.shape[1]
    limits = np.concatenate([
        _tolerance("tolerance", tolerance, width), _tolerance("action_tolerance", action_tolerance, actions.shape[1]),
    ])  # fmt: skip
    whole, offset = np.hstack([states, actions]), demonstrations.offset
    times = np.arange(len(whole), dtype=float) if demonstrations.times is None else demonstrations.times
    parts = [
        thin_by_regression(times[start:end] - times[start], whole[start:end], limits, covariance=covariance)
        for start, end in pairwise(offset)
    ]
    rows = np.concatenate([start + part.rows for start, part in zip(offset[:-1], parts, strict=True)])
    reproduced = np.vstack([part.reproduced for part in parts])
    error = np.max([part.error for part in parts], axis=0)
    return ThinnedDemonstrations(
        demonstrations=_kept(demonstrations, rows, [len(part.rows) for part in parts]), rows=frozen(rows),
        states=frozen(reproduced[:, :width]), actions=frozen(reproduced[:, width:]),
        state_error=frozen(error[:width]), action_error=frozen(error[width:]),
        status=tuple(part.status for part in parts),
    )  # fmt: skip


def _tolerance(what: str, value: Any, count: int) -> Floats:
    """(count,) numbers above 0, infinity among them."""
    limit = real_array(what, value, ndim=(0, 1), finite=False)
    if limit.shape not in ((), (count,)) or not (limit > 0).all():
        raise InputError(what, found=value, wanted=f"a number above 0, or {count} of them")
    return np.broadcast_to(limit, (count,))


def _fewest(
    inputs: Floats, scaled: Floats, counted: Bools, covariance: Kernel | None
) -> tuple[NoisyCovariance, Ints, Floats]:
    """The covariance that keeps fewer, the rows (K,), and the mean (n, c) given them.

    Of a long recording, evenly spaced observations alone do not show what goes on between them, a tremor say; with
    windows among them its length is learned although the tolerance may allow to pass it over. So both are tried.
    """
    n = len(inputs)
    even = np.unique(np.linspace(0, n - 1, min(n, MOST_FITTED)).round().astype(int))
    windows = [start + np.arange(WINDOW) for start in np.linspace(0, n - WINDOW, WINDOWS).astype(int)]
    model = _learned(inputs, scaled[:, counted], [even, *windows] if n > MOST_FITTED else [even], covariance)
    rows, mean = _greedy(model, inputs, scaled, counted, n)
    if n > MOST_FITTED:
        other = _learned(inputs, scaled[:, counted], [even], covariance)
        fewer, other_mean = _greedy(other, inputs, scaled, counted, len(rows))
        if len(fewer) < len(rows):
            return other, fewer, other_mean
    return model, rows, mean


def _learned(inputs: Floats, scaled: Floats, parts: list[Ints], covariance: Kernel | None) -> NoisyCovariance:
    """The covariance of greatest evidence, summed over parts of the observations."""
    model = noisy_covariance(_covariance(inputs, scaled, parts) if covariance is None else covariance, 0.0, inputs)
    if not model.noise > 0:
        raise InputError("covariance", found="no noise", wanted="a WhiteKernel added to it")
    if len(inputs) < 3:
        return model

    def evidence(tried: NoisyCovariance) -> tuple[float, Floats]:
        found = [evidence_slope(tried, inputs[part], scaled[part]) for part in parts]
        return sum(value for value, _ in found), np.sum([slope for _, slope in found], axis=0)

    return ascend(evidence, model, inputs[parts[0]], most_iterations=MOST_ITERATIONS, restarts=0, seed=0).model


def _covariance(inputs: Floats, scaled: Floats, parts: list[Ints]) -> Kernel:
    """The default; no shorter than the observations are apart, where all lengths have the same evidence."""
    span = float(np.ptp(inputs, axis=0).max()) or 1.0
    finest = len(inputs) if len(parts) > 1 else len(parts[0])
    spacing = span / max(finest - 1, 1)
    variance = max(float(scaled.var(axis=0).mean()), 1.0)
    smooth = Matern(START * math.sqrt(spacing * span / max(len(parts[0]) - 1, 1)), (spacing, 10 * span), nu=2.5)
    return ConstantKernel(variance, (1e-3 * variance, 1e3 * variance)) * smooth + WhiteKernel(NOISE[1] / 2, NOISE)


def _greedy(model: NoisyCovariance, inputs: Floats, scaled: Floats, counted: Bools, most: int) -> tuple[Ints, Floats]:
    """(K,) rows in the order kept, by the error of the ``counted`` columns, and the posterior mean (n, c) given them.

    Newton's form of the posterior mean: a column of the Cholesky factor of K + σ²I, extended to all inputs, is added
    for each row kept, so that none is solved for twice.
    """
    n = len(inputs)
    mean, diagonal = np.zeros_like(scaled), model.signal.diag(inputs)
    columns, rows = np.empty((n, min(n, 16))), np.empty(n, np.int64)
    left = np.ones(n, bool)
    for k in range(most):
        error = np.abs(scaled - mean)[:, counted].max(axis=1)
        if k > 1 and error.max() <= 1:
            return rows[:k], mean
        row = (0, n - 1)[k] if k < 2 else int(np.where(left, error, -1.0).argmax())
        if k == columns.shape[1]:
            columns = np.hstack([columns, np.empty((n, min(k, n - k)))])
        before = columns[:, :k]
        pivot = math.sqrt(max(diagonal[row] + model.noise - before[row] @ before[row], model.noise))
        column = (model.signal(inputs, inputs[row : row + 1])[:, 0] - before @ before[row]) / pivot
        mean += np.outer(column, (scaled[row] - mean[row]) / pivot)
        columns[:, k], rows[k], left[row] = column, row, False
    return rows[:most], mean


def _continuous(demonstrations: Demonstrations) -> tuple[Floats, Floats]:
    for what in ("states", "actions"):
        if np.ndim(getattr(demonstrations, what)) != 2:
            raise InputError(f"demonstrations.{what}", found="integers", wanted="real numbers of shape (N, d)")
    return demonstrations.states, demonstrations.actions


def _kept(demonstrations: Demonstrations, rows: Ints, counts: list[int]) -> Demonstrations:
    dropped = demonstrations.n_observations - len(rows)
    return replace(
        demonstrations,
        states=demonstrations.states[rows],
        actions=demonstrations.actions[rows],
        offset=np.concatenate([[0], np.cumsum(counts)]),
        times=None if demonstrations.times is None else demonstrations.times[rows],
        source=demonstrations.source.noting(pairs_dropped_by_thinning=dropped, pairs_kept_by_thinning=len(rows)),
    )
