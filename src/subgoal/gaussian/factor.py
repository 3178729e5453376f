"""Cholesky factors that say what they are worth: their condition, and any variance that had to be added."""

from __future__ import annotations

import enum
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cholesky, lapack, solve_triangular

from subgoal.runtime.checks import Floats, frozen
from subgoal.runtime.errors import InputError, SubgoalError

ILL_CONDITIONED_FROM = 1e10
"""Condition from which fewer than six digits are sure."""
LEAST_JITTER = 1e-14
"""Share of the mean variance that is tried first."""
_ADVICE = "Try: noise, a shorter length scale, fewer points, or a rougher covariance (Matern)"


class Status(enum.Enum):
    """What the solution is worth; the value says it in words."""

    EXACT = "exact"
    MERGED = "exact: points that are given several times have one value each without noise, and count once"
    ILL_CONDITIONED = f"ILL-CONDITIONED: fewer than six digits are sure. {_ADVICE}"
    JITTERED = f"JITTERED: singular in these numbers, so that a variance was added (jitter). {_ADVICE}"


class SingularError(SubgoalError):
    """A covariance matrix has no Cholesky factor, whatever variance within bounds is added."""


class RegressionWarning(UserWarning):
    """A Gaussian process is less than was asked for; its status says how."""


@dataclass(frozen=True, eq=False)
class Factor:
    """L Lᵀ = A + jitter·I.

    Attributes
    ----------
    lower:
        (n, n) L.
    jitter:
        What was added to the diagonal; 0 unless A has no factor of its own.
    condition:
        Estimate of the condition number of what was factorised, in the 1-norm.
    """

    lower: Floats
    jitter: float
    condition: float

    @property
    def status(self) -> Status:
        """Of this factor alone."""
        if self.jitter > 0:
            return Status.JITTERED
        return Status.EXACT if self.condition < ILL_CONDITIONED_FROM else Status.ILL_CONDITIONED

    @property
    def log_determinant(self) -> float:
        """log |A|."""
        return float(2 * np.log(np.diagonal(self.lower)).sum())

    def half_solve(self, right: Floats) -> Floats:
        """L⁻¹ B for B (n, ...)."""
        return np.asarray(solve_triangular(self.lower, right, lower=True, check_finite=False))

    def other_half_solve(self, right: Floats) -> Floats:
        """L⁻ᵀ B for B (n, ...)."""
        return np.asarray(solve_triangular(self.lower, right, lower=True, trans="T", check_finite=False))

    def solve(self, right: Floats) -> Floats:
        """A⁻¹ B for B (n, ...)."""
        return self.other_half_solve(self.half_solve(right))


def factorise(matrix: Floats, most_jitter: float) -> Factor:
    """The factor of a symmetric matrix (n, n).

    Where it has none, the smallest power of ten of variance that gives it one is added, up to ``most_jitter`` times
    the mean of the diagonal. Raises ``SingularError`` where that does not suffice, ``InputError`` for entries that are
    not finite.
    """
    if not np.isfinite(matrix).all():
        raise InputError("covariance", found="entries that are not finite", wanted="points whose distances are finite")
    scale = float(np.diagonal(matrix).mean())
    share = 0.0
    while share <= most_jitter:
        added = matrix if share == 0 else matrix + share * scale * np.eye(len(matrix))
        lower = _lower(added)
        if lower is not None:
            return Factor(frozen(lower), share * scale, _condition(added, lower))
        share = LEAST_JITTER if share == 0 else 10 * share
    raise SingularError(
        f"The covariance of {len(matrix)} points is singular, also with {most_jitter:g} of it added. {_ADVICE}."
    )


def _lower(matrix: Floats) -> Floats | None:
    try:
        return np.asarray(cholesky(matrix, lower=True, check_finite=False))
    except LinAlgError:
        return None


def _condition(matrix: Floats, lower: Floats) -> float:
    size = float(np.abs(matrix).sum(axis=0).max())
    reciprocal, _ = lapack.dpocon(lower, size, uplo="L")
    return float(1 / reciprocal) if reciprocal > 0 else float("inf")
