"""Settings in words, read back: every model, prior and law of this library, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from subgoal import models, samplers
from subgoal.irl.as_sampled import as_sampled
from subgoal.posterior.composed import told, words
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError
from tests.posterior.worlds import corner_likelihood, quiet_sample

SHORT = {"chains": 1, "draws": 2, "warmup": 0, "thin": 1}


@cache
def posterior() -> Posterior:
    return quiet_sample(corner_likelihood(2.0), concentration=0.7, sampler=samplers.blocked, **SHORT)


def with_settings(**settings: Any) -> Posterior:
    return replace(posterior(), settings=replace(posterior().settings, **settings))


def test_fixed_numbers_and_a_sampler() -> None:
    used = as_sampled(posterior())
    assert used.likelihood is posterior().likelihood
    assert used.arguments == {
        "concentration": 0.7, "confidence": None, "model": None, "sampler": samplers.blocked
    }  # fmt: skip


@pytest.mark.parametrize(
    "model",
    [
        models.Persistent(), models.Persistent(0.5, models.Beta(2.0, 3.5)), models.Grouped([0, 1, 0]),
        models.Grouped([0], models.Gamma(2.0, 0.25)), models.StickyHMM(),
    ],
    ids=repr,
)  # fmt: skip
def test_models(model: Any) -> None:
    used = as_sampled(with_settings(model=words(model), sampler=model.__name__))
    assert used.model == model
    assert used.sampler is samplers.collapsed_blocks


@pytest.mark.parametrize("prior", [models.Gamma(), models.Gamma(np.float64(0.3), 1e-7)], ids=repr)
def test_prior_of_the_concentration(prior: Any) -> None:
    assert as_sampled(with_settings(concentration=told(prior))).concentration == prior


@pytest.mark.parametrize(
    "law", [models.NoiseLevels(), models.OneConfidence(models.LogNormal(2.0, 0.5)), models.OwnConfidence()], ids=repr
)
def test_laws_of_confidence(law: Any) -> None:
    assert as_sampled(with_settings(confidence=told(law))).confidence == law


@pytest.mark.parametrize("fixed", ["levels, checksum 12ab", "7 numbers, checksum 12ab", 3.0])
def test_a_confidence_that_was_not_learned_stays_with_the_table(fixed: Any) -> None:
    assert as_sampled(with_settings(confidence=fixed)).confidence is None


@pytest.mark.parametrize(
    "text",
    [
        "Mine(a=1)", "Persistent(", "__import__('os').getcwd()", "Persistent(keep=open('/etc/passwd'))",
        "Persistent(kept=1.0)", "<Mine object at 0x7f>", "Persistent(*[0.5])", "(" * 3000, "models.Persistent()",
    ],
    ids=lambda text: text[:20],
)  # fmt: skip
def test_other_words_are_refused_and_never_run(text: str) -> None:
    with pytest.raises(InputError, match="model"):
        as_sampled(with_settings(model=text))


def test_a_model_or_sampler_of_ones_own_is_given() -> None:
    mine = models.Persistent(0.25)
    assert as_sampled(with_settings(model="Mine(a=1)"), mine).model is mine
    with pytest.raises(InputError, match="sampler: found mine"):
        as_sampled(with_settings(sampler="mine"))
    used = as_sampled(with_settings(sampler="mine"), samplers.collapsed)
    assert (used.model, used.sampler) == (None, samplers.collapsed)


def test_a_lost_likelihood_is_refused() -> None:
    with pytest.raises(InputError, match="no likelihood"):
        as_sampled(replace(posterior(), likelihood=None))
