"""What an execution came to, against the goal and against what was shown."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.options.comparison import deviation, outcome, stretches, trajectories
from subgoal.options.continuous import option
from subgoal.options.execution import execute
from subgoal.runtime.errors import InputError
from tests.options.point import STEP, goals, learned, planned, point_world, shown

pytestmark = pytest.mark.filterwarnings("ignore")


def recorded(*paths, step: float = 0.5, final=None) -> Demonstrations:
    """Trajectories of points along the first axis at height 2, the last of each where it ended."""
    rows = [np.column_stack([path, np.full(len(path), 2.0)]) for path in paths]
    return Demonstrations(
        np.concatenate([row[:-1] for row in rows]), np.zeros((sum(len(row) - 1 for row in rows), 1)),
        np.cumsum([0, *(len(row) - 1 for row in rows)]), final_states=np.array([row[-1] for row in rows]),
        times=np.concatenate([step * np.arange(len(row) - 1) for row in rows]),
    )  # fmt: skip


def test_reached_and_held_are_told_apart() -> None:
    made = planned([1.0, 2.0], radius=0.3)
    runs = recorded(
        [0, 0.5, 0.8, 1, 1.1, 1], [0, 1, 0, 0.8, 1.4, 0.9], [0, 0.2, 0.4, 0.1, 0.5, 0.2], [1, 1, 1, 1, 1, 1]
    )
    told = outcome(made, runs)
    np.testing.assert_allclose(told.reached, [1.0, 0.5, np.inf, 0.0])
    np.testing.assert_allclose(told.share_held, [1, 2 / 3, 0, 1])
    np.testing.assert_array_equal(told.held, [True, False, False, True])
    np.testing.assert_allclose(told.distance, [0.1, 0.4, 0.9, 0])
    np.testing.assert_allclose(told.rms[:, 0], [np.sqrt(0.01 / 3), np.sqrt((0.04 + 0.16 + 0.01) / 3), *told.rms[2:, 0]])
    np.testing.assert_allclose(told.rms[:, 1], 0)
    assert repr(told) == "Outcome(of 4 executions 3 reach the goal, 2 hold it)"
    np.testing.assert_array_equal(outcome(made, runs, within=0.45).held, [True, True, False, True])
    np.testing.assert_array_equal(outcome(made, runs, last=0.5, within=0.35).held, [True, False, False, True])


def test_differences_are_in_the_units_of_the_states() -> None:
    made = planned([1.0, 2.0], metric=Metric(np.array([0.1, 1.0]), np.array([8.0, np.inf])))
    told = outcome(made, recorded([8.5, 8.5, 8.5, 8.5]))
    np.testing.assert_allclose(told.rms, [[0.5, 0]])
    np.testing.assert_allclose(told.distance, 0.05)


def test_stretches_are_the_runs_of_a_candidate() -> None:
    posterior, demos = learned(), shown()
    for g in goals():
        rows = np.flatnonzero(posterior.best_assignment == g)
        runs = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
        found = stretches(posterior, g)
        np.testing.assert_array_equal(found.states, np.asarray(demos.states)[rows])
        np.testing.assert_array_equal(found.actions, np.asarray(demos.actions)[rows])
        np.testing.assert_array_equal(np.diff(found.offset), [run.size for run in runs])
        np.testing.assert_array_equal(found.times, demos.times[rows])
        after = [demos.final_states[0] if run[-1] == 49 else demos.states[run[-1] + 1] for run in runs]
        np.testing.assert_array_equal(found.final_states, after)
        np.testing.assert_array_equal(found.truncated, [run[-1] == 49 for run in runs])
        longest = max(run.size for run in runs)
        assert stretches(posterior, g, shortest=longest).n_trajectories >= 1
        with pytest.raises(InputError, match="never served for"):
            stretches(posterior, g, shortest=longest + 1)


def test_deviation_is_taken_moment_by_moment() -> None:
    metric = Metric(np.array([2.0, 1.0]), np.full(2, np.inf))
    ours = recorded([0, 1, 2, 3, 4, 5, 6], [0, 0, 0, 0, 0], step=0.25)
    theirs = recorded([0, 2.5, 4], [1, 1, 1, 9, 9], step=0.5)
    np.testing.assert_allclose(deviation(metric, ours, theirs), [[np.sqrt(0.25 / 3), 0], [1, 0]])
    np.testing.assert_allclose(deviation(metric, ours, theirs, after=0.4), [[np.sqrt(0.25 / 2), 0], [1, 0]])
    with pytest.raises(InputError, match="after"):
        deviation(metric, ours, theirs, after=1.0)
    with pytest.raises(InputError, match="whole multiple"):
        deviation(metric, recorded([0, 1, 2], step=0.3), recorded([0, 1, 2], step=0.5))
    with pytest.raises(InputError, match="found 1 trajectories, wanted 2"):
        deviation(metric, recorded([0, 1, 2]), theirs)


def test_a_learned_option_does_as_was_shown() -> None:
    """From where each stretch began, for as long as it took."""
    posterior = learned()
    for g in goals():
        made, part = option(posterior, g), stretches(posterior, g, shortest=5)
        how = {"start": part.states[part.offset[:-1]], "duration": STEP * np.diff(part.offset).max(), "hold": True}
        off = deviation(made.metric, execute(made, point_world(), **how), part)
        assert off.shape == (part.n_trajectories, 2)
        assert (off < 0.6).all()
        still = deviation(made.metric, execute(planned(part.states[0]), point_world(), **how), part)
        assert still.max() > 2 * off.max()


def test_a_path_has_one_state_more_than_it_has_actions() -> None:
    np.testing.assert_array_equal([len(each) for each in trajectories(recorded([1, 2, 3], [4, 5]))], [3, 2])


def test_mistakes_are_told() -> None:
    made, runs = planned([1.0, 2.0]), recorded([0, 1, 2])
    for keywords, match in (({"within": 0}, "within"), ({"last": np.nan}, "last")):
        with pytest.raises(InputError, match=match):
            outcome(made, runs, **keywords)
    with pytest.raises(InputError, match="no times"):
        outcome(made, Demonstrations.from_arrays(np.zeros((3, 2)), np.zeros((3, 2)), [0, 3]))
    with pytest.raises(InputError, match="shortest"):
        stretches(learned(), goals()[0], shortest=0)
