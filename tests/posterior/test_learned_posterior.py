"""A posterior of which everything is learned: its parameters, its gate, its files, and the same draws however made."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.models import Beta, Gamma, LogNormal, NoiseLevels, OneConfidence, OwnConfidence, Persistent
from subgoal.posterior import rounds
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.checkpoint import Checkpoint
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.rounds import Rounds
from subgoal.runtime.errors import InputError, StorageError
from tests.posterior.worlds import assert_same_posterior, corner_likelihood, quiet_sample

LENGTH = {"chains": 2, "draws": 24, "warmup": 20, "thin": 2, "seed": 3}
LEVELS = (0.5, 2.0, 8.0)
LEARNED = {
    "concentration": Gamma(2.0, 1.0), "confidence": NoiseLevels(LEVELS), "model": Persistent(keep_there=Beta(1.0, 3.0))
}  # fmt: skip
NAMES = {"concentration", "noise levels", "persistence", "persistence at the subgoal"}


def corners(radius: float = 2.0) -> LogLikelihood:
    """With a background, and each observation worth half of one."""
    return corner_likelihood(radius).with_background(0.15).weighted(0.5)


@cache
def learned() -> Posterior:
    return quiet_sample(corners(), **LEARNED, **LENGTH)


def assert_same_draws(one: Posterior, two: Posterior) -> None:
    """All that ``assert_same_posterior`` compares, parameters and redraws."""
    assert_same_posterior(one, two)
    assert one.parameters.keys() == two.parameters.keys()
    for name, values in one.parameters.items():
        np.testing.assert_array_equal(values, two.parameters[name], err_msg=name)
    assert (one.redraws is None) == (two.redraws is None)
    if one.redraws is not None:
        for name in ("offset", "candidate", "count"):
            np.testing.assert_array_equal(getattr(one.redraws, name), getattr(two.redraws, name), err_msg=name)


def test_what_was_learned_has_a_value_in_every_draw() -> None:
    posterior = learned()
    shapes = {name: values.shape for name, values in posterior.parameters.items()}
    assert shapes.pop("noise levels") == (2, 24, 3)
    assert shapes == dict.fromkeys(NAMES - {"noise levels"}, (2, 24))
    np.testing.assert_allclose(posterior.parameters["noise levels"].sum(axis=2), 1, atol=1e-12)
    assert (posterior.parameters["concentration"] > 0).all()
    for name in ("persistence", "persistence at the subgoal"):
        assert ((posterior.parameters[name] > 0) & (posterior.parameters[name] < 1)).all()
    assert np.unique(posterior.parameters["persistence"]).size > 40
    assert posterior.concentration == pytest.approx(posterior.parameters["concentration"].mean())


def test_the_gate_looks_at_what_was_learned() -> None:
    posterior = learned()
    assert NAMES - {"noise levels"} | {"background", "log joint", "K"} <= set(posterior.diagnostics)
    plain = quiet_sample(corner_likelihood(2.0), **LENGTH)
    assert not (NAMES | {"background"}) & set(plain.diagnostics)
    assert plain.redraws is None
    assert plain.parameters == {}


def test_background_is_minus_one_and_what_the_shares_lack() -> None:
    posterior = learned()
    theta = posterior.assignments
    assert theta.min() == -1
    assert theta.max() < posterior.candidates.n_candidates
    assert posterior.shares.shape == (posterior.n_observations, posterior.candidates.n_candidates)
    np.testing.assert_allclose(posterior.background, (theta < 0).mean(axis=(0, 1)), atol=1e-12)
    total = np.asarray(posterior.shares.sum(axis=1)).ravel() + posterior.background
    np.testing.assert_allclose(total, 1, atol=1e-12)
    served = (theta >= 0).sum(axis=2).ravel()
    counted = np.add.reduceat(posterior.counts.count, posterior.counts.offset[:-1])
    np.testing.assert_array_equal(counted, served)
    flat = theta.reshape(-1, theta.shape[2])
    row = posterior.counts.by_group(np.arange(posterior.candidates.n_candidates), posterior.candidates.n_candidates)
    np.testing.assert_array_equal(row[7], np.bincount(flat[7][flat[7] >= 0], minlength=row.shape[1]))


def test_redraws_are_as_many_as_runs_at_least() -> None:
    """Each change of subgoal is a redraw, the first step of the trajectory too; every redraw is an observation."""
    posterior = learned()
    theta = posterior.assignments.reshape(-1, posterior.n_observations)
    drawn = np.add.reduceat(posterior.redraws.count, posterior.redraws.offset[:-1])
    assert (drawn >= 1 + (np.diff(theta, axis=1) != 0).sum(axis=1)).all()
    assert (drawn <= posterior.n_observations).all()
    assert (drawn < posterior.n_observations).any()
    assert posterior.redraws.candidate.max() <= posterior.candidates.n_candidates


def test_the_likelihood_is_at_the_mean_of_the_noise() -> None:
    posterior = learned()
    law = posterior.likelihood.confidence
    assert isinstance(law, Levels)
    np.testing.assert_array_equal(law.confidences, LEVELS)
    np.testing.assert_allclose(law.shares, posterior.parameters["noise levels"].mean(axis=(0, 1)))
    assert posterior.likelihood.background == 0.15
    assert (posterior.likelihood.weight == 0.5).all()
    theta = np.where(posterior.assignments < 0, posterior.candidates.n_candidates, posterior.assignments)[1, 3]
    shares = posterior.parameters["noise levels"][1, 3]
    at_draw = corners().at(Levels(np.array(LEVELS), shares))
    fit = at_draw.dense[np.arange(theta.size), theta].sum()
    assert posterior.log_likelihood[1, 3] == pytest.approx(fit, abs=1e-9)


@pytest.mark.parametrize("confidence", [NoiseLevels(LEVELS), OneConfidence(LogNormal(2.0, 0.5)), OwnConfidence()])
@pytest.mark.parametrize("model", [None, Persistent()])
def test_a_file_gives_all_of_it_back(confidence, model, tmp_path: Path) -> None:
    posterior = quiet_sample(
        corners(), concentration=Gamma(), confidence=confidence, model=model, **{**LENGTH, "draws": 8}
    )
    again = subgoal.load(subgoal.save(posterior, tmp_path / "posterior.npz"))
    assert_same_draws(again, posterior)
    assert repr(again.likelihood.confidence)[:6] == repr(posterior.likelihood.confidence)[:6]
    np.testing.assert_allclose(again.likelihood.dense, posterior.likelihood.dense, rtol=1e-11, atol=1e-11)
    np.testing.assert_array_equal(again.likelihood.log_prior, posterior.likelihood.log_prior)
    np.testing.assert_array_equal(again.likelihood.weight, posterior.likelihood.weight)
    assert again.concentration == posterior.concentration


def test_one_learned_confidence_is_told_by_its_mean() -> None:
    posterior = quiet_sample(corners(), confidence=OneConfidence(), **{**LENGTH, "draws": 8})
    assert posterior.confidence == pytest.approx(posterior.parameters["confidence"].mean())
    assert "confidence" in posterior.diagnostics


def broken_off(likelihood: LogLikelihood, path: Path, sweeps: int, settings) -> None:
    """Write the checkpoint that a run killed after so many sweeps leaves."""
    stopped = {"done": False}
    real = Rounds.advance

    def advance(self: Rounds, records: list[ChainRecord]) -> bool:
        self._length = min(self._length, 3)
        alive = real(self, records)
        if records[0].sweeps >= sweeps and not stopped["done"]:
            stopped["done"] = True
            raise KeyboardInterrupt
        return alive

    def write_always(self: Checkpoint, records: list[ChainRecord]) -> None:
        self.write(records)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Rounds, "advance", advance)
        patch.setattr(Checkpoint, "write_if_due", write_always)
        with pytest.raises(KeyboardInterrupt):
            quiet_sample(likelihood, checkpoint=path, **settings, **LENGTH)


@pytest.mark.parametrize("sweeps", [6, 19, 33])
def test_a_run_broken_off_goes_on_as_if_it_had_not_been(sweeps: int, tmp_path: Path) -> None:
    """In the warm-up, and between kept draws; the round that was cut is lost and made again."""
    path = tmp_path / "run.npz"
    broken_off(corners(), path, sweeps, LEARNED)
    assert path.exists()
    resumed = quiet_sample(corners(), checkpoint=path, resume=True, **LEARNED, **LENGTH)
    assert_same_draws(resumed, learned())
    assert not path.exists()


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("concentration", Gamma(2.0, 1.1)), ("confidence", NoiseLevels((0.5, 2.0, 9.0))), ("model", Persistent()),
    ],
)  # fmt: skip
def test_a_checkpoint_of_other_priors_is_refused(name: str, other, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    broken_off(corners(), path, 6, LEARNED)
    with pytest.raises(StorageError, match="setting"):
        quiet_sample(corners(), checkpoint=path, resume=True, **{**LEARNED, name: other}, **LENGTH)
    for likelihood in (corner_likelihood(2.0).with_background(0.2).weighted(0.5), corners().weighted(0.6)):
        with pytest.raises(StorageError, match="setting"):
            quiet_sample(likelihood, checkpoint=path, resume=True, **LEARNED, **LENGTH)


@pytest.mark.parametrize(("workers", "backend"), [(2, "threading"), (1, "loky"), (2, "loky")])
def test_draws_do_not_depend_on_workers_or_processes(workers: int, backend: str) -> None:
    assert_same_draws(quiet_sample(corners(), workers=workers, backend=backend, **LEARNED, **LENGTH), learned())


@pytest.mark.parametrize("length", [1, 4, 7])
def test_draws_do_not_depend_on_the_length_of_rounds(length: int, monkeypatch) -> None:
    monkeypatch.setattr(rounds, "ROUND_DRAWS", length * corners().n_observations // 2)
    assert_same_draws(quiet_sample(corners(), **LEARNED, **LENGTH), learned())


def test_a_model_has_a_sampler_of_its_own() -> None:
    with pytest.raises(InputError, match="sampler"):
        quiet_sample(corners(), model=Persistent(), sampler=subgoal.samplers.blocked, **LENGTH)
    with pytest.raises(InputError, match="model"):
        quiet_sample(corners(), model="persistent", **LENGTH)
    with pytest.raises(InputError, match="concentration"):
        quiet_sample(corners(), concentration=-1.0, **LENGTH)


def test_settings_say_which_priors_there_were() -> None:
    settings = learned().settings
    assert settings.concentration == "Gamma(shape=2.0, rate=1.0)"
    assert settings.confidence == "NoiseLevels(levels=(0.5, 2.0, 8.0))"
    assert settings.model.startswith("Persistent(")
    assert settings.background == 0.15
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "NoiseLevels" in repr(settings)


@pytest.mark.parametrize("confidence", [NoiseLevels(), OwnConfidence(), OneConfidence()])
def test_it_has_a_mean_confidence_and_a_report(confidence, tmp_path: Path) -> None:
    """Levels by their shares, candidates by theirs; the mean stands in the report."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        posterior = subgoal.sample(
            corners(), model=Persistent(), concentration=Gamma(), confidence=confidence, draws=20, warmup=20, thin=1
        )
        path = tmp_path / "report.html"
        subgoal.report(posterior, path)
        subgoal.write_results(posterior, tmp_path)
    assert f"{posterior.confidence:g}" in path.read_text()
    law = posterior.likelihood.confidence
    if isinstance(law, Levels):
        assert posterior.confidence == pytest.approx(float(np.sum(law.confidences * law.shares)))
    else:
        assert np.min(law) <= posterior.confidence <= np.max(law)
