"""What stands at the prompt is one line."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from benchmarks.common import walkers
from subgoal.runtime.errors import InputError


@pytest.mark.filterwarnings("ignore")
def test_records_print_as_one_line() -> None:
    demos = subgoal.Demonstrations.from_arrays(*walkers(50))
    places = subgoal.epsilon_net(demos)
    likelihood = subgoal.action_comparison(demos, places)
    posterior = subgoal.sample(likelihood, draws=10, warmup=5)
    found = subgoal.subgoals(posterior)
    for record in (demos, places, likelihood, posterior, posterior.counts, found, subgoal.segments(posterior, found)):
        assert 15 < len(repr(record)) < 120
        assert "\n" not in repr(record)


@pytest.mark.parametrize(
    "call",
    [
        lambda demos, places: subgoal.action_comparison(places, demos),
        lambda demos, places: subgoal.sample(demos),
        lambda demos, places: subgoal.sample(subgoal.action_comparison(demos, places), sampler="alg4_corrected"),
        lambda demos, places: subgoal.action_comparison(demos, places, controller=lambda s, g: (g - s)[..., :1]),
        lambda demos, places: subgoal.action_comparison(demos, places, confidence=1e10),
        lambda demos, places: subgoal.Candidates(places.points, np.linspace(0, -700, places.n_candidates)),
    ],
)
def test_mistakes_at_the_prompt_are_told(call) -> None:
    demos = subgoal.Demonstrations.from_arrays(*walkers(50))
    with pytest.raises(InputError, match="wanted"):
        call(demos, subgoal.epsilon_net(demos))


def test_records_do_not_change_when_the_callers_array_does() -> None:
    table = np.random.default_rng(0).normal(size=(6, 3))
    likelihood = subgoal.LogLikelihood.from_table(table)
    before = likelihood.rows(0, 6).copy()
    table[:] = np.nan
    np.testing.assert_array_equal(likelihood.rows(0, 6), before)
    states, actions = walkers(5)
    demos = subgoal.Demonstrations.from_arrays(states, actions)
    states[:] = np.nan
    assert np.isfinite(demos.states).all()
