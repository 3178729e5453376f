"""Geweke's joint test: a sweep of a right sampler leaves the joint law of (assignment, data) as it was."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from scipy.stats import norm

from subgoal import samplers
from subgoal.partition.alg4 import seated
from subgoal.partition.protocol import Chain
from tests.statistical.toy import NAMES, Toy, peaked

LEVEL = 3e-6
TOY = peaked(4, 3, 6, 1.5)
REPLICAS, STEPS = 16_000, 4


def begun(sampler, theta: np.ndarray) -> dict[str, np.ndarray]:
    """The state of a sampler at assignment θ; with tables in it with one table per candidate, split below."""
    if sampler in AT_TABLES:
        return seated(theta.astype(np.int32))
    return {"theta": theta.astype(np.int32)}


def warmed(sampler, state: dict[str, np.ndarray], outcomes: np.ndarray, generator: np.random.Generator):
    """The state with the other levels of ``tempered`` drawn from their own laws given the outcomes, by enumeration."""
    if not isinstance(sampler, samplers.Tempering):
        return state
    laws = [tempered_law(tuple(outcomes.tolist()), power) for power in sampler.powers[1:]]
    drawn = [np.searchsorted(law, generator.random() * law[-1], side="right") for law in laws]
    return {**state, "hotter": ASSIGNMENTS[drawn]}


ASSIGNMENTS = np.array(list(product(range(4), repeat=6)), np.int32)
"""Every assignment of the toy."""


@cache
def tempered_law(outcomes: tuple[int, ...], power: float) -> np.ndarray:
    """(4096,) running sums of p(θ)·p(O | θ)^β."""
    fit = np.log(TOY.emission[:, outcomes])[ASSIGNMENTS, np.arange(TOY.n)].sum(axis=1)
    return np.cumsum(np.exp(LOG_PRIORS + power * fit))


LOG_PRIORS = np.array([np.subtract(*TOY.log_joint(theta, np.zeros(TOY.n, int))) for theta in ASSIGNMENTS])
AT_TABLES = (samplers.alg4_corrected, samplers.alg4_literal_fresh_draw, samplers.alg4_literal_sum,
             samplers.cluster_collapsed)  # fmt: skip


def split(state: dict[str, np.ndarray], toy: Toy, generator: np.random.Generator) -> dict[str, np.ndarray]:
    """Seat the customers of each candidate by a restaurant of concentration ηp_g: the table-level prior given θ."""
    if "label" not in state:
        return state
    theta = state["dish"][state["label"]]
    label, dish, sizes = np.zeros(theta.size, np.int64), np.zeros(theta.size, np.int64), []
    for i, g in enumerate(theta):
        weights = [size if dish[t] == g else 0.0 for t, size in enumerate(sizes)] + [toy.eta * toy.prior[g]]
        label[i] = generator.choice(len(weights), p=np.array(weights) / sum(weights))
        if label[i] == len(sizes):
            sizes.append(0)
            dish[label[i]] = g
        sizes[label[i]] += 1
    return {"label": label, "dish": dish}


def marginal_conditional(toy: Toy, count: int, seed: int) -> np.ndarray:
    """(count, statistics): θ from the prior, outcomes given θ."""
    generator = np.random.default_rng(seed)
    rows = []
    for _ in range(count):
        theta = toy.theta(generator)
        rows.append(toy.summaries(theta, toy.outcomes(theta, generator)))
    return np.array(rows)


def successive_conditional(toy: Toy, sampler, seed: int, shown=None, replicas: int = REPLICAS) -> np.ndarray:
    """(replicas, statistics) after ``STEPS`` rounds of: outcomes given θ, one sweep given outcomes. All independent."""
    generator, keep = np.random.default_rng(seed), np.ones(1, bool)
    rows = []
    for _ in range(replicas):
        state = split(begun(sampler, toy.theta(generator)), toy, generator)
        for _ in range(STEPS):
            theta = state["theta"] if "theta" in state else state["dish"][state["label"]]
            outcomes = toy.outcomes(theta, generator)
            table = toy.table(outcomes) if shown is None else shown(toy.table(outcomes))
            state = warmed(sampler, state, outcomes, generator)
            stretch = sampler(Chain(table, toy.eta, generator, state), keep)
            state = dict(stretch.state)
        theta = stretch.assignments[0]
        if shown is None:
            assert abs(stretch.log_joint[0] - toy.log_joint(theta, outcomes)[0]) <= 1e-9
        rows.append(toy.summaries(theta, outcomes))
    return np.array(rows)


def worst(got: np.ndarray, wanted: np.ndarray) -> tuple[float, str]:
    """Largest difference of means and of variances in standard errors, and of what."""
    found = []
    for k, name in enumerate(NAMES):
        a, b = got[:, k], wanted[:, k]
        for what, x, y in ((name, a, b), (f"{name}²", (a - b.mean()) ** 2, (b - b.mean()) ** 2)):
            error = np.sqrt(x.var() / x.size + y.var() / y.size)
            found.append((abs(x.mean() - y.mean()) / error, what))
    return max(found)


LIMIT = float(norm.isf(LEVEL / 2 / (2 * len(NAMES))))
"""5.1 standard errors: two-sided, over ten statistics."""
SHIPPED = [samplers.collapsed_blocks, samplers.alg4_corrected]
MORE = [samplers.blocked, samplers.collapsed, samplers.cluster_collapsed, samplers.split_merge, samplers.tempered]


@pytest.fixture(scope="module")
def prior() -> np.ndarray:
    return marginal_conditional(TOY, 80_000, 1)


@pytest.mark.parametrize("sampler", SHIPPED, ids=lambda s: s.__name__)
def test_a_sweep_leaves_the_joint_law(sampler, prior: np.ndarray) -> None:
    """Level 3e-6 over ten statistics; notices shifts of 5 % of a standard deviation: L to the power 0.95."""
    gap, name = worst(successive_conditional(TOY, sampler, 2), prior)
    assert gap <= LIMIT, name


@pytest.mark.t2
@pytest.mark.parametrize("sampler", MORE, ids=lambda s: s.__name__)
def test_a_sweep_of_the_others_leaves_the_joint_law(sampler, prior: np.ndarray) -> None:
    """As above."""
    gap, name = worst(successive_conditional(TOY, sampler, 2), prior)
    assert gap <= LIMIT, name


@pytest.mark.t2
@pytest.mark.parametrize("sampler", [samplers.alg4_literal_fresh_draw, samplers.alg4_literal_sum])
def test_the_printed_forms_are_noticed(sampler, prior: np.ndarray) -> None:
    """Line 14 and (4.12) as printed: beyond what the shipped samplers are allowed with a quarter of the draws."""
    gap = worst(successive_conditional(TOY, sampler, 2, replicas=4000), prior)
    assert gap[0] >= 1.3 * LIMIT


@pytest.mark.t2
@pytest.mark.parametrize("sampler", SHIPPED, ids=lambda s: s.__name__)
@pytest.mark.parametrize(
    ("name", "planted"),
    [("tempered", lambda t: replace(t, dense=0.95 * t.dense)), ("prior forgotten", lambda t: replace(
        t, log_prior=np.full(t.n_candidates, -np.log(t.n_candidates)))),
     ("rows shifted", lambda t: replace(t, dense=np.ascontiguousarray(np.roll(t.dense, 1, axis=0))))],
)  # fmt: skip
def test_planted_errors_are_noticed(sampler, name: str, planted, prior: np.ndarray) -> None:
    replicas = REPLICAS if name == "tempered" else 2000
    gap = worst(successive_conditional(TOY, sampler, 2, planted, replicas), prior)
    assert gap[0] >= LIMIT, name
