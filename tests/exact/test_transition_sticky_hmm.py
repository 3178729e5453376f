"""The sticky hidden Markov model against enumeration: path, tables, whole candidates; long runs; joint law."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad
from scipy.special import roots_genlaguerre, roots_jacobi

from subgoal._kernels import sticky_hmm as loops
from subgoal.partition.learning import Learning
from subgoal.partition.priors import Beta, Gamma
from subgoal.partition.protocol import Chain
from subgoal.partition.sticky_hmm import StickyHMM, _Walk
from tests.exact.replay import matrix, outcomes
from tests.exact.shared_tables import ALL, distance_ratio, with_trajectories
from tests.oracles.hdp import chain_rule, drawn_from_shared, probability, seatings, walk_rows
from tests.oracles.tables import PRIOR, TABLES

STARTS = (0, 3)
"""Two trajectories: three steps and one."""
GAMMA = 1.5
PAIR = PRIOR[:2] / PRIOR[:2].sum()
ROWS = np.array([[0.7, 0.1, 0.2], [0.3, 0.3, 0.4], [0.05, 0.15, 0.8]])
BEGIN = np.array([0.2, 0.5, 0.3])
WEIGHTS = np.array([0.6, 0.1, 0.3])
NUMBERS = [(2.0, 0.6), (0.7, 0.0), (8.0, 0.9)]
"""a + κ and κ / (a + κ)."""


def walk_at(table, theta, mass: float = 2.0, stickiness: float = 0.6, counts=None, model: StickyHMM | None = None):
    counts = np.bincount(theta, minlength=table.n_candidates) if counts is None else np.array(counts)
    state = {"theta": np.array(theta, np.int32), "counts": counts, "row_mass": np.array([mass, stickiness])}
    return _Walk(Chain(table, GAMMA, np.random.default_rng(0), state), model or StickyHMM(mass, stickiness))


def fit(dense: np.ndarray, theta) -> float:
    return float(np.exp(sum(dense[i, g] for i, g in enumerate(theta))))


def given(walk: _Walk, rows: np.ndarray = ROWS, begin: np.ndarray = BEGIN) -> None:
    """Set the transitions."""
    walk.begin[:] = begin
    for j, row in enumerate(rows):
        loops.pack_row(j, np.log(row), *walk.rows)


@pytest.mark.parametrize(("mass", "stickiness"), NUMBERS)
def test_the_oracle_sums_to_one_and_agrees_with_quadrature(mass: float, stickiness: float) -> None:
    free, sticky = mass * (1 - stickiness), mass * stickiness
    beta = stats.beta(*(GAMMA * PAIR))

    def numeric(rows, theta) -> float:
        """The chain rule averaged over β by quadrature over its quantiles."""
        return quad(lambda q: chain_rule(rows, theta, free, sticky, (beta.ppf(q), 1 - beta.ppf(q))), 0, 1)[0]

    total = 0.0
    for theta in itertools.product(range(2), repeat=4):
        rows = walk_rows(theta, STARTS)
        value = probability(rows, theta, free, sticky, GAMMA, PAIR)
        total += value
        assert abs(value - numeric(rows, theta)) <= 1e-8
    assert abs(total - 1) <= 1e-12


@pytest.mark.parametrize("name", ALL)
def test_the_path_has_its_exact_law(name: str) -> None:
    """Whatever path there was: the draw is from p(θ | O, rows), over two blocks of rows."""
    table = with_trajectories(ALL[name], STARTS, edges=(2,))
    wanted = {}
    for theta in itertools.product(range(3), repeat=4):
        steps = [BEGIN[g] if i in STARTS else ROWS[theta[i - 1], g] for i, g in enumerate(theta)]
        wanted[theta] = fit(ALL[name], theta) * float(np.prod(steps))
    total = sum(wanted.values())

    def move():
        walk = walk_at(table, (0, 2, 0, 1))
        given(walk)
        walk._draw_path()
        return tuple(int(g) for g in walk.theta)

    found = outcomes(loops, move)
    assert max(abs(found.get(theta, 0.0) - value / total) for theta, value in wanted.items()) <= 1e-13


def test_the_filter_gives_the_evidence() -> None:
    table, dense = with_trajectories(TABLES["generic"], STARTS), TABLES["generic"]
    walk = walk_at(table, (0, 0, 0, 0))
    given(walk)
    out = np.empty((4, 3))
    value = walk._filter(0, np.zeros(3), out)
    total = sum(
        fit(dense, theta) * np.prod([BEGIN[g] if i in STARTS else ROWS[theta[i - 1], g] for i, g in enumerate(theta)])
        for theta in itertools.product(range(3), repeat=4)
    )
    assert abs(value + np.log(np.exp(dense) @ PRIOR).sum() - np.log(total)) <= 1e-12
    assert np.abs(out.sum(axis=1) - 1).max() <= 1e-12


@pytest.mark.parametrize(("mass", "stickiness"), NUMBERS)
@pytest.mark.parametrize("theta", [(1, 1, 1, 1), (0, 0, 1, 0), (2, 2, 2, 0), (0, 1, 0, 2)])
def test_tables_have_their_exact_law(theta, mass: float, stickiness: float) -> None:
    """p(tables, sticky tables | θ, β): Stirling numbers and binomials."""
    free, sticky = mass * (1 - stickiness), mass * stickiness
    rows = walk_rows(theta, (0,))
    wanted = {}
    for tables, shared, weight in seatings(rows, theta, free, sticky):
        key = tuple(sorted((3 if r == "first" else r, g, m, w) for (r, g), (m, w) in tables.items()))
        wanted[key] = float(weight * np.prod([WEIGHTS[g] ** m for g, m in shared.items()]))
    total = sum(wanted.values())
    assert abs(total - chain_rule(rows, theta, free, sticky, WEIGHTS)) <= 1e-13
    table = with_trajectories(TABLES["generic"], (0,))

    def move():
        walk = walk_at(table, theta, mass, stickiness)
        walk._draw_tables(WEIGHTS)
        cells = [(int(j), int(g)) for j, g in np.argwhere(walk.tables)]
        drawn = walk.tables.sum(axis=0) - walk.own
        assert (drawn == walk.shared).all()
        return tuple(sorted((j, g, int(walk.tables[j, g]), int(walk.own[g]) if j == g else 0) for j, g in cells))

    found = outcomes(loops, move)
    assert set(found) == {key for key, value in wanted.items() if value > 0}
    assert max(abs(p - wanted[key] / total) for key, p in found.items()) <= 1e-13


@pytest.mark.parametrize(("name", "columns", "length"), [("generic", 3, 4), ("barred", 3, 3), ("peaked", 2, 4)])
def test_moves_of_whole_candidates_leave_the_posterior_invariant(name: str, columns: int, length: int) -> None:
    """On p(θ, how often each candidate was drawn from β | O), β and rows integrated out."""
    dense = ALL[name][:length, :columns]
    prior = PRIOR[:columns] / PRIOR[:columns].sum()
    table = with_trajectories(dense, (0,), prior, edges=(1,))
    law: dict = {}
    for theta in itertools.product(range(columns), repeat=length):
        for _, shared, weight in seatings(walk_rows(theta, (0,)), theta, 0.8, 1.2):
            key = (theta, tuple(shared[g] for g in range(columns)))
            value = weight * drawn_from_shared(shared, GAMMA, prior) * fit(dense, theta)
            law[key] = law.get(key, 0.0) + float(value)
    law = {key: value for key, value in law.items() if value > 0}
    states, pi = list(law), np.array(list(law.values()))
    pi /= pi.sum()

    def move(state):
        walk = walk_at(table, state[0], counts=state[1])
        walk._move_clusters()
        return tuple(int(g) for g in walk.theta), tuple(int(m) for m in walk.shared)

    step = matrix(states, lambda state: outcomes(loops, lambda: move(state)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12
    assert np.abs(step - np.eye(len(states))).max() >= 0.1


def test_a_row_is_a_dirichlet_draw() -> None:
    """Every component is a Beta variable, also where most are below the cut. Level 3e-6 over seven comparisons."""
    shape, generator = np.array([0.3, 2.0, 0.05, 7.0, 1e-3, 0.0]), np.random.default_rng(4)
    draws = np.empty((20_000, shape.size))
    for row in draws:
        loops.draw_log_row(shape, row, generator)
    assert np.abs(np.exp(draws).sum(axis=1) - 1).max() <= 1e-12
    assert (draws[:, 5] == loops.LOWEST).all()
    for g in range(4):
        law = stats.beta(shape[g], shape.sum() - shape[g])
        assert stats.kstest(np.exp(draws[:, g]), law.cdf).pvalue >= 3e-6 / 7
    for cut in (-599.9, -200.0, -20.0):
        chance = stats.beta(shape[4], shape.sum() - shape[4]).sf(np.exp(cut))
        assert stats.binomtest(int((draws[:, 4] > cut).sum()), len(draws), chance).pvalue >= 3e-6 / 7


def test_small_shapes_give_rows_that_hold_one_candidate() -> None:
    """Shapes of 1e-5: one component is all, each as often as the other. Five standard errors."""
    generator, row, seen = np.random.default_rng(5), np.empty(2), 0
    for _ in range(4000):
        loops.draw_log_row(np.array([1e-5, 3e-5]), row, generator)
        assert row.max() >= -1e-9
        seen += row[0] > -1
    assert abs(seen / 4000 - 0.25) <= 5 * np.sqrt(0.25 * 0.75 / 4000)


def test_transitions_are_drawn_given_the_steps() -> None:
    """Means of Dirichlet(aβ + κδ + counts), first steps without κ. Five standard errors, 24 means."""
    counts = np.array([[3, 1, 0], [0, 0, 0], [1, 0, 2], [0, 2, 0]])
    walk, generator = walk_at(with_trajectories(TABLES["generic"], STARTS), (0,) * 4), np.random.default_rng(6)
    free, sticky, size = 0.9, 1.4, 4000
    draws = np.empty((size, 4, 3))
    for draw in draws:
        loops.draw_transitions(counts, WEIGHTS, free, sticky, walk.begin, *walk.rows, walk.work, generator)
        draw[:3], draw[3] = walk.rows.onto.T, walk.begin
        packed = np.zeros((3, 3))
        for j in range(3):
            packed[j, walk.rows.column[j, : walk.rows.length[j]]] = walk.rows.above[j, : walk.rows.length[j]]
        assert np.abs(packed - draw[:3]).max() <= 1e-250
    shape = free * WEIGHTS + counts + sticky * np.eye(4, 3)
    shape[3] = free * WEIGHTS + counts[3]
    wanted = shape / shape.sum(axis=1, keepdims=True)
    assert (np.abs(draws.mean(axis=0) - wanted) <= 5 * draws.std(axis=0) / np.sqrt(size) + 1e-12).all()


def path_law(dense: np.ndarray, free, sticky, weight=1.0, starts=STARTS) -> dict:
    """p(θ | O) and mean numbers; ``free`` and ``sticky`` may be nodes of a quadrature with ``weight``."""
    n, g_count = dense.shape
    prior = PRIOR[:g_count] / PRIOR[:g_count].sum()
    return {
        theta: probability(walk_rows(theta, starts), theta, free, sticky, GAMMA, prior) * fit(dense, theta) * weight
        for theta in itertools.product(range(g_count), repeat=n)
    }


def run(table, model, sweeps: int, seed: int = 7):
    return model(Chain(table, GAMMA, np.random.default_rng(seed), None), np.ones(sweeps, bool))


@pytest.mark.parametrize(("name", "numbers"), [("generic", NUMBERS[0]), ("barred", NUMBERS[1]), ("flat", NUMBERS[2])])
def test_runs_reach_the_enumerated_posterior(name: str, numbers: tuple[float, float]) -> None:
    """Total variation at most 3 times that of half as many independent draws; a flat table gives the prior."""
    dense, (mass, stickiness) = ALL[name], numbers
    law = path_law(dense, mass * (1 - stickiness), mass * stickiness)
    draws = run(with_trajectories(dense, STARTS, edges=(2,)), StickyHMM(mass, stickiness), 2000).assignments
    assert distance_ratio(draws, law) <= 3


@pytest.mark.t2
@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("numbers", NUMBERS)
def test_long_runs_reach_the_enumerated_posterior(name: str, numbers: tuple[float, float]) -> None:
    dense, (mass, stickiness) = ALL[name], numbers
    law = path_law(dense, mass * (1 - stickiness), mass * stickiness)
    draws = run(with_trajectories(dense, STARTS), StickyHMM(mass, stickiness), 12_000).assignments
    assert distance_ratio(draws, law) <= 3


def nodes(law: Gamma, ratio: Beta) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """a + κ, κ / (a + κ) and weights of a product quadrature under the two priors."""
    x, u = roots_genlaguerre(40, law.shape - 1)
    y, v = roots_jacobi(24, ratio.b - 1, ratio.a - 1)
    mass, share = np.meshgrid(x / law.rate, (y + 1) / 2, indexing="ij")
    weight = np.outer(u / u.sum(), v / v.sum())
    return mass.ravel(), share.ravel(), weight.ravel()


@pytest.mark.parametrize("sweeps", [6000, pytest.param(40_000, marks=pytest.mark.t2)])
def test_what_is_learned_has_its_posterior(sweeps: int) -> None:
    """a + κ ~ Gamma(3, 1) and the sticky part ~ Beta(2, 3), integrated by quadrature: θ, and the means of both."""
    dense, law, ratio = TABLES["peaked"], Gamma(3.0, 1.0), Beta(2.0, 3.0)
    mass, share, weight = nodes(law, ratio)
    paths = path_law(dense, mass * (1 - share), mass * share, weight, (0,))
    total = sum(p.sum() for p in paths.values())
    done = run(with_trajectories(dense, (0,)), StickyHMM(law, ratio), sweeps)
    assert distance_ratio(done.assignments, {theta: float(p.sum()) for theta, p in paths.items()}) <= 3
    for name, values, spread in (("row mass", mass, 1.9), ("stickiness", share, 0.22)):
        wanted = sum((p * values).sum() for p in paths.values()) / total
        # Six standard errors of a tenth as many independent draws.
        assert abs(done.parameters[name].mean() - wanted) <= 6 * spread / np.sqrt(sweeps / 10)


def test_the_concentration_is_learned_beside_it() -> None:
    """γ ~ Gamma(2, 1) through ``Learning``: on a flat table its law is the prior."""
    table = with_trajectories(ALL["flat"], STARTS)
    model = Learning(StickyHMM(2.0, 0.5), concentration=Gamma(2.0, 1.0))
    done = run(table, model, 2000)
    # Six standard errors of 200 independent draws.
    assert abs(done.parameters["concentration"].mean() - 2.0) <= 6 * np.sqrt(2.0 / 200)


def test_the_log_joint_is_that_of_all_that_is_drawn() -> None:
    dense, theta = TABLES["generic"], (0, 0, 2, 0)
    model = StickyHMM(Gamma(3.0, 2.0), Beta(2.0, 3.0))
    walk = walk_at(with_trajectories(dense, STARTS), theta, 1.7, 0.4, (2, 0, 1), model)
    walk._draw_weights = lambda: np.log(WEIGHTS)
    found_fit, found = walk.log_joint()
    assert abs(found_fit - np.log(fit(dense, theta))) <= 1e-12
    grouped, alphas = WEIGHTS[[0, 2, 1]], GAMMA * PRIOR[[0, 2, 1]]
    wanted = found_fit + np.log(chain_rule(walk_rows(theta, STARTS), theta, 1.7 * 0.6, 1.7 * 0.4, WEIGHTS))
    wanted += stats.dirichlet(alphas).logpdf(grouped) + np.log(grouped).sum()
    wanted += stats.gamma(3.0, scale=1 / 2.0).logpdf(1.7) + stats.beta(2.0, 3.0).logpdf(0.4)
    assert abs(found - wanted) <= 1e-12


def test_unused_candidates_count_as_one_in_the_log_joint() -> None:
    theta = (2, 2, 2, 2)
    walk = walk_at(with_trajectories(TABLES["generic"], STARTS), theta, 1.7, 0.4, (0, 0, 2))
    walk._draw_weights = lambda: np.log(WEIGHTS)
    pair = np.array([0.3, 0.7])
    wanted = stats.dirichlet(GAMMA * np.array([0.2, 0.8])).logpdf(pair) + np.log(pair).sum()
    wanted += np.log(chain_rule(walk_rows(theta, STARTS), theta, 1.7 * 0.6, 1.7 * 0.4, WEIGHTS))
    found_fit, found = walk.log_joint()
    assert abs(found - found_fit - wanted) <= 1e-12
