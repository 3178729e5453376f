"""Sweeps of the default sampler against the same posterior sampled by vectorised NumPy, one observation at a time."""

from __future__ import annotations

import time
import warnings

import numpy as np

from benchmarks.common import Row, problem, seconds
from subgoal import samplers
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.sample import ConvergenceWarning, sample

CHAINS, SWEEPS = 4, 1000


def numpy_sweep(likelihood: LogLikelihood, theta: np.ndarray, generator: np.random.Generator) -> None:
    """One sweep of dish-level collapsed Gibbs and a move of every cluster, as one would write it in NumPy."""
    table, log_prior = likelihood.dense, likelihood.log_prior
    if table is None:
        raise ValueError("the comparison needs a dense table")
    prior = np.exp(log_prior)
    counts = np.bincount(theta, minlength=prior.size).astype(float)
    for i in range(theta.size):
        counts[theta[i]] -= 1
        weight = (counts + prior) * np.exp(table[i] - table[i].max())
        theta[i] = np.searchsorted(np.cumsum(weight), generator.random() * weight.sum(), side="right")
        counts[theta[i]] += 1
    for g in np.unique(theta):
        members = theta == g
        score = log_prior + table[members].sum(axis=0)
        weight = np.exp(score - score.max())
        theta[members] = np.searchsorted(np.cumsum(weight), generator.random() * weight.sum(), side="right")


def sweeps() -> Row:
    """N = G = 1,000, 4 chains of 1,000 sweeps."""
    likelihood = action_comparison(*problem(1000, 1000), confidence=5)

    def ours() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            sample(likelihood, sampler=samplers.collapsed_blocks, chains=CHAINS, draws=100, warmup=0, thin=10)

    best = seconds(ours)
    theta, generator = np.zeros(1000, np.int64), np.random.default_rng(0)
    numpy_sweep(likelihood, theta, generator)
    begin = time.perf_counter()
    for _ in range(5):
        numpy_sweep(likelihood, theta, generator)
    numpy_time = (time.perf_counter() - begin) / 5 * CHAINS * SWEEPS
    return Row("4 chains x 1,000 sweeps, N = G = 1,000", f"{best:.2f} s", "< 3 s", best < 3, "NumPy", numpy_time / best)
