"""Sampling shards: the same draws however divided, stopped or resumed, and the posterior of ``sample``."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError, StorageError
from subgoal.runtime.progress import Silent
from subgoal.sharded import ShardedPosterior, Shards, load, open_shards, sample_shards, save, write_shards
from subgoal.storage.shards import BLOCK
from tests.oracles.finite_mixture import distinct_law
from tests.oracles.tables import assignment_posterior
from tests.posterior.worlds import corner_likelihood, quiet_sample, table

ARRAYS = ("log_joint", "log_likelihood")


def quiet(shards: Shards, **settings: Any) -> ShardedPosterior:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return sample_shards(shards, **{"workers": 1, **settings})


def assert_same(one: ShardedPosterior, two: ShardedPosterior) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    for name in ("offset", "candidate", "count"):
        np.testing.assert_array_equal(getattr(one.counts, name), getattr(two.counts, name))
    for name, trace in one.traces.items():
        np.testing.assert_array_equal(trace, two.traces[name])
    assert one.diagnostics == two.diagnostics
    assert one.settings == two.settings


RUN: dict[str, Any] = {"draws": 3, "warmup": 1, "chains": 2, "seed": 5}


@pytest.fixture(scope="module")
def divided(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Shards]:
    """One table of seven blocks in 1, 3 and 7 files."""
    place = tmp_path_factory.mktemp("divided")
    likelihood = LogLikelihood.from_table(np.random.default_rng(0).normal(scale=2, size=(6 * BLOCK + 99, 3)))
    rows = {1: 8 * BLOCK, 3: 3 * BLOCK, 7: BLOCK}
    found = {files: write_shards(likelihood, place / str(files), rows=each) for files, each in rows.items()}
    assert {files: len(each.files.files) for files, each in found.items()} == {1: 1, 3: 3, 7: 7}
    return found


@pytest.mark.parametrize(("files", "workers", "backend"), [
    (3, 1, "threading"), (7, 1, "threading"), (1, 2, "threading"), (3, 2, "threading"), (7, 2, "loky"), (1, 2, "loky"),
])  # fmt: skip
def test_the_division_into_files_and_the_workers_have_no_say(
    divided: dict[int, Shards], files: int, workers: int, backend: str
) -> None:
    assert_same(quiet(divided[1], **RUN), quiet(divided[files], workers=workers, backend=backend, **RUN))


def test_chain_k_of_two_is_chain_k_of_four(divided: dict[int, Shards]) -> None:
    two, four = quiet(divided[1], **RUN), quiet(divided[1], **{**RUN, "chains": 4})
    np.testing.assert_array_equal(two.log_joint, four.log_joint[:2])
    assert len(set(four.log_joint[:, -1].tolist())) == 4
    other = quiet(divided[1], **{**RUN, "seed": 6})
    assert not (other.log_joint == two.log_joint).any()


def test_global_random_state_is_left_alone(tmp_path: Path) -> None:
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    quiet(write_shards(table(), tmp_path / "s"), draws=3, warmup=0)
    np.testing.assert_array_equal(before, np.random.get_state()[1])  # noqa: NPY002


def test_the_posterior_of_the_counts_is_the_enumerated_one(tmp_path: Path) -> None:
    """N = 5, G = 3; total variation of the counts, at most 3 times that of as many independent draws as 1 in 4."""
    values, prior, eta = np.random.default_rng(4).normal(scale=1.5, size=(5, 3)), np.array([0.5, 0.3, 0.2]), 0.7
    values[1, 0] = -np.inf
    candidates = Candidates(np.arange(3.0)[:, None], np.log(prior))
    shards = write_shards(LogLikelihood.from_table(values, candidates=candidates), tmp_path / "s")
    found = quiet(shards, concentration=eta, chains=4, draws=5000, warmup=100, seed=1)
    law: dict[tuple[int, ...], float] = {}
    fit = 0.0
    for theta, p in assignment_posterior(values, eta, prior).items():
        key = tuple(np.bincount(theta, minlength=3).tolist())
        law[key] = law.get(key, 0.0) + p
        fit += p * float(values[range(5), theta].sum()) if p > 0 else 0.0
    seen = [tuple(row) for row in found.counts.by_group(np.arange(3), 3).tolist()]
    share = {key: seen.count(key) / len(seen) for key in law}
    assert sum(share.values()) == pytest.approx(1)
    variation = 0.5 * sum(abs(share[key] - p) for key, p in law.items())
    draws = np.random.default_rng(0).multinomial(len(seen) // 4, list(law.values()), size=200) / (len(seen) // 4)
    assert variation <= 3 * np.mean(0.5 * np.abs(draws - list(law.values())).sum(axis=1))
    assert found.log_likelihood.mean() == pytest.approx(fit, abs=6 * found.log_likelihood.std() / 5000**0.5)


def test_no_impossible_assignment_is_ever_drawn(tmp_path: Path) -> None:
    """Every observation allows one candidate alone, and a concentration that makes opening one all but impossible."""
    values = np.full((40, 4), -np.inf)
    values[np.arange(40), np.arange(40) % 4] = np.arange(40.0)
    shards = write_shards(LogLikelihood.from_table(values), tmp_path / "s")
    found = quiet(shards, concentration=1e-6, draws=20, warmup=0)
    np.testing.assert_array_equal(found.expected_size, [10, 10, 10, 10])
    np.testing.assert_allclose(found.log_likelihood, 780, atol=1e-6)
    assert np.isfinite(found.log_joint).all()


def test_weights_below_every_number_are_told_and_not_drawn(tmp_path: Path) -> None:
    values = np.where(np.eye(2) > 0, 0.0, -np.inf)
    shards = write_shards(LogLikelihood.from_table(values), tmp_path / "s")
    with pytest.raises(InputError, match="concentration"):
        quiet(shards, concentration=1e-323, draws=2, warmup=0)


def test_a_tiny_concentration_gives_one_subgoal(tmp_path: Path) -> None:
    """As it must where the gain of a second, some nats, is far below its price log 1/η."""
    shards = write_shards(LogLikelihood.from_table(np.random.default_rng(2).normal(size=(200, 5))), tmp_path / "s")
    found = quiet(shards, concentration=1e-250, draws=30, warmup=10)
    assert (found.n_active == 1).all()


@pytest.mark.parametrize("kind", ["stored", "directions"])
def test_shards_give_the_posterior_of_sample(kind: str, tmp_path: Path) -> None:
    """Within 5 standard errors, by the effective sizes that both report; the same gate."""
    likelihood = corner_likelihood(radius=4.0)
    run: dict[str, Any] = {"draws": 4000, "warmup": 500, "thin": 1, "concentration": 2.0}
    one = quiet_sample(likelihood, sampler=subgoal.samplers.blocked, **run)
    two = quiet(write_shards(likelihood, tmp_path / "s", kind=kind), **run)
    for name in ARRAYS:
        a, b = getattr(one, name), getattr(two, name)
        size = min(one.diagnostics["log joint"].ess_bulk, two.diagnostics["log joint"].ess_bulk)
        assert abs(a.mean() - b.mean()) <= 5 * np.hypot(a.std(), b.std()) / np.sqrt(size), name
    sizes = two.counts.largest(2)[:, 0].mean() - one.counts.largest(2)[:, 0].mean()
    size = min(one.diagnostics["share 1"].ess_bulk, two.diagnostics["share 1"].ess_bulk)
    assert abs(sizes) <= 5 * np.sqrt(2) * one.counts.largest(2)[:, 0].std() / np.sqrt(size)
    assert one.diagnostics.keys() == two.diagnostics.keys()


def test_without_evidence_the_posterior_is_the_prior(tmp_path: Path) -> None:
    """Flat rows of −3: P(K) of the mixture, and Σ ℓ complete to the unit of each."""
    candidates = Candidates(np.arange(3.0)[:, None], np.log([0.5, 0.3, 0.2]))
    shards = write_shards(LogLikelihood.from_table(np.full((12, 3), -3.0), candidates=candidates), tmp_path / "s")
    found = quiet(shards, concentration=1.3, draws=8000, warmup=100, seed=3)
    np.testing.assert_allclose(found.log_likelihood, -36, atol=1e-7)
    size = found.diagnostics["K"].ess_bulk
    for k, p in enumerate(distinct_law(12, 1.3, [0.5, 0.3, 0.2])):
        assert abs((found.n_active == k).mean() - p) <= 5 * np.sqrt(p * (1 - p) / size) + 1e-12


def test_a_background_is_the_last_column_and_no_place(tmp_path: Path) -> None:
    likelihood = corner_likelihood(radius=4.0).with_background(0.3)
    found = quiet(write_shards(likelihood, tmp_path / "s"), draws=400, warmup=100)
    assert found.expected_size.size == likelihood.candidates.n_candidates
    assert 0 < found.expected_size.sum() < likelihood.n_observations
    assert "background" in found.diagnostics


def test_what_is_said_of_places_is_what_the_draws_say(tmp_path: Path) -> None:
    likelihood = corner_likelihood(radius=4.0)
    found = quiet(write_shards(likelihood, tmp_path / "s"), draws=60, warmup=5, thin=2)
    each = found.counts.by_group(np.arange(found.candidates.n_candidates), found.candidates.n_candidates)
    assert each.sum(axis=1).tolist() == [80] * 240
    np.testing.assert_allclose(found.inclusion(), (each >= 1).mean(axis=0))
    np.testing.assert_allclose(found.inclusion(5), (each >= 5).mean(axis=0))
    np.testing.assert_allclose(found.expected_size, each.mean(axis=0))
    np.testing.assert_array_equal(found.n_active.ravel(), (each > 0).sum(axis=1))
    first = found.places()[0]
    assert first.candidate == each.mean(axis=0).argmax()
    assert first.position == tuple(found.candidates.points[first.candidate])
    assert found.places(1.1) == []
    np.testing.assert_allclose(found.traces["loss"][:, 6::2], -found.log_likelihood / 80)


def test_the_gate_is_that_of_every_posterior(tmp_path: Path) -> None:
    shards = write_shards(table(), tmp_path / "s")
    with pytest.warns(subgoal.posterior.sample.ConvergenceWarning):
        short = sample_shards(shards, draws=10, warmup=0, workers=1)
    assert short.status.name == "NOT_CONVERGED"
    assert quiet(shards, draws=3000, warmup=500, thin=5).status.name == "CONVERGED"
    assert quiet(shards, draws=10, chains=2).status.name == "FEW_CHAINS"


def test_saved_and_loaded_is_the_same(tmp_path: Path) -> None:
    found = quiet(write_shards(table(), tmp_path / "s"), draws=20, warmup=3)
    again = load(save(found, tmp_path / "p.npz"))
    assert_same(found, again)
    np.testing.assert_array_equal(found.candidates.points, again.candidates.points)
    np.testing.assert_array_equal(found.candidates.log_prior, again.candidates.log_prior)
    assert (again.status, again.n_observations, again.seconds) == (found.status, 30, found.seconds)
    (tmp_path / "p.npz").write_bytes((tmp_path / "p.npz").read_bytes()[:-300])
    with pytest.raises(StorageError, match="torn"):
        load(tmp_path / "p.npz")


def test_a_file_that_changes_under_a_run_is_told(tmp_path: Path) -> None:
    shards = write_shards(table(), tmp_path / "s")
    path = tmp_path / "s" / "shard-00000.parquet"

    class Tears(Silent):
        def update(self, done: int, total: int, note: str = "") -> None:
            path.write_bytes(path.read_bytes()[:100])

    with pytest.raises(StorageError, match=r"shard-00000\.parquet"):
        quiet(shards, progress=Tears(), draws=5, warmup=0)


def test_a_file_that_changed_is_told_from_worker_processes(tmp_path: Path) -> None:
    shards = write_shards(table(), tmp_path / "s")
    (tmp_path / "s" / "shard-00000.parquet").write_bytes(b"PAR1")
    with pytest.raises(StorageError, match=r"shard-00000\.parquet"):
        quiet(shards, draws=5, warmup=0, workers=2, backend="loky")


@pytest.mark.parametrize("setting", [
    {"concentration": 0}, {"concentration": float("nan")}, {"chains": 0}, {"draws": 1.5}, {"warmup": -1},
    {"seed": -1}, {"backend": "ray"}, {"client": 3}, {"resume": True},
])  # fmt: skip
def test_settings_out_of_range_are_refused_by_name(setting: dict[str, Any], tmp_path: Path) -> None:
    shards = write_shards(table(), tmp_path / "s")
    with pytest.raises(InputError, match=next(iter(setting))):
        quiet(shards, **{"draws": 2, "warmup": 0, **setting})


def test_only_shards_are_sampled() -> None:
    with pytest.raises(InputError, match="open_shards"):
        sample_shards(table())  # type: ignore[arg-type]


def test_memory_does_not_grow_with_the_rows(tmp_path: Path) -> None:
    """Arrays made by Python while 12 blocks are gone through stay below two groups of rows."""
    import tracemalloc

    generator = np.random.default_rng(0)
    with subgoal.sharded.DirectionWriter(tmp_path / "s", Candidates(generator.uniform(0, 9, (5, 2)))) as writer:
        for _ in range(12):
            writer.append(generator.uniform(0, 9, (BLOCK, 2)), generator.normal(size=(BLOCK, 2)))
    shards = open_shards(tmp_path / "s")
    quiet(shards, draws=1, warmup=0, chains=1)
    tracemalloc.start()
    quiet(shards, draws=1, warmup=0, chains=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * 32 * BLOCK < 12 * 32 * BLOCK
