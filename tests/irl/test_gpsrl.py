"""Several goals of one continuous demonstration."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.continuous import Averager, ContinuousWorld, GaussianSmoother, action_grid
from subgoal.options import option
from subgoal.runtime.errors import InputError, StorageError
from tests.likelihood.point_mass import HIGH, LOW, STEP, plane, push, there_and_back

DEMOS, LABELS, CORNERS = there_and_back()
FAST = {"chains": 4, "warmup": 50, "draws": 100, "thin": 1}
pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")


def corners_found(posterior):
    """Distance of each true corner from the nearest subgoal that serves a tenth of the pairs."""
    used, count = np.unique(posterior.best_assignment, return_counts=True)
    main = posterior.candidates.points[used[count >= 0.1 * DEMOS.n_observations]]
    return len(main), np.linalg.norm(CORNERS[:, None] - main[None], axis=2).min(axis=1)


def test_three_corners_are_three_subgoals_their_number_not_given():
    found = subgoal.gpsrl(DEMOS, plane(), radius=0.3, confidence=40.0, seed=1, **FAST)
    number, apart = corners_found(found)
    assert number == 3
    assert (apart < 0.5).all()
    assert found.settings.model != "exchangeable"


def test_order_may_say_nothing():
    found = subgoal.gpsrl(DEMOS, plane(), radius=0.3, dwell=0, seed=1, chains=4, warmup=75, draws=100, thin=1)
    assert found.settings.sampler == "annealed"
    assert found.settings.confidence == 30.0
    assert (corners_found(found)[1] < 0.5).sum() >= 2


def test_dynamics_alone_are_enough():
    found = subgoal.gpsrl(DEMOS, push, bounds=(LOW, HIGH), seed=0, **FAST)
    world = found.likelihood.source.world
    assert world.step == pytest.approx(STEP)
    assert world.horizon == pytest.approx(5 * STEP)
    ranged = subgoal.gpsrl(DEMOS, push, seed=0, **FAST).likelihood.source.world
    np.testing.assert_array_equal(ranged.low, np.asarray(DEMOS.actions).min(axis=0))


def test_bounds_that_the_dynamics_name_are_taken():
    class Engine:
        bounds = (2 * LOW, 2 * HIGH)

        def __call__(self, states, actions, duration):
            return push(states, actions, duration)

    found = subgoal.gpsrl(DEMOS, Engine(), seed=0, **FAST)
    np.testing.assert_array_equal(found.likelihood.source.world.high, 2 * HIGH)


def test_subgoals_are_kept_for_the_dwell_on_average():
    for dwell in (2.0, 8.0, None):
        found = subgoal.gpsrl(DEMOS, plane(), dwell=dwell, seed=0, **FAST)
        kept = np.asarray(found.parameters["persistence"])
        np.testing.assert_allclose(kept, np.exp(-STEP / (dwell or 20 * STEP)))


def test_the_same_seed_gives_the_same_draws():
    one, two = (subgoal.gpsrl(DEMOS, plane(), seed=3, **FAST) for _ in range(2))
    np.testing.assert_array_equal(one.assignments, two.assignments)


def test_answers_and_report_work(tmp_path):
    found = subgoal.gpsrl(DEMOS, plane(), radius=0.3, confidence=40.0, seed=1, **FAST)
    listed = subgoal.subgoals(found).listed
    cut = subgoal.segments(found)
    assert len(listed) >= 3
    assert len(cut) >= 7
    subgoal.report(found, tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text()
    assert "Gaussian-process dynamic programming" in text


def test_a_saved_posterior_says_how_it_was_planned(tmp_path):
    found = subgoal.gpsrl(DEMOS, plane(), seed=1, **FAST)
    subgoal.save(found, tmp_path / "found.npz")
    assert subgoal.load(tmp_path / "found.npz").settings.planner == found.settings.planner


@pytest.mark.parametrize("smoother", [GaussianSmoother(), Averager()])
def test_a_saved_posterior_with_its_world_acts_as_before(tmp_path, smoother):
    """Nothing is planned again: the value functions are in the file."""
    found = subgoal.gpsrl(DEMOS, plane(), smoother=smoother, seed=1, **FAST)
    subgoal.save(found, tmp_path / "found.npz")
    again = subgoal.load(tmp_path / "found.npz", mdp=plane())
    assert again.likelihood.planner == found.likelihood.planner
    np.testing.assert_array_equal(again.likelihood.dense, found.likelihood.dense)
    at = np.array([[1.0, 1.0], [2.5, 0.5]])
    skills = [option(each, 2) for each in (found, again)]
    np.testing.assert_array_equal(skills[0].policy(at), skills[1].policy(at))
    assert subgoal.report(again, tmp_path / "again.html").exists()


def test_another_world_or_none_is_said(tmp_path):
    found = subgoal.gpsrl(DEMOS, plane(), seed=1, **FAST)
    subgoal.save(found, tmp_path / "found.npz")
    with pytest.raises(StorageError, match="another world"):
        subgoal.load(tmp_path / "found.npz", mdp=plane(test_actions=action_grid(LOW, HIGH, 5)))
    with pytest.raises(InputError, match="mdp=ContinuousWorld"):
        option(subgoal.load(tmp_path / "found.npz"), 2)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="None beside candidates"):
        subgoal.gpsrl(DEMOS, plane(), candidates=subgoal.epsilon_net(DEMOS, 0.5),
                      metric=subgoal.Metric.euclidean(2))  # fmt: skip
    with pytest.raises(InputError, match="None beside a ContinuousWorld"):
        subgoal.gpsrl(DEMOS, plane(), bounds=(LOW, HIGH))
    with pytest.raises(InputError, match="wanted a finite number of at least 0"):
        subgoal.gpsrl(DEMOS, plane(), dwell=-1.0)
    still = subgoal.Demonstrations.from_arrays(
        np.column_stack([DEMOS.states, np.ones(81)]), DEMOS.actions, DEMOS.offset, times=DEMOS.times
    )
    with pytest.raises(InputError, match="dimension 2: found 1 throughout"):
        subgoal.gpsrl(still, lambda s, a, t: s, bounds=(LOW, HIGH))
    with pytest.raises(InputError, match="finite numbers"):
        subgoal.gpsrl(DEMOS, lambda s, a, t: s * np.nan, bounds=(LOW, HIGH))
    with pytest.raises(InputError, match="the time between two pairs"):
        subgoal.gpsrl(DEMOS, ContinuousWorld(push, LOW, HIGH, step=1.0))
    codes = subgoal.Demonstrations.from_arrays(
        DEMOS.states, np.arange(DEMOS.n_observations) % 3, DEMOS.offset, times=DEMOS.times
    )
    with pytest.raises(InputError, match="codes of discrete actions"):
        subgoal.gpsrl(codes, push)
    still = subgoal.Demonstrations.from_arrays(DEMOS.states, np.ones((81, 1)), DEMOS.offset, times=DEMOS.times)
    with pytest.raises(InputError, match="dimension 0: found 1 throughout"):
        subgoal.gpsrl(still, push)
    with pytest.raises(InputError, match="even steps"):
        times = np.array(DEMOS.times)
        times[4] += 0.1
        uneven = subgoal.Demonstrations.from_arrays(DEMOS.states, DEMOS.actions, DEMOS.offset, times=times)
        subgoal.gpsrl(uneven, push, bounds=(LOW, HIGH))


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"low": HIGH}, "bounds of the actions"),
        ({"step": 0.0}, "step"),
        ({"horizon": np.nan}, "horizon"),
        ({"points": 0}, "points"),
        ({"test_actions": [[0.0, 0.0], [2.0, 0.0]]}, "test_actions"),
        ({"test_actions": [[0.0, 0.0]]}, "test_actions"),
        ({"gaussian": True}, "variance"),
    ],
)
def test_worlds_out_of_range_are_refused(fields, said):
    with pytest.raises(InputError, match=said):
        ContinuousWorld(push, **({"low": LOW, "high": HIGH, "step": 0.5} | fields))
