"""Memory that a run needs is predicted with what its sampler holds beside the table."""

from __future__ import annotations

import pytest

import subgoal
from subgoal.models import NoiseLevels, Persistent, StickyHMM
from subgoal.runtime.errors import BudgetError
from subgoal.samplers import Tempering
from tests.posterior.worlds import corner_likelihood, quiet_sample

SHORT = {"chains": 1, "draws": 2, "warmup": 1, "thin": 1}
N, G = corner_likelihood().n_observations, corner_likelihood().n_candidates
PLAIN = 16.0 * N * G + 8.0 * G * 64


@pytest.mark.parametrize(
    ("settings", "held"),
    [
        ({"sampler": Tempering((1.0, 0.5, 0.2))}, 3 * 16.0 * N * G),
        ({"model": Persistent()}, 16.0 * N * G),
        ({"model": StickyHMM()}, 5 * 8.0 * G**2),
        ({"confidence": NoiseLevels()}, 16.0 * N * G),
        ({"model": StickyHMM(), "confidence": NoiseLevels()}, 5 * 8.0 * G**2 + 16.0 * N * G),
    ],
)
def test_what_a_sampler_holds_is_part_of_the_prediction(settings: dict, held: float) -> None:
    """The budget at which a run is refused is larger by just that."""
    plain, more = least_budget({}), least_budget(settings)
    assert plain >= PLAIN
    assert more - plain == pytest.approx(held, abs=2)


def least_budget(settings: dict) -> float:
    """Predicted bytes, read off the refusal."""
    with pytest.raises(BudgetError) as caught:
        subgoal.sample(corner_likelihood(), memory_budget=1.0, **SHORT, **settings)
    quiet_sample(corner_likelihood(), memory_budget=caught.value.needed * 4, **SHORT, **settings)
    return caught.value.needed
