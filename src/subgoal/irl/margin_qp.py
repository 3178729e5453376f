"""The quadratic program of the margin methods: weights for which the demonstrator beats every policy found so far.

    minimise  ½λ‖w‖² − t   such that   w·d_j − ℓ_j ≥ t   for every policy j,

d_j (F,) being how much more of each feature the demonstrator collects than policy j, and ℓ_j how much policy j should
lose by. Its dual is to maximise Σ_j α_j ℓ_j − ‖Σ_j α_j d_j‖²/(2λ) over the simplex: without ℓ, the nearest that a
mixture of the policies gets to the demonstrator (Abbeel and Ng 2004); with it, maximum margin planning (Ratliff,
Bagnell and Zinkevich 2006), −t being the slack.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from scipy import sparse

from subgoal.runtime.checks import Floats, frozen, positive, real_array
from subgoal.runtime.errors import InputError, MissingExtraError, PlanningError

TOLERANCE = 1e-12
"""Of the interior point method, for feasibility and gap."""


@dataclass(frozen=True, eq=False)
class MarginSolution:
    """Both sides of the program.

    Attributes
    ----------
    weights:
        (F,) w.
    margin:
        t, the least of w·d_j − ℓ_j.
    multipliers:
        (m,) α_j ≥ 0, summing to one.
    objective, dual_objective:
        ½λ‖w‖² − t, and what bounds it from below.
    residual:
        Violation of the optimality conditions, relative to the largest of the |w·d_j|, |ℓ_j| and 1. As
        w = Σ_j α_j d_j / λ, the constraints and α on the simplex hold by construction, what is left is
        Σ_j α_j (w·d_j − ℓ_j − t), no term of which is negative: ``objective`` − ``dual_objective``, without rounding.
    """

    weights: Floats
    margin: float
    multipliers: Floats
    objective: float
    dual_objective: float
    residual: float


def margin_qp(differences: Any, losses: Any = None, *, regulariser: float = 1.0) -> MarginSolution:
    """Solve for w, t and α by an interior point method (Clarabel).

    Parameters
    ----------
    differences:
        (m, F) the d_j.
    losses:
        (m,) the ℓ_j; none: zero.
    regulariser:
        λ above zero.

    Raises
    ------
    InputError
        Other shapes, NaN.
    MissingExtraError
        Clarabel is not installed.
    PlanningError
        The solver came to nothing.
    """
    table = real_array("differences", differences, ndim=2)
    if not table.size:
        raise InputError("differences", found=f"shape {table.shape}", wanted="a row at least, and a column")
    wanted = real_array("losses", np.zeros(len(table)) if losses is None else losses, ndim=1)
    if wanted.shape != (len(table),):
        raise InputError("losses", found=f"shape {wanted.shape}", wanted=f"({len(table)},)")
    strength = positive("regulariser", regulariser)
    scale = max(float(np.abs(table).max()), float(strength * np.abs(wanted).max()) ** 0.5) or 1.0
    alpha = _multipliers(table / scale, wanted * strength / scale**2)
    weights = alpha @ table / strength
    return _solution(table, wanted, strength, weights, alpha)


def _multipliers(table: Floats, losses: Floats) -> Floats:
    """(m,) α of the program with λ = 1, put back on the simplex from which rounding takes them."""
    solver = _clarabel()
    m, f = table.shape
    settings = solver.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    square = sparse.csc_matrix(sparse.diags(np.append(np.ones(f), 0.0)))
    rows = sparse.csc_matrix(np.column_stack([-table, np.ones(m)]))
    cones = [solver.NonnegativeConeT(m)]
    told = solver.DefaultSolver(square, np.append(np.zeros(f), -1.0), rows, -losses, cones, settings).solve()
    alpha = np.maximum(np.asarray(told.z, float), 0.0)
    if not (np.isfinite(alpha).all() and alpha.sum() > 0):
        raise PlanningError(f"margin program: Clarabel gave no answer ({told.status}). Try: a larger regulariser")
    return np.asarray(alpha / alpha.sum())


def _solution(table: Floats, losses: Floats, strength: float, weights: Floats, alpha: Floats) -> MarginSolution:
    slack = table @ weights - losses
    margin = float(slack.min())
    mixed = alpha @ table
    size = max(1.0, float(np.abs(table @ weights).max()), float(np.abs(losses).max()))
    products = alpha * (slack - margin)
    return MarginSolution(
        weights=frozen(weights), margin=margin, multipliers=frozen(alpha),
        objective=strength / 2 * float(weights @ weights) - margin,
        dual_objective=float(alpha @ losses) - float(mixed @ mixed) / (2 * strength),
        residual=float(products.sum()) / size,
    )  # fmt: skip


def _clarabel() -> Any:
    try:
        return import_module("clarabel")
    except ImportError:
        raise MissingExtraError("clarabel", "margin") from None
