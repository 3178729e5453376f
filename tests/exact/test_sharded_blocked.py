"""Blocked draws of sharded rows: the stated move, the compiled loops given weights, and one compiled step."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.special import roots_jacobi
from scipy.stats import chi2

from subgoal._kernels import shard_rows
from subgoal._kernels.blocked import draw_weights
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.sharded_blocked import (
    LOWEST,
    NONE_LEFT,
    Compass,
    Part,
    all_weights,
    draw_compass,
    draw_part,
    large_weights,
    parts_of,
)  # fmt: skip
from subgoal.sharded import write_shards
from subgoal.storage.shards import BLOCK
from tests.exact.laws import WITH_WALLS
from tests.exact.replay import python_form
from tests.exact.test_transition_samplers import WEIGHTS
from tests.oracles.shard_rows import assignment_law, direction_log_share, draw_all, inverse_draw
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

NODES = 64
"""With these the mean over the weights is right to 4e-12, where the shape of a Beta law is 0.06."""
KINDS = ["<f4", "<f8"]


def encoded(table: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    shares, peaks = np.empty(table.shape, kind), np.empty(len(table))
    shard_rows.encode(table, LOWEST[kind], shares, peaks)
    return shares, peaks


def drawn(shares, log_weights, uniforms, loops=shard_rows) -> tuple[np.ndarray, np.ndarray]:
    """Counts (C, G) and sums of log shares (C,)."""
    chains, g_count = log_weights.shape
    counts, fits = np.zeros((chains, g_count), np.int64), np.zeros(chains)
    every = all_weights(log_weights, shares.dtype.str)
    room = np.empty(g_count), np.empty(g_count)
    loops.draw_rows(shares, every.log, every.plain, uniforms, every.least, *room, counts, fits, NONE_LEFT)
    return counts, fits


def stick(a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of the mean over Beta(a, b)."""
    x, mass = roots_jacobi(NODES, b - 1, a - 1)
    return (1 + x) / 2, mass / mass.sum()


def stated_step(table: np.ndarray, eta: float) -> tuple[list[tuple[int, ...]], np.ndarray]:
    """Count vectors and their transition matrix: w | n ~ Dirichlet(ηp + n) by quadrature, then rows one by one."""
    n, g_count = table.shape
    states = [s for s in itertools.product(range(n + 1), repeat=g_count) if sum(s) == n]
    place = {state: k for k, state in enumerate(states)}
    step = np.zeros((len(states), len(states)))
    for k, counts in enumerate(states):
        a = eta * PRIOR + np.array(counts)
        (first, p), (second, q) = stick(a[0], a[1] + a[2]), stick(a[1], a[2])
        w = np.stack(np.broadcast_arrays(first[:, None], (1 - first)[:, None] * second,
                                         (1 - first)[:, None] * (1 - second)), axis=-1).reshape(-1, 3)  # fmt: skip
        mass = (p[:, None] * q).ravel()
        each = w[:, None] * np.exp(table)
        each /= each.sum(axis=2, keepdims=True)
        for theta in itertools.product(range(g_count), repeat=n):
            to = place[tuple(np.bincount(theta, minlength=g_count).tolist())]
            step[k, to] += mass @ each[:, range(n), theta].prod(axis=1)
    return states, step


def count_law(table: np.ndarray, eta: float, states: list[tuple[int, ...]]) -> np.ndarray:
    law = dict.fromkeys(states, 0.0)
    for theta, p in assignment_posterior(table, eta, PRIOR).items():
        law[tuple(np.bincount(theta, minlength=3).tolist())] += p
    return np.array(list(law.values()))


@pytest.mark.parametrize("eta", [0.3, 1.0, 5.0])
@pytest.mark.parametrize("name", TABLES)
def test_the_stated_sweep_leaves_the_posterior_of_the_counts_invariant(name: str, eta: float) -> None:
    states, step = stated_step(TABLES[name], eta)
    pi = count_law(TABLES[name], eta, states)
    assert np.abs(step.sum(axis=1) - 1).max() <= 1e-12
    assert np.abs(pi @ step - pi).sum() <= 1e-11


@pytest.mark.parametrize("kind", KINDS)
def test_compiled_steps_follow_the_stated_one(kind: str) -> None:
    """10,000 one-sweep draws from every state, pooled chi-square; level 1e-6, notices cell errors of about 0.02."""
    table, eta, draws = TABLES["generic"], 0.7, 10_000
    states, step = stated_step(table, eta)
    shares, _ = encoded(table, kind)
    generator, log_weights = np.random.default_rng(5), np.empty((draws, 3))
    statistic, freedom = 0.0, 0
    for k, state in enumerate(states):
        for row in log_weights:
            draw_weights(np.array(state), PRIOR, eta, row, generator)
        counts, _ = drawn(shares, log_weights, generator.random((draws, len(table))))
        seen = np.array([(counts == other).all(axis=1).sum() for other in states])
        assert seen.sum() == draws
        statistic += ((seen - draws * step[k]) ** 2 / (draws * step[k])).sum()
        freedom += len(states) - 1
    assert chi2.sf(statistic, freedom) >= 1e-6


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("weights", WEIGHTS.values(), ids=WEIGHTS.keys())
@pytest.mark.parametrize("name", WITH_WALLS)
def test_rows_given_weights_are_drawn_exactly(name: str, weights: list[float], kind: str) -> None:
    """With the midpoints of 2^12 equal parts for uniform numbers; also where every possible weight is below e^−745."""
    parts, table = 2**12, WITH_WALLS[name]
    log_weights = np.tile(weights, (parts, 1))
    for row in range(len(table)):
        shares, _ = encoded(table[row : row + 1], kind)
        counts, _ = drawn(shares, log_weights, ((np.arange(parts) + 0.5) / parts)[:, None])
        law = assignment_law(table[row], np.array(weights))
        assert np.abs(counts.mean(axis=0) - law).max() <= 1.5 / parts + 1e-6
        assert not counts[:, law == 0].any()


def far_table(g_count: int, rows: int = 300) -> np.ndarray:
    """Log densities that differ by up to a thousand nats, some impossible, none of them in every column."""
    generator = np.random.default_rng(g_count)
    table = generator.normal(size=(rows, g_count)) * np.exp(generator.uniform(0, 6, size=(rows, 1)))
    table[:, 1:][generator.random((rows, g_count - 1)) < 0.2] = -np.inf
    return table


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("g_count", [2, 5, 32, 33, 100])
def test_draws_and_sums_are_those_of_the_oracle(g_count: int, kind: str) -> None:
    """Weights from 1 down to e^−300, so that some rows are drawn from logs; the same uniform numbers."""
    table, generator = far_table(g_count), np.random.default_rng(1)
    log_weights = -generator.exponential(60, size=(3, g_count))
    log_weights -= log_weights.max(axis=1, keepdims=True)
    uniforms = generator.random((3, len(table)))
    shares, peaks = encoded(table, kind)
    counts, fits = drawn(shares, log_weights, uniforms)
    for c in range(3):
        wanted, fit = draw_all(table, log_weights[c], uniforms[c])
        np.testing.assert_array_equal(counts[c], wanted)
        np.testing.assert_allclose(fits[c] + peaks.sum(), fit, rtol=3e-7 if kind == "<f4" else 1e-12)


def test_what_is_too_small_for_a_share_is_kept_as_its_logarithm() -> None:
    shares, peaks = encoded(np.array([[3.0, -83.9, -84.1, -997.0, -np.inf]]), "<f4")
    assert peaks.tolist() == [3.0]
    assert shares[0, 0] == 1
    assert 0 < shares[0, 1] < 1e-37
    np.testing.assert_allclose(shares[0, 2:4], [-87.1, -1000.0], rtol=1e-6)
    assert np.isneginf(shares[0, 4])


def test_a_row_that_no_weight_allows_makes_the_sum_not_a_number() -> None:
    shares, _ = encoded(np.array([[0.0, -np.inf], [0.0, 0.0]]), "<f4")
    counts, fits = drawn(shares, np.array([[-np.inf, 0.0]]), np.full((1, 2), 0.5))
    assert np.isnan(fits).all()
    assert counts.sum() <= 1


@pytest.mark.parametrize("value", [np.nan, -np.inf])
def test_a_row_without_a_largest_number_is_told(value: float) -> None:
    _, peaks = encoded(np.full((2, 3), value), "<f4")
    assert not np.isfinite(peaks).any()


def test_compiled_is_the_python_form() -> None:
    table, generator = far_table(5, 40), np.random.default_rng(2)
    log_weights, uniforms = -generator.exponential(20, size=(2, 5)), generator.random((2, 40))
    compiled = drawn(encoded(table, "<f8")[0], log_weights, uniforms)
    with python_form(shard_rows), np.errstate(all="ignore"):
        plain = drawn(encoded(table, "<f8")[0], log_weights, uniforms)
    np.testing.assert_array_equal(compiled[0], plain[0])
    np.testing.assert_allclose(compiled[1], plain[1], rtol=1e-12)


@pytest.mark.parametrize("alpha", [1e-3, 0.5, 3.0, 40.0, 5000.0])
def test_shares_of_directions_are_those_of_the_oracle(alpha: float) -> None:
    generator = np.random.default_rng(7)
    states, goals, near, log_uniform = generator.uniform(0, 4, (60, 2)), generator.uniform(0, 4, (2, 9)), 0.5, -0.4
    angle = generator.uniform(0, 2 * np.pi, 60)
    units = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    units[::7] = 0.0
    states[3] = goals[:, 2]
    shares = np.empty((60, 9))
    shard_rows.direction_shares(units, states, np.ascontiguousarray(goals), near, alpha, math.exp(log_uniform), shares)
    found = np.where(shares > 0, np.log(np.abs(shares)), shares)
    wanted = [[direction_log_share(s, u, g, alpha, near, log_uniform) for g in goals.T]
              for s, u in zip(states, units, strict=True)]  # fmt: skip
    np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-14 + 1e-14 * alpha)


def test_compiled_shares_of_directions_are_the_python_form() -> None:
    """On a goal, too, where there is no direction to it."""
    generator = np.random.default_rng(7)
    states, goals = generator.uniform(0, 4, (20, 2)), generator.uniform(0, 4, (2, 5))
    states[3], units = goals[:, 2], np.tile([0.6, 0.8], (20, 1))
    given = units, states, np.ascontiguousarray(goals), 0.5, 3.0, 0.6
    compiled, plain = np.empty((20, 5)), np.empty((20, 5))
    shard_rows.direction_shares(*given, compiled)
    with python_form(shard_rows), np.errstate(all="ignore"):
        shard_rows.direction_shares(*given, plain)
    np.testing.assert_allclose(compiled, plain, rtol=1e-13)


def test_draws_of_directions_are_those_of_their_shares() -> None:
    """More rows than a tile holds."""
    generator = np.random.default_rng(8)
    states, goals = generator.uniform(0, 4, (3000, 2)), generator.uniform(0, 4, (2, 9))
    units = generator.normal(size=(3000, 2))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    shares, log_weights = np.empty((3000, 9)), np.log(generator.dirichlet(np.ones(9), size=2))
    uniforms = generator.random((2, 3000))
    shard_rows.direction_shares(units, states, goals, 0.3, 3.0, 0.5, shares)
    wanted = drawn(shares, log_weights, uniforms)
    counts, fits = np.zeros((2, 9), np.int64), np.zeros(2)
    shard_rows.draw_directions(
        units, states, goals, 0.3, 3.0, 0.5, log_weights, np.exp(log_weights), uniforms,
        np.full(2, 1e-250), np.empty(9), np.empty(9), counts, fits, NONE_LEFT,
    )  # fmt: skip
    np.testing.assert_array_equal(counts, wanted[0])
    np.testing.assert_allclose(fits, wanted[1], rtol=1e-12)


def test_rows_that_the_large_weights_do_not_settle_are_drawn_over_all() -> None:
    """Against the oracle, row by row over the candidates that it was drawn from."""
    generator, g_count, rows, alpha, near = np.random.default_rng(9), 200, 400, 300.0, 0.3
    log_weights = np.where(generator.random((2, g_count)) < 0.1, -generator.exponential(2, (2, g_count)), -75.0)
    log_weights[:, 7] = 0.0
    every = all_weights(log_weights, "<f8")
    large = large_weights(every)
    assert large.places.size < 60
    states, goals = generator.uniform(0, 4, (rows, 2)), generator.uniform(0, 4, (2, g_count))
    units = generator.normal(size=(rows, 2))
    units /= np.linalg.norm(units, axis=1, keepdims=True)
    arrays = {"x": states[:, 0], "y": states[:, 1], "along": units[:, 0], "across": units[:, 1]}
    law, uniforms = Compass(goals, near, alpha, math.exp(-250.0), 0.0), generator.random((2, rows))
    counts, fits = np.zeros((2, g_count), np.int64), np.zeros(2)
    draw_compass(law, arrays, uniforms, every, large, counts, fits)
    table = np.array([[direction_log_share(s, u, g, alpha, near, -250.0) for g in goals.T]
                      for s, u in zip(states, units, strict=True)])  # fmt: skip
    for c in range(2):
        wanted, fit, left = np.zeros(g_count), 0.0, 0
        for i in range(rows):
            settled = np.exp(table[i] + log_weights[c])[large.places].sum() > large.least[c]
            places = large.places if settled else np.arange(g_count)
            g = places[inverse_draw(table[i, places], log_weights[c, places], uniforms[c, i])]
            wanted[g], fit, left = wanted[g] + 1, fit + table[i, g], left + (not settled)
            if settled:
                law_of_all = assignment_law(table[i], log_weights[c])
                assert law_of_all[large.places].sum() > 1 - 1e-15
        assert 50 < left < 350
        np.testing.assert_array_equal(counts[c], wanted)
        np.testing.assert_allclose(fits[c], fit, rtol=1e-10)


def test_weights_are_left_out_where_most_are_negligible_and_only_there() -> None:
    """The sum of those left out is at most 2^−100 in every chain; few are left out for nothing."""
    log_weights = np.full((2, 100), -71.0)
    log_weights[0, :4], log_weights[1, 50] = 0.0, 0.0
    large = large_weights(all_weights(log_weights, "<f8"))
    gone = np.setdiff1d(np.arange(100), large.places)
    assert not np.isin(np.array([0, 1, 2, 3, 50]), gone).any()
    assert np.exp(log_weights[:, gone]).sum(axis=1).max() <= 2.0**-100
    every = all_weights(np.full((2, 100), -1.0), "<f8")
    assert large_weights(every) is every


@pytest.fixture
def two_like_blocks(tmp_path: Path) -> list[Part]:
    """Two blocks of the same rows, flat."""
    shards = write_shards(LogLikelihood.from_table(np.zeros((2 * BLOCK, 2))), tmp_path / "s", rows=BLOCK)
    return parts_of(shards.files, None, 1)


def test_chains_sweeps_seeds_and_blocks_have_uniform_numbers_of_their_own(two_like_blocks: list[Part]) -> None:
    seen = []
    for part in two_like_blocks:
        for seed, sweep in ((0, 0), (0, 1), (1, 0)):
            seen += draw_part(part, np.zeros((3, 2)), seed, sweep).counts[::2].tolist()
    assert len(seen) == 18
    assert len(set(seen)) >= 17
