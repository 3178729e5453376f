"""Subgoals counted at one confidence after another: which draws, which streams, plateaus, Ctrl-C and resuming."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from subgoal import LogLikelihood, samplers
from subgoal.irl import sweep_record
from subgoal.irl.confidence_sweep import LASTING, confidence_sweep
from subgoal.irl.sweep_record import Sweep
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.models import Persistent
from subgoal.partition.protocol import Chain, Stretch
from subgoal.runtime.errors import InputError, StoppedError, StorageError
from subgoal.runtime.progress import Silent
from subgoal.runtime.seeds import stream
from tests.irl.energies import drawn, table

GOAL = np.repeat([0, 1, 2], 20)
LEVELS = [0.01, 3.0, 30.0]


def likelihood(**fields) -> LogLikelihood:
    return table(drawn(60, confidence=12.0, seed=4, goal=GOAL), **fields)


def swept(**given) -> Sweep:
    wanted = {"trials": 6, "sweeps": 60, "progress": Silent(), **given}
    return confidence_sweep(wanted.pop("likelihood", likelihood()), wanted.pop("confidences", LEVELS), **wanted)


def test_one_subgoal_then_three() -> None:
    found = swept(sweeps=300)
    assert (found.counts[0] == 1).all() and found.last_with_one == LEVELS[0]
    assert found.mean[2] == pytest.approx(3, abs=0.35)
    np.testing.assert_allclose(found.sd, [np.std(row) for row in found.counts])
    assert found.settings["sampler"] == repr(LASTING)
    assert str(found).count("\n") == 3 and repr(found).startswith("Sweep(3 confidences from 0.01 to 30, 6 trials)")


def test_counts_do_not_depend_on_the_number_of_workers() -> None:
    np.testing.assert_array_equal(swept(workers=1).counts, swept(workers=3).counts)
    assert (swept(seed=1).counts != swept(seed=2).counts).any()


def told(chain: Chain, keep) -> Stretch:
    """A sampler that says which table and stream it was given: θ is 0, 1, 2, ... of which the last draw has more."""
    assert keep[-1] and keep.sum() == 1
    seen.append((round(float(chain.table.confidence), 9), chain.generator.random(), chain.concentration, keep.size))
    theta = np.zeros((1, 60), np.int32)
    theta[0, :2], theta[0, 2:3] = 1, 2
    traces = np.zeros(keep.size)
    return Stretch({}, theta, traces.astype(int), traces, traces)


seen: list[tuple[float, float, float, int]] = []


def test_each_trial_has_its_level_and_a_stream_of_its_own() -> None:
    seen.clear()
    swept(sampler=told, trials=2, sweeps=7, seed=5, concentration=0.25, workers=1)
    wanted = [(a, stream(5, level, k).random(), 0.25, 7) for level, a in enumerate(LEVELS) for k in range(2)]
    assert seen == wanted


@pytest.mark.parametrize(("share", "count"), [(0.0, 3), (1 / 60, 3), (0.02, 2), (2 / 60, 2), (0.04, 1), (1.0, 0)])
def test_counted_are_distinct_subgoals_of_at_least_that_share(share: float, count: int) -> None:
    assert (swept(sampler=told, least_share=share, trials=1).counts == count).all()


def test_no_subgoal_is_none() -> None:
    """Observations of the background do not count as a subgoal."""
    away = table(drawn(60, confidence=12.0, seed=4, goal=GOAL), background=0.999999)
    assert (swept(likelihood=away, confidences=[300.0], concentration=100.0).counts < 3).all()

    def background(chain: Chain, keep) -> Stretch:
        theta = np.full((1, 60), 3, np.int32)
        return Stretch({}, theta, np.zeros(keep.size, int), np.zeros(keep.size), np.zeros(keep.size))

    assert (swept(likelihood=away, sampler=background).counts == 0).all()


def test_forms_are_made_of_the_table_at_each_level() -> None:
    values = []

    def form(at: LogLikelihood) -> LogLikelihood:
        values.append(at.confidence)
        return literal_maximum(at)

    swept(form=form, sampler=samplers.alg4_corrected, sweeps=3, trials=1)
    assert values == LEVELS
    with pytest.raises(InputError, match="form"):
        swept(form="literal")


def record(means, confidences=None) -> Sweep:
    counts = np.array([[m - 0.25, m + 0.25] for m in means])
    levels = 2.0 ** np.arange(len(means)) if confidences is None else np.array(confidences)
    return Sweep(levels, counts, np.empty(0), {}, 0.0)


def test_a_plateau_is_the_longest_run_in_the_ratio_of_its_ends() -> None:
    found = record([1, 3, 1, 2.5, 3, 3.5, 3.6]).plateau(3)
    assert (found.low, found.high, found.ratio) == (8.0, 32.0, 4.0)
    wide = record([3, 3, 3, 1, 3, 3], [1, 1.1, 1.2, 2, 10, 100]).plateau(3)
    assert (wide.low, wide.high) == (10, 100)
    assert record([3, 3]).plateau(3, within=0.0).ratio == 2
    assert np.isnan(record([1, 2]).plateau(5).low) and record([1, 2]).plateau(5).ratio == 0
    for wrong in ({"k": 0}, {"k": 3, "within": -1.0}, {"k": float("nan")}):
        with pytest.raises(InputError):
            record([1, 2]).plateau(**wrong)


def test_the_last_level_with_one_subgoal_in_every_trial() -> None:
    assert record([0.75, 0.7, 2, 0.75]).last_with_one == 2
    assert np.isnan(record([2, 0.75]).last_with_one)
    assert record([0.75, 0.75]).last_with_one == 2


class StopsAfter(Silent):
    """Ctrl-C once so many trials are done."""

    def __init__(self, trials: int) -> None:
        self.trials = trials

    def update(self, done: int, total: int, note: str = "") -> None:
        assert total == 18
        if done == self.trials:
            signal.raise_signal(signal.SIGINT)


def test_ctrl_c_gives_the_levels_that_are_done_and_resuming_the_rest(tmp_path) -> None:
    place = tmp_path / "sweep"
    stopped = swept(progress=StopsAfter(12), checkpoint=place)
    assert stopped.confidences.tolist() == LEVELS[:2] and stopped.left_out.tolist() == LEVELS[2:]
    assert "not run" in str(stopped) and place.exists()
    seen.clear()
    whole = swept(checkpoint=place, resume=True)
    np.testing.assert_array_equal(whole.counts, swept().counts)
    assert not whole.left_out.size and not place.exists()


def test_levels_that_are_done_are_not_done_again(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(sweep_record, "EVERY", 0.0)
    place = tmp_path / "sweep"
    swept(sampler=told, progress=StopsAfter(12), checkpoint=place)
    seen.clear()
    swept(sampler=told, checkpoint=place, resume=True)
    assert {level for level, *_ in seen} == {LEVELS[2]}


@pytest.mark.parametrize(
    "other",
    [{"seed": 1}, {"sweeps": 61}, {"confidences": [0.01, 3.0, 31.0]}, {"least_share": 0.1}, {"concentration": 0.5},
     {"trials": 5}, {"model": Persistent(0.5)}, {"likelihood": table(drawn(60, seed=9))}],
)  # fmt: skip
def test_checkpoints_of_other_settings_or_data_are_refused(tmp_path, other) -> None:
    place = tmp_path / "sweep"
    swept(progress=StopsAfter(6), checkpoint=place)
    with pytest.raises(StorageError):
        swept(checkpoint=place, resume=True, **other)


def test_ctrl_c_before_the_first_level_gives_nothing() -> None:
    def stops(chain: Chain, keep) -> Stretch:
        signal.raise_signal(signal.SIGINT)
        return told(chain, keep)

    with pytest.raises(StoppedError, match="first level"):
        swept(sampler=stops, workers=1)


@pytest.mark.parametrize(
    "wrong",
    [{"confidences": [1.0, 1.0]}, {"confidences": [0.0, 1.0]}, {"confidences": []}, {"confidences": [1.0, np.nan]},
     {"trials": 0}, {"sweeps": 1.5}, {"least_share": 1.5}, {"least_share": np.nan}, {"concentration": 0.0},
     {"seed": -1}, {"model": Persistent(0.5), "sampler": samplers.annealed}, {"resume": True},
     {"likelihood": np.zeros((3, 2))}, {"likelihood": LogLikelihood.from_table(np.zeros((3, 2)))}],
)  # fmt: skip
def test_bad_input_is_refused(wrong) -> None:
    with pytest.raises(InputError):
        swept(**wrong)


def test_levels_are_in_units_of_the_likelihood_where_none_are_given() -> None:
    found = confidence_sweep(likelihood(), trials=1, sweeps=2, progress=Silent())
    np.testing.assert_allclose(found.confidences, np.geomspace(0.1, 100, 12))
