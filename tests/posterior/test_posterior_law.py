"""The posterior that ``sample`` gives: prior under a flat likelihood, duplicates, and two samplers on one case."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

import subgoal
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.diagnostics import diagnose
from tests.oracles.finite_mixture import count_law, distinct_law
from tests.posterior.worlds import corner_likelihood, quiet_sample

SAMPLERS = [subgoal.samplers.collapsed_blocks, subgoal.samplers.alg4_corrected]
LEVEL = 3e-6
FIVE_SIGMA = 5.0


def independent(values: np.ndarray) -> float:
    """How many independent draws (chain, draw) values are worth: the gate's own estimate, at most their number."""
    return min(diagnose(np.asarray(values, float)).ess_bulk, values.size)


@pytest.mark.parametrize("sampler", SAMPLERS, ids=lambda s: s.__name__)
@pytest.mark.parametrize("eta", [0.5, 4.0])
def test_flat_likelihood_gives_the_prior(sampler, eta: float) -> None:
    """K and n_1 against their exact laws, chi-square on all draws at 3e-6 after 20 sweeps between draws.

    Notices a shift of one cell's probability by about 0.01 (16,000 draws).
    """
    prior = np.array([0.4, 0.3, 0.2, 0.1])
    n = 12
    flat = LogLikelihood.from_table(np.full((n, 4), -1.7), candidates=Candidates(np.arange(4.0), np.log(prior)))
    posterior = quiet_sample(flat, sampler=sampler, concentration=eta, chains=4, draws=4000, warmup=50, thin=20)
    theta = posterior.assignments.reshape(-1, n)
    first = (theta == 0).sum(axis=1)
    active = posterior.traces["n_active"][:, 69::20].ravel().astype(int)
    assert posterior.uninformative.all()
    np.testing.assert_allclose(posterior.log_likelihood, -1.7 * n, rtol=1e-12)
    for seen, law in ((first, count_law(n, eta, prior[0])), (active, distinct_law(n, eta, prior))):
        observed = np.bincount(seen, minlength=law.size)
        assert observed.size == law.size
        expected = law * seen.size
        rare = expected < 10
        pooled = lambda a, rare=rare: np.append(a[~rare], a[rare].sum())  # noqa: E731
        gap, wanted = pooled(observed) - pooled(expected), pooled(expected)
        statistic = (gap[wanted > 0] ** 2 / wanted[wanted > 0]).sum()
        assert chi2.sf(statistic, (wanted > 0).sum() - 1) >= LEVEL


@pytest.mark.parametrize("sampler", SAMPLERS, ids=lambda s: s.__name__)
def test_doubling_every_candidate_at_half_its_prior_changes_no_place(sampler) -> None:
    """Place shares and the log evidence per draw within 5 standard errors; notices shifts of about 0.01 of a share."""
    generator = np.random.default_rng(6)
    values, prior = generator.normal(scale=1.5, size=(15, 3)), np.log([0.5, 0.3, 0.2])
    once = LogLikelihood.from_table(values, candidates=Candidates(np.arange(3.0), prior))
    twice = LogLikelihood.from_table(np.tile(values, 2), candidates=Candidates(np.arange(6.0) % 3, np.tile(prior, 2)))
    settings = {"sampler": sampler, "chains": 4, "draws": 4000, "warmup": 100, "thin": 5, "concentration": 2.0}
    one, two = quiet_sample(once, **settings), quiet_sample(twice, **settings)
    for place in range(3):
        shares = [((p.assignments % 3) == place).mean(axis=2) for p in (one, two)]
        error = np.hypot(*(s.std() / np.sqrt(independent(s)) for s in shares))
        assert abs(shares[0].mean() - shares[1].mean()) <= FIVE_SIGMA * error
    error = np.hypot(*(p.log_likelihood.std() / np.sqrt(independent(p.log_likelihood)) for p in (one, two)))
    assert abs(one.log_likelihood.mean() - two.log_likelihood.mean()) <= FIVE_SIGMA * error


def largest_shares(posterior) -> list[np.ndarray]:
    counts = posterior.counts.largest(3) / posterior.n_observations
    return [counts[:, rank].reshape(posterior.log_joint.shape) for rank in range(3)]


def test_two_samplers_agree_on_a_path_with_two_corners() -> None:
    """Log joint, K and the three largest shares within 5 Monte-Carlo standard errors of each other."""
    likelihood = corner_likelihood(radius=3.0)
    settings = {"chains": 4, "draws": 1500, "warmup": 500, "thin": 20}
    two = [quiet_sample(likelihood, sampler=sampler, **settings) for sampler in SAMPLERS]
    summaries = [[p.log_joint, p.traces["n_active"][:, 519::20], p.log_likelihood, *largest_shares(p)] for p in two]
    for a, b in zip(*summaries, strict=True):
        assert a.shape == b.shape == (4, 1500)
        error = np.hypot(a.std() / np.sqrt(independent(a)), b.std() / np.sqrt(independent(b)))
        assert abs(a.mean() - b.mean()) <= FIVE_SIGMA * error
    assert min(independent(a) for a in summaries[0]) >= 400


def test_the_corners_are_found() -> None:
    posterior = quiet_sample(corner_likelihood(), chains=4, draws=500, warmup=200, thin=5)
    found = subgoal.subgoals(posterior, merge_radius=4.0)
    assert found.n_subgoals_distribution.get(2, 0.0) > 0.5
    for corner, item in zip(((10, 0), (10, 10)), sorted(found.listed[:2], key=lambda s: s.position[1]), strict=True):
        assert np.linalg.norm(item.position - corner) <= 3.0


def test_what_a_posterior_says_of_itself_agrees() -> None:
    posterior = quiet_sample(corner_likelihood(), chains=2, draws=40, warmup=10, thin=3)
    theta, likelihood = posterior.assignments, posterior.likelihood
    n = posterior.n_observations
    fit = likelihood.dense[np.arange(n), theta].sum(axis=2)
    np.testing.assert_allclose(posterior.log_likelihood, fit, rtol=1e-12)
    counts = np.stack([np.bincount(t, minlength=likelihood.n_candidates) for t in theta.reshape(-1, n)])
    np.testing.assert_array_equal(posterior.counts.by_group(np.arange(counts.shape[1]), counts.shape[1]), counts)
    np.testing.assert_array_equal(posterior.counts.largest(4), -np.sort(-counts, axis=1)[:, :4])
    shares = (theta.reshape(-1, n)[:, :, None] == np.arange(counts.shape[1])).mean(axis=0)
    np.testing.assert_allclose(posterior.shares.toarray(), shares, atol=1e-15)
    np.testing.assert_allclose(posterior.expected_shares, counts.mean(axis=0) / n, atol=1e-15)
    from subgoal.partition.crp import log_dirichlet_multinomial

    prior = np.exp(likelihood.log_prior)
    joint = [log_dirichlet_multinomial(row, 1.0, prior / prior.sum()) for row in counts]
    np.testing.assert_allclose(posterior.log_joint.ravel(), fit.ravel() + joint, rtol=1e-11)
    best = int(np.argmax(posterior.log_joint))
    np.testing.assert_array_equal(posterior.best_assignment, theta.reshape(-1, n)[best])
    np.testing.assert_allclose(posterior.traces["loss"][:, 12::3], -fit / n, rtol=1e-12)
    assert {name: trace.shape for name, trace in posterior.traces.items()} == dict.fromkeys(
        ("n_active", "log_joint", "loss"), (2, 130)
    )


def test_diagnostics_gate() -> None:
    """One same value in all chains has converged; one per chain has not; NaN never passes."""
    assert diagnose(np.ones((4, 500))).passes
    assert not diagnose(np.arange(4.0)[:, None] * np.ones((4, 500))).passes
    assert not diagnose(np.random.default_rng(0).normal(size=(4, 3))).passes
    good = np.random.default_rng(0).normal(size=(4, 500))
    assert diagnose(good).passes
    shifted = good + np.array([0, 0, 0, 1.0])[:, None]
    assert not diagnose(shifted).passes
    assert not diagnose(np.cumsum(good, axis=1)).passes
    assert not subgoal.posterior.diagnostics.Diagnostic(np.nan, 1e4, 1e4).passes
