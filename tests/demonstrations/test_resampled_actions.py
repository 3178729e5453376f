"""Recorded actions at another rate: each lasts until the next."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations import Recording, resample


def recording(times, actions, offset=None, positions=None):
    times = np.asarray(times, float)
    if positions is None:
        positions = times[:, None]
    return Recording(
        positions=positions, times=times, offset=[0, len(times)] if offset is None else offset, names=("x",),
        actions=np.asarray(actions, float)[:, None],
    )  # fmt: skip


def test_between_samples_the_last_action_is_held():
    made = resample(recording([0.0, 1.0, 2.0], [3.0, 5.0, 7.0]), 4.0)
    np.testing.assert_allclose(made.times, np.arange(9) / 4)
    np.testing.assert_allclose(made.actions[:, 0], [3] * 4 + [5] * 4 + [7])
    np.testing.assert_allclose(made.positions[:, 0], made.times)


def test_at_a_lower_rate_it_is_the_mean_over_time():
    """Uneven steps: 0.2 of one action and 0.8 of the next are 0.2·1 + 0.8·6."""
    made = resample(recording([0.0, 0.2, 1.0, 1.7, 2.0], [1.0, 6.0, 2.0, 4.0, 9.0]), 1.0)
    np.testing.assert_allclose(made.actions[:, 0], [0.2 * 1 + 0.8 * 6, 0.7 * 2 + 0.3 * 4, 9.0])


def test_what_is_done_in_all_stays_the_same():
    rng = np.random.default_rng(0)
    times = np.sort(rng.uniform(0, 10, 40))
    actions = rng.normal(size=40)
    made = resample(recording(times, actions), 3.0)
    wanted = actions[:-1] @ np.diff(times)
    assert made.actions[:-1, 0] @ np.diff(made.times) == pytest.approx(wanted)


def test_on_the_grid_already_nothing_changes():
    given = recording([0.0, 0.5, 1.0], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(resample(given, 2.0).actions, given.actions)


def test_trajectories_do_not_mix():
    given = recording([0.0, 1.0, 5.0, 6.0], [1.0, 1.0, 2.0, 2.0], offset=[0, 2, 4])
    made = resample(given, 2.0)
    np.testing.assert_allclose(made.actions[:, 0], [1, 1, 1, 2, 2, 2])
    np.testing.assert_array_equal(made.offset, [0, 3, 6])
