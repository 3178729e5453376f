"""Models at the door of ``sample``: those that need trajectories are refused where there are none."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.table import LogLikelihood
from subgoal.models import Beta, Grouped, NoiseLevels, Persistent, StickyHMM
from subgoal.runtime.errors import InputError
from tests.posterior.worlds import quiet_sample

SHORT = {"chains": 1, "draws": 2, "warmup": 0, "thin": 1}


def steps(offset: list[int]) -> LogLikelihood:
    """A table of plain numbers, cut into trajectories."""
    count = offset[-1]
    demos = Demonstrations.from_arrays(np.arange(float(count)), np.zeros(count), offset)
    return LogLikelihood.from_table(np.random.default_rng(0).normal(size=(count, 3)), demonstrations=demos)


@pytest.mark.parametrize("model", [Persistent(), Persistent(0.5), Persistent(keep_there=Beta()), StickyHMM()], ids=repr)
def test_models_of_time_refuse_trajectories_of_one_step_each(model) -> None:
    with pytest.raises(InputError, match=r"one observation in each of 3 trajectories.*trajectory=.*exchangeable"):
        quiet_sample(steps([0, 1, 2, 3]), model=model, **SHORT)


@pytest.mark.parametrize("model", [Persistent(), StickyHMM()], ids=repr)
def test_one_trajectory_of_two_steps_is_enough(model) -> None:
    assert quiet_sample(steps([0, 1, 2, 4, 5]), model=model, **SHORT).n_draws == 2


@pytest.mark.parametrize("model", [None, Grouped([0, 1, 1])], ids=repr)
def test_models_without_time_take_single_steps(model) -> None:
    assert quiet_sample(steps([0, 1, 2, 3]), model=model, **SHORT).n_draws == 2


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"model": Persistent}, r"model: found the class Persistent.*Try: subgoal\.models\.Persistent\(\)\."),
        ({"model": Grouped}, r"the class Grouped.*Try: subgoal\.models\.Grouped\(demonstrations\.group\)"),
        ({"model": "persistent"}, r"model: found 'persistent'.*Try: subgoal\.models\.Persistent\(\)\."),
        ({"model": "sticky_hmm"}, r"Try: subgoal\.models\.StickyHMM\(\)"),
        ({"model": 3}, r"model: found 3, wanted a function, such as subgoal\.models\.Persistent\(\)\.$"),
        ({"confidence": NoiseLevels}, r"confidence: found <class.*wanted OneConfidence\(\)"),
    ],
)
def test_what_is_no_model_is_refused_with_one_that_is(given, told: str) -> None:
    with pytest.raises(InputError, match=told):
        quiet_sample(steps([0, 4]), **given, **SHORT)


def test_the_noise_of_a_plain_table_cannot_be_learned() -> None:
    with pytest.raises(InputError, match="confidence: found a plain table"):
        quiet_sample(steps([0, 4]), confidence=NoiseLevels(), **SHORT)
