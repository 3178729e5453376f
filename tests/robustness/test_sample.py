"""``sample``: the same draws however they are computed, settings checked, budgets, Ctrl-C, nothing else touched."""

from __future__ import annotations

import os
import random
import signal
import threading
import time
import tracemalloc
import warnings

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.errors import BudgetError, InputError, SubgoalError
from subgoal.runtime.seeds import stream
from tests.posterior.worlds import assert_same_posterior, corner_likelihood, quiet_sample, table

SHORT = {"chains": 4, "draws": 30, "warmup": 5, "thin": 2, "seed": 3}


@pytest.mark.parametrize("workers", [1, 2, 4])
@pytest.mark.parametrize("backend", ["threading", "loky"])
def test_draws_do_not_depend_on_workers_or_processes(workers: int, backend: str) -> None:
    wanted = quiet_sample(table(), **SHORT)
    assert_same_posterior(wanted, quiet_sample(table(), workers=workers, backend=backend, **SHORT))


def test_processes_take_large_tables_and_controllers() -> None:
    """A table above joblib's 1 MiB goes to processes as a memory map, a controller as a function."""
    for likelihood in (table(600, 300), corner_likelihood()):
        assert_same_posterior(
            quiet_sample(likelihood, **SHORT), quiet_sample(likelihood, workers=2, backend="loky", **SHORT)
        )
    demos, net = corner_likelihood().demonstrations, corner_likelihood().candidates
    led = subgoal.action_comparison(demos, net, controller=lambda state, goal: goal - state)
    assert_same_posterior(quiet_sample(led, **SHORT), quiet_sample(led, workers=2, backend="loky", **SHORT))


@pytest.mark.parametrize("sampler", [subgoal.samplers.collapsed_blocks, subgoal.samplers.alg4_corrected])
def test_chain_k_of_four_is_chain_k_of_eight(sampler) -> None:
    four, eight = (quiet_sample(table(), sampler=sampler, **{**SHORT, "chains": c}) for c in (4, 8))
    np.testing.assert_array_equal(four.assignments, eight.assignments[:4])
    np.testing.assert_array_equal(four.traces["log_joint"], eight.traces["log_joint"][:4])


def test_chains_and_seeds_differ() -> None:
    posterior, other = quiet_sample(table(), **SHORT), quiet_sample(table(), **{**SHORT, "seed": 4})
    traces = [*posterior.traces["log_joint"], *other.traces["log_joint"]]
    for k, trace in enumerate(traces):
        assert all((trace != earlier).any() for earlier in traces[:k])


def test_streams_hang_on_identity() -> None:
    first = [stream(7, k).random(4).tolist() for k in range(6)]
    assert first == [stream(7, k).random(4).tolist() for k in range(6)]
    assert len({tuple(values) for values in first} | {tuple(stream(8, 0).random(4)), tuple(stream(7).random(4))}) == 8


def test_global_random_state_is_left_alone() -> None:
    np.random.seed(1)  # noqa: NPY002
    random.seed(1)
    before = np.random.get_state()[1].copy(), random.getstate()  # noqa: NPY002
    quiet_sample(table(), **SHORT)
    assert (np.random.get_state()[1] == before[0]).all()  # noqa: NPY002
    assert random.getstate() == before[1]
    same = quiet_sample(table(), **SHORT)
    np.random.seed(99)  # noqa: NPY002
    assert_same_posterior(same, quiet_sample(table(), **SHORT))


def test_inputs_stay_as_they_were() -> None:
    values, points, prior = np.random.default_rng(0).normal(size=(9, 3)), np.arange(3.0), np.zeros(3)
    copies = values.copy(), points.copy(), prior.copy()
    likelihood = LogLikelihood.from_table(values, candidates=Candidates(points, prior))
    for sampler in (subgoal.samplers.collapsed_blocks, subgoal.samplers.alg4_corrected):
        quiet_sample(likelihood, sampler=sampler, **SHORT)
    for array, copy in zip((values, points, prior), copies, strict=True):
        np.testing.assert_array_equal(array, copy)
        assert array.flags.writeable


def test_thin_and_warmup_choose_from_the_same_chain() -> None:
    """Draws are every ``thin``-th sweep after the warm-up, the last of each ``thin``."""
    every = quiet_sample(table(), chains=2, draws=61, warmup=0, thin=1)
    for warmup, thin in ((0, 3), (7, 1), (5, 4), (60, 1), (1, 60)):
        draws = (61 - warmup) // thin
        some = quiet_sample(table(), chains=2, draws=draws, warmup=warmup, thin=thin)
        kept = slice(warmup + thin - 1, warmup + thin * draws, thin)
        np.testing.assert_array_equal(some.assignments, every.assignments[:, kept])
        np.testing.assert_array_equal(some.log_joint, every.log_joint[:, kept])
        np.testing.assert_array_equal(some.log_likelihood, every.log_likelihood[:, kept])
        assert {trace.shape for trace in some.traces.values()} == {(2, warmup + draws * thin)}
        np.testing.assert_array_equal(some.traces["log_joint"], every.traces["log_joint"][:, : warmup + draws * thin])
        assert (some.n_chains, some.n_draws, some.settings.sweeps) == (2, draws, warmup + draws * thin)


def test_draws_above_the_budget_are_summed_not_held() -> None:
    settings = {"chains": 4, "draws": 300, "warmup": 10, "thin": 1, "seed": 2}
    whole = quiet_sample(table(), **settings)
    summed = quiet_sample(table(), memory_budget=500_000, **settings)
    assert whole.assignments.shape == (4, 300, 30)
    assert summed.assignments is None
    np.testing.assert_array_equal(whole.shares.toarray(), summed.shares.toarray())
    np.testing.assert_array_equal(whole.best_assignment, summed.best_assignment)
    for name in ("offset", "candidate", "count"):
        np.testing.assert_array_equal(getattr(whole.counts, name), getattr(summed.counts, name))
    np.testing.assert_array_equal(whole.log_joint, summed.log_joint)
    assert whole.settings == summed.settings


def test_memory_is_refused_before_it_is_taken() -> None:
    demos = corner_likelihood().demonstrations
    grid = Candidates.grid([0.0, 0.0], [10.0, 10.0], 0.02)
    likelihood = subgoal.action_comparison(demos, grid)
    assert likelihood.is_dense
    tracemalloc.start()
    with pytest.raises(BudgetError, match="memory_budget") as caught:
        subgoal.sample(likelihood, memory_budget=10 * 2**20, chains=1, draws=1, warmup=0, thin=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert caught.value.needed > 16 * 80 * 251_001
    assert peak < 20 * 2**20  # four rows for the checksum, held twice
    assert "dense" not in vars(likelihood)
    with pytest.raises(InputError, match="memory_budget"):
        subgoal.sample(table(), memory_budget=float("nan"))


@pytest.mark.parametrize("name", ["chains", "draws", "thin", "warmup", "seed"])
@pytest.mark.parametrize("bad", [2.5, True, -1, float("nan"), float("inf"), "3", None, [3]])
def test_whole_numbers_are_checked(name: str, bad) -> None:
    with pytest.raises(InputError, match=name):
        subgoal.sample(table(), **{name: bad})


@pytest.mark.parametrize("name", ["chains", "draws", "thin"])
def test_there_is_at_least_one_of_each(name: str) -> None:
    with pytest.raises(InputError, match=f"{name}: found 0"):
        subgoal.sample(table(), **{name: 0})


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan"), float("inf"), "much", None])
def test_concentration_is_checked(bad) -> None:
    with pytest.raises(InputError, match="concentration"):
        subgoal.sample(table(), concentration=bad)


def test_whole_numbers_may_be_written_as_floats() -> None:
    wanted = quiet_sample(table(), **SHORT)
    assert_same_posterior(wanted, quiet_sample(table(), chains=4.0, draws=np.int32(30), warmup=5.0, thin=2.0, seed=3.0))


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_workers_are_checked(workers) -> None:
    with pytest.raises(InputError, match="workers"):
        subgoal.sample(table(), workers=workers)


def test_one_observation_one_candidate_one_sweep() -> None:
    posterior = quiet_sample(LogLikelihood.from_table([[-2.0]]), chains=1, draws=1, warmup=0, thin=1)
    assert posterior.assignments.tolist() == [[[0]]]
    assert posterior.log_joint.tolist() == [[-2.0]]
    assert posterior.shares.toarray().tolist() == [[1.0]]


def interrupted(after: float, **settings):
    """A long run that gets Ctrl-C from a timer."""
    timer = threading.Timer(after, os.kill, (os.getpid(), signal.SIGINT))
    before = signal.getsignal(signal.SIGINT)
    begin = time.monotonic()
    timer.start()
    try:
        posterior = quiet_sample(table(200, 50), **{"draws": 10_000_000, "warmup": 10, "thin": 1, **settings})
    finally:
        timer.cancel()
        timer.join()
    assert signal.getsignal(signal.SIGINT) is before
    assert time.monotonic() - begin < after + 5
    return posterior


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_gives_the_draws_so_far(workers: int) -> None:
    posterior = interrupted(1.0, chains=4, workers=workers, thin=100, draws=100_000)
    made = posterior.n_draws
    assert posterior.status in (Status.INTERRUPTED, Status.CONVERGED)
    assert 0 < made < posterior.settings.draws
    assert posterior.assignments.shape == (4, made, 200)
    sweeps = posterior.traces["n_active"].shape[1]
    assert made == (sweeps - 10) // 100
    whole = quiet_sample(table(200, 50), chains=4, draws=made, warmup=10, thin=100)
    np.testing.assert_array_equal(posterior.assignments, whole.assignments)
    np.testing.assert_allclose(posterior.shares.sum(axis=1), 1.0, atol=1e-12)


def test_ctrl_c_in_the_warm_up_says_that_there_are_no_draws() -> None:
    with pytest.raises(SubgoalError, match="warm-up"):
        interrupted(0.5, warmup=10_000_000, draws=1, chains=1, memory_budget=2**40)


def test_not_converging_is_said_not_raised() -> None:
    with pytest.warns(ConvergenceWarning, match="NOT CONVERGED"):
        posterior = subgoal.sample(table(), **{**SHORT, "draws": 5})
    assert posterior.status is Status.NOT_CONVERGED
    assert quiet_sample(table(), **{**SHORT, "chains": 3}).status is Status.FEW_CHAINS
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        good = subgoal.sample(LogLikelihood.from_table(np.zeros((5, 2))), workers=1, draws=1500, thin=5, warmup=10)
    assert good.status is Status.CONVERGED
    assert all(each.passes for each in good.diagnostics.values())
    assert set(good.diagnostics) == {"log joint", "K", "share 1", "share 2", "share 3"}
