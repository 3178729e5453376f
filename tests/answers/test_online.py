"""The filter that is told one step at a time, against the filter of whole recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp

import subgoal
from subgoal.answers.filtering import filtering
from subgoal.answers.online import OnlineFilter
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import planned_actions
from subgoal.likelihood.again import same_likelihood
from subgoal.mdp.tabular import TabularMDP
from subgoal.models import Beta, Gamma, Grouped, NoiseLevels, OwnConfidence, Persistent, StickyHMM
from subgoal.posterior.laws import draw_laws
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import BudgetError, InputError
from tests.answers.test_filtering import GOALS, held_out, posterior_of, three_goals
from tests.likelihood.test_planned_actions import walks
from tests.mdp.small_worlds import world
from tests.posterior.worlds import quiet_sample, table

MODELS = [None, Persistent(), Persistent(keep_there=Beta(1.0, 2.0)), StickyHMM()]


def in_a_world(seed: int, n: int = 30) -> tuple[TabularMDP, Demonstrations]:
    """A small world with illegal actions and a terminal state, and two trajectories of pairs in it."""
    mdp, _ = world(3, 0.9, n_states=9, illegal=True, terminal=1)
    return mdp, replace(
        walks(mdp, seed, n), offset=np.array([0, n // 3, n]), trajectory_names=(), final_states=None, truncated=None
    )


def recording() -> Demonstrations:
    """Three trajectories; the first begins with no motion at all, the second has a slow step."""
    states, actions = np.vstack([held_out().states] * 2), np.vstack([held_out().actions] * 2)
    actions[0], actions[5] = 0.0, [1e-3, 0.0]
    return Demonstrations.from_arrays(states, actions, [0, 4, 6, 12])


def assert_steps_are_the_filter(posterior: Posterior, demonstrations: Demonstrations, **settings) -> None:
    whole = filtering(posterior, demonstrations, **settings)
    live = OnlineFilter.start(posterior, **settings)
    starts = set(demonstrations.offset[:-1].tolist())
    for i, (state, action) in enumerate(zip(demonstrations.states, demonstrations.actions, strict=True)):
        if i in starts:
            live.restart()
        now = live.step(state, action)
        np.testing.assert_allclose(now, whole.probability[i], rtol=0, atol=1e-12)
        assert live.probability is now
        assert live.log_predictive == pytest.approx(whole.log_predictive[i], rel=0, abs=1e-12)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("confidence", [None, NoiseLevels((0.5, 2.0, 8.0)), OwnConfidence()])
@pytest.mark.parametrize("background", [0.0, 0.3])
def test_steps_say_what_the_whole_recording_says(model, confidence, background: float) -> None:
    likelihood = three_goals().with_background(background)
    posterior = posterior_of(model, likelihood, confidence=confidence, concentration=Gamma())
    assert_steps_are_the_filter(posterior, recording(), draws=10, seed=4)


@pytest.mark.parametrize("compare", ["action", "direction"])
@pytest.mark.parametrize("model", MODELS[1:])
def test_with_a_controller(compare: str, model) -> None:
    demos, places = three_goals().demonstrations, subgoal.Candidates(GOALS, radius=4.0)
    likelihood = subgoal.action_comparison(demos, places, controller=lambda s, g: 0.1 * (g - s), compare=compare)
    assert_steps_are_the_filter(posterior_of(model, likelihood), recording())


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("convention", ["continuing", "absorbing"])
def test_with_planned_actions(model, convention: str) -> None:
    mdp, demos = in_a_world(0, 6)
    likelihood = subgoal.planned_actions(
        demos, subgoal.visited(demos), mdp, confidence=3.0, convention=convention
    ).with_background(0.1)
    assert_steps_are_the_filter(posterior_of(model, likelihood), in_a_world(1)[1])


def test_a_restart_forgets() -> None:
    posterior = posterior_of(Persistent())
    live, fresh = OnlineFilter.start(posterior), OnlineFilter.start(posterior)
    assert live.probability is None
    assert np.isnan(live.log_predictive)
    live.step([4.0, 0.5], [1.0, 0.0])
    live.restart()
    assert live.probability is None
    assert np.isnan(live.log_predictive)
    np.testing.assert_array_equal(live.step([8.0, 0.0], [0.0, 1.0]), fresh.step([8.0, 0.0], [0.0, 1.0]))


def test_slowness_and_speed_are_those_of_the_posterior() -> None:
    """Actions a thousandth as fast are all slow: they say nothing, whatever else the recording has."""
    demos, places = three_goals().demonstrations, subgoal.Candidates(GOALS, radius=4.0)
    faint = Demonstrations.from_arrays(held_out().states, 1e-3 * held_out().actions, [0, 4, 6])
    found = filtering(posterior_of(None), faint)
    np.testing.assert_allclose(found.log_predictive, -np.log(2 * np.pi), rtol=1e-12)
    likelihood = subgoal.action_comparison(demos, places, controller=lambda s, g: 0.1 * (g - s), compare="action")
    posterior = posterior_of(None, likelihood, draws=1, chains=1)
    held, fast = (Demonstrations.from_arrays([[4.0, 0.5]], [action], [0, 1]) for action in ([0.6, 0.0], [1.2, 0.0]))
    weights, pace = draw_laws(posterior, np.array([0]), 0).weights[0], likelihood.source.pace.median
    for each in (held, fast):
        distance = np.linalg.norm(each.actions - 0.1 * (GOALS - each.states), axis=1) / pace
        log_z = np.log(2 * np.pi) + 2 * np.log(pace / 3.0)
        np.testing.assert_allclose(same_likelihood(likelihood, each).dense[0], -3.0 * distance - log_z, rtol=1e-12)
        wanted = logsumexp(-3.0 * distance - log_z + np.log(weights))
        assert filtering(posterior, each, draws=1).log_predictive[0] == pytest.approx(wanted, abs=1e-12)


def test_what_cannot_be_taken_is_refused_and_leaves_the_filter_where_it_was() -> None:
    posterior = posterior_of(Persistent())
    live, other = OnlineFilter.start(posterior), OnlineFilter.start(posterior)
    for each in (live, other):
        each.step([4.0, 0.5], [1.0, 0.0])
    for state, action in (([4.0], [1.0, 0.0]), ([4.0, 0.5], [np.nan, 0.0]), ([4.0, 0.5, 1.0], [1.0, 0.0, 0.0])):
        with pytest.raises(InputError):
            live.step(state, action)
    np.testing.assert_array_equal(live.step([8.0, 0.0], [0.0, 1.0]), other.step([8.0, 0.0], [0.0, 1.0]))
    mdp, demos = in_a_world(0)
    planned = OnlineFilter.start(posterior_of(None, subgoal.planned_actions(demos, subgoal.visited(demos), mdp)))
    with pytest.raises(InputError, match="actions"):
        planned.step(0, 99)
    with pytest.raises(InputError, match="states"):
        planned.step(mdp.n_states, 0)


def test_what_cannot_be_started_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="made for other demonstrations"):
        OnlineFilter.start(quiet_sample(table(), chains=1, draws=2, warmup=0, thin=1))
    with pytest.raises(InputError, match="likelihood"):
        OnlineFilter.start(replace(posterior_of(), likelihood=None))
    demos = Demonstrations.from_arrays(recording().states, recording().actions, [0, 4, 6, 12])
    grouped = posterior_of(Grouped([0, 0, 1]), subgoal.action_comparison(demos, subgoal.Candidates(GOALS)))
    with pytest.raises(InputError, match="groups"):
        OnlineFilter.start(grouped)
    mdp, walk = in_a_world(0)
    posterior = posterior_of(None, subgoal.planned_actions(walk, subgoal.visited(walk), mdp))
    monkeypatch.setattr(planned_actions, "LARGEST_PLAN", 10)
    with pytest.raises(BudgetError, match="action values"):
        OnlineFilter.start(posterior)
