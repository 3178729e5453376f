"""The program of the margin methods: its optimality conditions, another solver, a case by hand, and bad input."""

from __future__ import annotations

import sys

import cvxpy
import numpy as np
import pytest

from subgoal.irl.margin_qp import MarginSolution, margin_qp
from subgoal.runtime.errors import InputError, MissingExtraError

CASES = [(1, 1, 1.0), (6, 3, 1.0), (40, 6, 1e-3), (60, 30, 1e-2), (25, 40, 10.0)]


def drawn(m: int, f: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Differences, the first three of them twice, and losses."""
    generator = np.random.default_rng([m, f, seed])
    differences = generator.normal(size=(m, f)) * 0.3 + 0.1
    return np.vstack([differences, differences[:3]]), generator.uniform(size=m + min(m, 3))


def violation(found: MarginSolution, differences: np.ndarray, losses: np.ndarray, strength: float) -> float:
    """Largest of stationarity in w and t, feasibility of both sides, and complementarity."""
    slack = [float(np.dot(found.weights, d)) - loss - found.margin for d, loss in zip(differences, losses, strict=True)]
    pull = sum(a * d for a, d in zip(found.multipliers, differences, strict=True))
    return max(
        max(abs(strength * found.weights - pull)), abs(1 - sum(found.multipliers)), max(-x for x in slack),
        max(-a for a in found.multipliers), max(abs(a * x) for a, x in zip(found.multipliers, slack, strict=True)),
    )  # fmt: skip


@pytest.mark.parametrize(("m", "f", "strength"), CASES)
@pytest.mark.parametrize("lossy", [False, True])
def test_the_conditions_of_an_optimum_hold(m: int, f: int, strength: float, lossy: bool) -> None:
    differences, losses = drawn(m, f)
    losses = losses * lossy
    found = margin_qp(differences, losses if lossy else None, regulariser=strength)
    assert violation(found, differences, losses, strength) <= 1e-6
    assert 0 <= found.residual <= 1e-6
    assert found.objective == pytest.approx(found.dual_objective, abs=1e-6)


@pytest.mark.parametrize("strength", [0.1, 2.0])
def test_another_solver_finds_the_same_weights(strength: float) -> None:
    differences, losses = drawn(12, 4)
    w, t = cvxpy.Variable(4), cvxpy.Variable()
    cost = strength / 2 * cvxpy.sum_squares(w) - t
    problem = cvxpy.Problem(cvxpy.Minimize(cost), [differences @ w - losses >= t])
    problem.solve(solver=cvxpy.OSQP, eps_abs=1e-10, eps_rel=1e-10, max_iter=200_000)
    found = margin_qp(differences, losses, regulariser=strength)
    np.testing.assert_allclose(found.weights, w.value, atol=1e-6)
    assert found.margin == pytest.approx(float(t.value), abs=1e-6)


def test_without_losses_it_is_the_nearest_point_of_the_hull() -> None:
    found = margin_qp([[1.0, 1.0], [1.0, -3.0], [5.0, 5.0]])
    np.testing.assert_allclose(found.weights, [1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found.multipliers, [0.75, 0.25, 0.0], atol=1e-9)
    assert found.margin == pytest.approx(1.0)


def test_demonstrators_inside_the_hull_leave_no_weights() -> None:
    found = margin_qp([[1.0, 0.0], [-1.0, 1.0], [0.0, -2.0]])
    np.testing.assert_allclose(found.weights, 0.0, atol=1e-9)
    assert found.margin == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("size", [0.0, 1e-17, 1e-9, 10.0])
def test_differences_may_be_small_or_large(size: float) -> None:
    differences, losses = drawn(8, 3)
    found = margin_qp(size * differences, losses, regulariser=0.1)
    assert found.residual <= 1e-6


def test_policies_just_like_the_demonstrator_leave_no_weights() -> None:
    found = margin_qp(np.zeros((2, 3)))
    np.testing.assert_array_equal(found.weights, 0.0)
    assert found.margin == 0


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="differences"):
        margin_qp([[1.0, np.nan]])
    with pytest.raises(InputError, match="differences"):
        margin_qp(np.empty((0, 3)))
    with pytest.raises(InputError, match="losses"):
        margin_qp([[1.0, 2.0]], [1.0, 2.0])
    with pytest.raises(InputError, match="regulariser"):
        margin_qp([[1.0, 2.0]], regulariser=float("nan"))


def test_the_extra_is_named_where_the_solver_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "clarabel", None)
    with pytest.raises(MissingExtraError, match=r"subgoal\[margin\]"):
        margin_qp([[1.0, 2.0]])
