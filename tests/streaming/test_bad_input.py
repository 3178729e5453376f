"""What a stream refuses, in words; and that it is then as it was."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from subgoal.demonstrations.metric import Metric
from subgoal.runtime.errors import InputError
from subgoal.streaming import Stream
from tests.streaming.made import uneven

BAD_SAMPLES = {
    "a time that is not a number": (np.nan, [1.0, 1.0], "time.*found nan"),
    "an infinite time": (np.inf, [1.0, 1.0], "time"),
    "words for a time": ("soon", [1.0, 1.0], "time"),
    "a place that is not a number": (1.0, [np.nan, 1.0], r"place at index \(0,\)"),
    "an infinite place": (1.0, [1.0, -np.inf], r"place at index \(1,\)"),
    "three coordinates": (1.0, [1.0, 1.0, 1.0], "place: found 3 numbers, wanted 2, for x0, x1"),
    "one coordinate": (1.0, 1.0, "place: found 1 numbers, wanted 2"),
    "two places": (1.0, [[1.0, 1.0]], "place: found an array of shape"),
    "a time again": (0.5, [1.0, 1.0], "time: found 0.5 after 0.5, wanted a later one"),
    "a time before": (0.4, [1.0, 1.0], "time: found 0.4 after 0.5"),
    "a gap": (1e6, [1.0, 1.0], "time: found a gap of 1e"),
    "a place too far": (1.0, [1e141, 1.0], "place: found 1e.141, wanted numbers below 1e.140"),
    "a step too quick": (np.nextafter(0.5, 1), [1e130, 1.0], "time: found a step of"),
    "a clock too large": (1e18, [1.0, 1.0], "time: found 1e.18, wanted a number that one step"),
}


def half_told() -> Stream:
    stream = Stream(2, radius=0.3, chains=2)
    for time, place in zip(np.linspace(0, 0.5, 40), uneven(0)[1], strict=False):
        stream.add(time, place)
    return stream


@pytest.mark.parametrize(("time", "place", "told"), BAD_SAMPLES.values(), ids=BAD_SAMPLES)
def test_a_bad_sample_is_refused_and_changes_nothing(time: object, place: object, told: str) -> None:
    stream, untouched = half_told(), half_told()
    with pytest.raises(InputError, match=told):
        stream.add(time, place)
    for each in (stream, untouched):
        each.add(0.6, [1.0, 1.5])
        each.lift()
    np.testing.assert_array_equal(stream.demonstrations().actions, untouched.demonstrations().actions)
    np.testing.assert_array_equal(stream.likelihood().dense, untouched.likelihood().dense)
    np.testing.assert_array_equal(stream._chains.latest, untouched._chains.latest)


def test_after_lifting_time_may_begin_again() -> None:
    stream = half_told()
    stream.lift()
    stream.add(0.0, [0.0, 0.0])
    stream.add(1.0, [1.0, 0.0])
    stream.lift()
    assert stream.demonstrations().n_trajectories == 2


def test_a_gap_that_can_be_filled_is_filled() -> None:
    stream = half_told()
    before = stream.n_pairs
    assert stream.add(40.0, [1.0, 1.5]) == stream.n_pairs - before > 700


BAD_STREAMS = {
    "no columns": ({"dimension": None}, "dimension: found none"),
    "half a column": ({"dimension": 1.5}, "dimension: found 1.5"),
    "no name": ({"dimension": 2, "names": ("x",)}, "names: found 1, wanted 2"),
    "a word for names": ({"dimension": None, "names": "xy"}, "names: found 'xy'"),
    "no radius": ({"radius": 0.0}, "radius: found 0.0"),
    "a radius that is not a number": ({"radius": np.nan}, "radius: found nan"),
    "a radius below zero": ({"radius": -1.0}, "radius: found -1.0"),
    "no confidence": ({"confidence": 0.0}, "confidence: found 0.0"),
    "too much confidence": ({"confidence": 1e10}, "confidence: found 10000000000.0, wanted at most"),
    "no concentration": ({"concentration": np.nan}, "concentration: found nan"),
    "no rate": ({"rate": 0.0}, "rate: found 0.0"),
    "no window": ({"window": 1}, "window: found 1, wanted a whole number of at least 2"),
    "no chains": ({"chains": 0}, "chains: found 0"),
    "a seed below zero": ({"seed": -1}, "seed: found -1"),
    "a metric of three dimensions": ({"metric": Metric.euclidean(3)}, "metric: found 3 dimensions, wanted 2"),
}


@pytest.mark.parametrize(("options", "told"), BAD_STREAMS.values(), ids=BAD_STREAMS)
def test_a_stream_that_cannot_be_is_refused(options: dict, told: str) -> None:
    with pytest.raises(InputError, match=told):
        Stream(**{"dimension": 2, "radius": 0.3, **options})


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda stream: stream.retune(confidence=-1.0), "confidence"),
        (lambda stream: stream.retune(confidence=5.0, concentration=np.nan), "concentration"),
        (lambda stream: stream.rejuvenate(0), "sweeps"),
        (lambda stream: stream.posterior(0), "draws"),
        (lambda stream: stream.posterior(warmup=-1), "warmup"),
        (lambda stream: stream.posterior(thin=1.5), "thin"),
        (lambda stream: stream.subgoals(merge_radius=np.nan), "merge_radius"),
    ],
)
def test_a_bad_setting_is_refused_and_changes_nothing(call, told: str) -> None:
    stream, untouched = half_told(), half_told()
    with pytest.raises(InputError, match=told):
        call(stream)
    assert stream.confidence == 3.0
    assert stream.concentration == 1.0
    np.testing.assert_array_equal(stream._chains.latest, untouched._chains.latest)


def test_before_the_first_pair_there_is_nothing_to_give() -> None:
    stream = Stream(2, radius=0.3)
    stream.add(0.0, [0.0, 0.0])
    with pytest.raises(InputError, match="no pairs yet"):
        stream.demonstrations()
    with pytest.raises(InputError, match="at least one"):
        stream.candidates()
    for call in (stream.posterior, stream.likelihood):
        with pytest.raises(InputError, match="nothing that moves yet"):
            call()
    assert Stream(2, radius=0.3).lift() == 0


@pytest.mark.parametrize(
    ("given", "what"),
    [({"names": (1, 2)}, "names"), ({"names": ("x", "x")}, "names"), ({"names": 3}, "names"),
     ({"names": ("x",), "units": 3}, "units"), ({"names": ("x",), "time_unit": None}, "time_unit")],
)  # fmt: skip
def test_words_are_words(given: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        Stream(**given, radius=0.5)
