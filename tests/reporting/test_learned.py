"""What the page says of learned numbers and of what each observation counts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from subgoal import models
from subgoal.answers.evidence import Evidence
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.learned import (
    counting_section,
    counting_words,
    in_time,
    learned_numbers,
    learned_section,
    weight_numbers,
    weight_told,
)
from tests.answers.made import posterior_of
from tests.posterior.worlds import corner_likelihood, quiet_sample
from tests.reporting.made import PLACES, cells, changing


@cache
def learned() -> Posterior:
    table = corner_likelihood(2.0).weighted(0.5)
    noise = models.NoiseLevels((0.25, 4.0))
    model = models.Persistent(keep_there=models.Beta())
    return quiet_sample(
        table, model=model, concentration=models.Gamma(), confidence=noise, chains=2, draws=40, warmup=20, thin=1
    )


def test_learned_numbers_with_their_intervals() -> None:
    made = replace(learned(), parameters=dict(learned().parameters) | {"odd <b>": np.full((2, 40), 2.0)})
    html = learned_section(made)
    kept = made.parameters["persistence"]
    row = cells(html, "Number").index("Persistence ρ")
    low, high = np.quantile(kept, [0.05, 0.95])
    assert cells(html, "Mean")[row] == f"{kept.mean():.3g}"
    assert cells(html, "90 % of the draws")[row] == f"{low:.3g} – {high:.3g}"
    steps = 1 / (1 - kept).mean()
    assert f"every {steps:.0f} observations ({0.25 * steps:.3g} s) on average" in cells(html, "What it is")[row]
    names = cells(html, "Number")
    assert {"Concentration η", "Persistence on arrival", "odd &lt;b&gt;"} < set(names)
    levels = made.parameters["noise levels"].reshape(-1, 2)
    unit = made.likelihood.source.unit
    for m, alpha in enumerate((0.25 * unit, 4.0 * unit)):
        row = names.index(f"Actions of α = {alpha:g}")
        low, high = 100 * np.quantile(levels[:, m], [0.05, 0.95])
        assert cells(html, "90 % of the draws")[row] == f"{low:.0f} – {high:.0f} %"


def test_a_level_is_told_as_the_angle_within_which_half_of_its_actions_are() -> None:
    """In the plane p(φ) ∝ exp(−α·2·sin(φ/2)) for directions φ away; by quadrature."""
    html = learned_section(learned())
    said = [cell for cell in cells(html, "What it is") if "half of them" in cell]
    unit = learned().likelihood.source.unit
    phi = np.linspace(0, np.pi, 200_001)
    for alpha, told in zip((0.25 * unit, 4.0 * unit), said, strict=True):
        mass = np.cumsum(np.exp(-alpha * 2 * np.sin(phi / 2)))
        half = np.degrees(phi[np.searchsorted(mass, 0.5 * mass[-1])])
        assert f"within {half:.2g}° " in told
        assert ("all but free" in told) == (half > 60)


def test_numbers_of_every_candidate_are_not_listed() -> None:
    made = replace(learned(), parameters={"confidence of each candidate": np.ones((2, 40, 9))})
    assert learned_section(made) == ""


@pytest.mark.parametrize(
    ("weight", "time", "fine", "words"),
    [
        (1.0, 1.1, True, "not correlated, so every observation counts in full."),
        (1.0, 3.0, False, "Every observation counts in full."),
        (0.5, 2.1, True, "2.0 observations (0.5 s) in a row say as much as one independent observation: each counts as "
         "0.50, and 80 observations as 40. The errors that are left agree with that."),
        (0.5, 1.0, True, "each counts as 0.50, and 80 observations as 40."),
        (0.5, 2.6, False, "each counts as 0.50, and 80 observations as 40."),
    ],
)  # fmt: skip
def test_how_serial_correlation_is_accounted_for(weight: float, time: float, fine: bool, words: str) -> None:
    found = Evidence(np.ones(1), time, 1 / time)
    told, enough = counting_words(learned(), np.full(80, weight), found)
    assert told.endswith(words)
    assert enough is fine


def test_weights_that_differ() -> None:
    told, fine = counting_words(learned(), np.linspace(0.5, 1, 80), Evidence(np.ones(1), 1.0, 1.0))
    assert told == "Weights differ: 80 observations count as 60 independent ones."
    assert fine


def test_weight_and_correlation_are_in_the_section_and_too_little_is_told_in_red(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("subgoal.reporting.learned.evidence", lambda posterior: Evidence(np.ones(3), 6.0, 1 / 6))
    html = counting_section(learned())
    assert cells(html, "How much") == ["80", "0.5", "40", "6.0 observations (1.5 s)"]
    assert '<p class="fail">Errors of neighbouring actions are correlated over 6.0 observations' in html
    assert "a weight of 0.17" in html
    monkeypatch.setattr("subgoal.reporting.learned.evidence", lambda posterior: Evidence(np.ones(1), 2.0, 0.5))
    assert 'class="fail"' not in counting_section(learned())


def test_numbers_for_the_summary_are_means_and_intervals_of_the_draws() -> None:
    made, found = learned(), learned_numbers(learned())
    assert set(found) == {"concentration", "persistence", "persistence_at_the_subgoal", "noise_levels"}
    kept = made.parameters["persistence"]
    assert found["persistence"]["mean"] == pytest.approx(kept.mean())
    assert found["persistence"]["interval_95"] == pytest.approx(np.quantile(kept, [0.025, 0.975]))
    levels, unit = made.parameters["noise levels"], made.likelihood.source.unit
    assert [level["confidence"] for level in found["noise_levels"]] == [0.25 * unit, 4.0 * unit]
    assert found["noise_levels"][1]["mean"] == pytest.approx(levels[..., 1].mean())
    assert found["noise_levels"][1]["interval_95"] == pytest.approx(np.quantile(levels[..., 1], [0.025, 0.975]))
    assert learned_numbers(replace(made, parameters={"of each candidate": np.ones((2, 40, 9))})) == {}


def test_weights_for_the_summary() -> None:
    assert weight_numbers(learned()) == {
        "mean": 0.5, "least": 0.5, "most": 0.5, "observations_count_as": 40.0, "settled": None
    }  # fmt: skip
    table = learned().likelihood
    uneven = replace(learned(), likelihood=table.weighted(np.linspace(0.25, 1.0, 80)), weight_settled=False)
    told = weight_numbers(uneven)
    assert (told["least"], told["most"], told["settled"]) == (0.25, 1.0, False)
    assert weight_numbers(replace(learned(), likelihood=replace(table, weight=None)))["observations_count_as"] == 80
    assert weight_numbers(replace(learned(), likelihood=None)) is None


def test_a_weight_that_has_not_settled_is_told() -> None:
    assert weight_told(learned()) == ""
    assert (
        weight_told(replace(learned(), weight_settled=True)) == "each observation counts as 0.5 of an independent one"
    )
    loose = replace(learned(), weight_settled=False)
    assert "WARNING: what an observation is worth has not settled in 8 rounds" in weight_told(loose)
    assert '<p class="fail">What an observation is worth has not settled' in counting_section(loose)
    assert "settled" not in counting_section(learned())


def test_time_of_observations() -> None:
    assert in_time(learned(), 4.0) == "4 observations (1 s)"
    assert in_time(learned(), 1.0) == "1 observation (0.25 s)"
    assert in_time(changing(), 2.0, 1) == "2.0 observations (2 s)"
    bare = replace(changing(), demonstrations=replace(changing().demonstrations, times=None))
    assert in_time(bare, 2.0) == "2 observations"
    apart = posterior_of(np.zeros((1, 4), int), PLACES, offset=[0, 2, 3, 4], times=np.array([0.0, 1, 10, 20]))
    assert in_time(apart, 3.0) == "3 observations (3 s)"
