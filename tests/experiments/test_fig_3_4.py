"""Figure 3-4: the measures of speed and loss on curves made by hand, the study in the small, and its verdicts."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import fig_3_4, room_claims, room_mean
from experiments.common import Options
from experiments.room_study import (
    COOLED,
    MAIN,
    NARROW,
    READINGS,
    VARIANTS,
    WALK,
    WIDE,
    Trace,
    Wandering,
    end_of,
    reached,
    settled,
    speed_ups,
    study,
)
from experiments.room_worlds import Losses, demonstrate
from subgoal.mdp.grids.rooms import room_world

TIMES = np.arange(1, 101)


def falling(step: int, start: float, end: float) -> np.ndarray:
    """(2, 100) two runs that fall at one iteration, and stay."""
    return np.tile(np.where(step > TIMES, start, end), (2, 1))


def trace(**curves: np.ndarray) -> Trace:
    losses = {name: Losses(curve, curve, curve / 5000) for name, curve in curves.items()}
    far = Wandering((0.1, 0.4), (0.3, 0.9))
    return Trace(("A", "B"), TIMES, losses, Losses(*[np.full(2, 190.0)] * 3), (far, far))


def as_the_thesis_has_it() -> Trace:
    return trace(**{
        WALK: falling(60, 4000, 500), COOLED: falling(20, 4000, 500), NARROW: falling(4, 4000, 260),
        WIDE: falling(6, 4000, 240),
    })  # fmt: skip


def test_where_a_run_ends_and_when_it_settles() -> None:
    curve = falling(31, 1000, 100)
    assert end_of(curve).tolist() == [100, 100]
    assert settled(curve, TIMES).tolist() == [31, 31]
    assert np.isnan(reached(curve, TIMES, np.array([50.0, 100.0]))).tolist() == [True, False]


def test_speed_is_counted_to_the_loss_that_policywalk_settles_at() -> None:
    made = as_the_thesis_has_it()
    assert speed_ups(made, COOLED).tolist() == [3, 3]
    assert speed_ups(made, NARROW).tolist() == [15, 15]
    never = trace(**{WALK: falling(60, 4000, 500), COOLED: falling(10, 4000, 2000)})
    assert speed_ups(never, COOLED).tolist() == [0, 0]


def test_runs_that_are_cut_end_earlier() -> None:
    cut = as_the_thesis_has_it().until(50)
    assert cut.iterations.tolist() == list(range(1, 51))
    assert end_of(cut.losses[WALK].even).tolist() == [4000, 4000]
    assert end_of(cut.losses[COOLED].by_state).tolist() == [0.1, 0.1]


def test_all_claims_hold_of_curves_like_those_of_the_thesis() -> None:
    mean = {"least": {"squared": room_mean.MEAN}, "expected": {}, "draws_tried": 1}
    assert [claim["verdict"] for claim in room_claims.claims(as_the_thesis_has_it(), mean)] == ["holds"] * 6


def test_no_claim_holds_where_nothing_differs() -> None:
    same = falling(60, 4000, 500)
    mean = {"least": {"squared": "zero"}, "expected": {}, "draws_tried": 1}
    made = trace(**dict.fromkeys(VARIANTS, same))
    alike = Wandering((0.1, 0.1), (0.3, 0.3))
    found = room_claims.claims(Trace(made.worlds, TIMES, made.losses, made.truth, (alike, alike)), mean)
    assert [claim["verdict"] for claim in found] == ["does not hold"] * 6


def test_chains_begin_at_no_reward_and_lower_the_loss() -> None:
    found = study([room_world("A")], [0], READINGS[MAIN], 1_500)
    assert found.iterations[0] == 1 and found.iterations[-1] == 1_500
    for losses in found.losses.values():
        assert losses.even.shape == (1, found.iterations.size)
        assert losses.even[0, -1] < 0.8 * losses.even[0, 0]
    assert end_of(found.losses[NARROW].even)[0] < end_of(found.losses[WALK].even)[0]
    assert found.wandering[0].accepted[1] > found.wandering[0].accepted[0]


@pytest.mark.parametrize("name", READINGS)
def test_every_reading_runs(name: str) -> None:
    found = study([room_world("B")], [1], READINGS[name], 40)
    assert set(found.losses) == set(VARIANTS)


def test_the_first_demonstrations() -> None:
    demos = demonstrate(room_world("A"), 0)
    few = room_mean.first_of(demos, 2)
    assert few.n_observations == 100 and few.n_trajectories == 2
    np.testing.assert_array_equal(few.states, demos.states[:100])
    np.testing.assert_array_equal(few.final_states, demos.final_states[:2])


def test_a_quick_run_has_every_claim_and_every_reading(tmp_path) -> None:
    headline, figure = fig_3_4.experiment(Options(tmp_path, quick=True))
    assert set(headline["readings"]) == set(READINGS)
    assert len(headline["claims"]) == 6
    assert {"name", "verdict", "measured", "thesis"} == set(headline["claims"][0])
    mean = headline["posterior_mean"]["expected"]
    assert mean[room_mean.MEAN]["squared"] < mean[room_mean.TRUTH]["squared"]
    assert len(figure.axes) == 4
