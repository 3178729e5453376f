"""The moves of a stream leave the posterior as it is, and the compiled loops are their Python forms."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal._kernels import streaming as loops
from tests.exact.replay import matrix, outcomes, python_form
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

CASES = [(name, eta) for name in TABLES for eta in (0.05, 1.0, 5.0)]


def relative_of(table: np.ndarray) -> np.ndarray:
    return np.exp(table) / (np.exp(table) @ PRIOR)[:, None]


def redrawn(theta, table: np.ndarray, eta: float, rows: list[int]) -> tuple[int, ...]:
    after = np.array(theta, np.int32)
    loops.redraw_some(np.array(rows), relative_of(table)[rows], after, PRIOR, eta, None)
    return tuple(after.tolist())


def moved(theta, table: np.ndarray, eta: float, i: int) -> tuple[int, ...]:
    after, room = np.array(theta, np.int32), np.full((7, 5), np.nan)
    room[: len(table), :3] = table
    loops.move_table(i, room, after, eta * PRIOR, np.log(PRIOR), None)
    return tuple(after.tolist())


MOVES = {
    "redraw some": lambda theta, table, eta: redrawn(theta, table, eta, [3, 1]),
    "move a table": lambda theta, table, eta: moved(theta, table, eta, 2),
}


@pytest.mark.parametrize(("name", "eta"), CASES)
@pytest.mark.parametrize("move", MOVES)
def test_moves_leave_the_posterior_as_it_is(move: str, name: str, eta: float) -> None:
    table = TABLES[name][:3] if move == "move a table" else TABLES[name]
    law = assignment_posterior(table, eta, PRIOR)
    states, pi = list(law), np.array(list(law.values()))
    transition = matrix(states, lambda theta: outcomes(loops, lambda: MOVES[move](theta, table, eta)))
    np.testing.assert_allclose(transition.sum(axis=1), 1)
    np.testing.assert_allclose(pi @ transition, pi, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("name", TABLES)
def test_a_new_pair_is_drawn_from_its_law_given_the_others(name: str) -> None:
    """θ_N ∝ (n_g + ηp_g)·L_Ng, wherever it stood before."""
    table, before = TABLES[name], (1, 0, 1)
    for start in range(3):
        found = outcomes(loops, lambda start=start: redrawn((*before, start), table, 0.7, [3]))
        weight = (np.bincount(before, minlength=3) + 0.7 * PRIOR) * np.exp(table[3])
        wanted = {(*before, g): weight[g] / weight.sum() for g in range(3)}
        assert found == pytest.approx(wanted)


def test_a_table_moves_as_one() -> None:
    """With hardly any mass all that share a candidate sit together, and go to another together."""
    found = outcomes(loops, lambda: moved((0, 0, 1), TABLES["generic"][:3], 1e-12, 1))
    assert {theta for theta, chance in found.items() if chance > 1e-6} == {(g, g, 1) for g in range(3)}
    weight = PRIOR * np.exp(TABLES["generic"][:2].sum(axis=0))
    for g in range(3):
        assert found[g, g, 1] == pytest.approx(weight[g] / weight.sum(), rel=1e-6)


def test_compiled_moves_are_their_python_forms() -> None:
    generator = np.random.default_rng(0)
    table, prior = generator.normal(size=(60, 17)), np.full(17, 1 / 17)
    relative = np.exp(table) / (np.exp(table) @ prior)[:, None]
    start, rows = generator.integers(4, size=60).astype(np.int32), generator.permutation(60)[:20]

    def run() -> np.ndarray:
        theta, draws = start.copy(), np.random.default_rng(1)
        for k in range(12):
            loops.redraw_some(rows, relative[rows], theta, prior, 2.0, draws)
            loops.move_table(k, table, theta, 2.0 * prior, np.log(prior), draws)
        return theta

    compiled = run()
    with python_form(loops):
        np.testing.assert_array_equal(run(), compiled)
    assert (compiled != start).any()
