"""Models at the door of ``sample``: those that need trajectories are refused where there are none."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.table import LogLikelihood
from subgoal.models import Beta, Grouped, Persistent, StickyHMM
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
