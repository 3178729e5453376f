"""Chinese restaurant process mixtures over any conjugate base: Algorithm 2 of the thesis, done exactly two ways.

Model (thesis 2.9): z ~ CRP(η), θ_k ~ base, x_i ~ p(x | θ_{z_i}). ``collapsed_gibbs`` integrates θ out (Neal 2000,
Algorithm 3), ``neal_8`` keeps it (Neal 2000, Algorithm 8). What the thesis prints is in ``crp_mixture_literal``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.partition.crp import log_eppf
from subgoal.partition.crp_seating import Base, Collapsed, Uncollapsed, choose, summed
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array, whole
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False)
class MixtureDraws:
    """One chain; entry 0 is its start and entry t its state after sweep t.

    Attributes
    ----------
    labels:
        (sweeps + 1, N) cluster of each point; the names 0..K−1 mean nothing from one sweep to the next.
    n_clusters:
        (sweeps + 1,) K, singletons included.
    log_joint:
        (sweeps + 1,) log p(x, z), parameters integrated out: one yardstick for every sampler.
    parameters:
        Rows (K, p) at each sweep, in the order of the labels; empty for the collapsed sampler.
    """

    labels: Ints
    n_clusters: Ints
    log_joint: Floats
    parameters: tuple[Floats, ...]

    def clusters_above(self, share: float) -> Ints:
        """(sweeps + 1,) how many clusters hold more than ``share`` of the points."""
        least = share * self.labels.shape[1]
        return np.array([int((np.bincount(row) > least).sum()) for row in self.labels], dtype=np.int64)


def collapsed_gibbs(
    points: Any,
    base: Base,
    *,
    concentration: float,
    sweeps: int,
    generator: np.random.Generator,
    start: Any = None,
) -> MixtureDraws:
    """Exact draws of the partition, parameters integrated out: Neal 2000, Algorithm 3.

    Parameters
    ----------
    points:
        (N, d) finite numbers.
    base:
        Law of one cluster, for example ``NormalInverseWishart.from_data(points)``.
    concentration:
        η above 0.
    sweeps:
        Passes over all points.
    generator:
        Source of every draw.
    start:
        (N,) whole numbers, equal where two points begin together; None puts all into one cluster.
    """
    x, label, eta = checked(points, start, concentration)

    def sweep(label: Ints, _: Floats) -> tuple[Ints, Floats]:
        state = Collapsed(x, base, label, eta)  # built anew, so that rounding does not add up over sweeps
        for i in range(len(x)):
            state.leave(i)
            state.join(i, choose(state.law(i), generator))
        return state.tables.label, no_parameters

    no_parameters = np.empty((0, 0))
    return run_chain(x, base, label, eta, sweeps, no_parameters, sweep)


def neal_8(
    points: Any,
    base: Base,
    *,
    concentration: float,
    sweeps: int,
    generator: np.random.Generator,
    start: Any = None,
    auxiliaries: int = 3,
) -> MixtureDraws:
    """Exact draws of partition and parameters: Neal 2000, Algorithm 8 with ``auxiliaries`` (m) spare parameters.

    This is Algorithm 2 of the thesis with line 6 put right: a new cluster's parameter comes from the prior, and a
    point that sat alone keeps its own among the auxiliaries. Other arguments as in ``collapsed_gibbs``.
    """
    x, label, eta = checked(points, start, concentration)
    m, statistic = whole("auxiliaries", auxiliaries), base.statistics(x)
    nothing = np.zeros((len(x) * m, statistic.shape[1]))

    def sweep(label: Ints, parameter: Floats) -> tuple[Ints, Floats]:
        fresh = base.draw_given(nothing, generator).reshape(len(x), m, -1)
        label = reseat(Uncollapsed(x, base, label, eta, parameter), fresh, generator)
        return label, base.draw_given(summed(statistic, label), generator)

    return run_chain(x, base, label, eta, sweeps, base.draw_given(summed(statistic, label), generator), sweep)


def reseat(state: Uncollapsed, fresh: Floats, generator: np.random.Generator, *, keeps_own: bool = True) -> Ints:
    """One pass over the points (Algorithm 2, lines 2-8); ``fresh`` is (N, m, p)."""
    for i in range(len(fresh)):
        auxiliary = state.leave(i, fresh[i], keeps_own=keeps_own)
        state.join(i, choose(state.law(i, auxiliary), generator), auxiliary)
    return state.tables.label


def run_chain(
    points: Floats,
    base: Base,
    label: Ints,
    eta: float,
    sweeps: int,
    parameter: Floats,
    sweep: Callable[[Ints, Floats], tuple[Ints, Floats]],
) -> MixtureDraws:
    """Run ``sweep(label, parameter)`` over and over and record every state; ``base`` scores them."""
    statistic, labels, parameters = base.statistics(points), [label], [parameter]
    for _ in range(whole("sweeps", sweeps, least=0)):
        label, parameter = sweep(label, parameter)
        labels.append(label)
        parameters.append(parameter)
    joint = [log_eppf(np.bincount(z), eta) + float(base.log_marginal_of(summed(statistic, z)).sum()) for z in labels]
    return MixtureDraws(
        labels=frozen(np.array(labels)),
        n_clusters=frozen(np.array([int(z.max()) + 1 for z in labels], dtype=np.int64)),
        log_joint=frozen(np.array(joint)),
        parameters=tuple(frozen(p) for p in parameters) if parameter.size else (),
    )


def checked(points: Any, start: Any, concentration: float) -> tuple[Floats, Ints, float]:
    """Points, starting labels 0..K−1 and concentration, or ``InputError``."""
    x = real_array("points", points, ndim=2)
    if x.size == 0:
        raise InputError("points", found=f"shape {x.shape}", wanted="at least one point of one dimension")
    given = np.zeros(len(x), np.int64) if start is None else np.asarray(start)
    if given.shape != (len(x),) or given.dtype.kind not in "iu":
        raise InputError(
            "start", found=f"{given.dtype} of shape {given.shape}", wanted=f"whole numbers of shape ({len(x)},)"
        )
    label = np.unique(given, return_inverse=True)[1].astype(np.int64)
    return x, label, positive("concentration", concentration)
