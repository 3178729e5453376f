"""Raw samples of a hand, and streams that are told them."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.streaming import Stream

FIELDS = ("states", "actions", "offset", "times", "final_states", "truncated")


def uneven(seed: int, seconds: float = 3.0, dimension: int = 2, begin: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Times (M,) 60 to 240 a second, and places (M, d) on a way through random places that rests now and then."""
    generator = np.random.default_rng(seed)
    times = begin + np.cumsum(1 / generator.uniform(60, 240, size=int(seconds * 110)))
    knots = np.linspace(times[0], times[-1], 6)
    corners = generator.uniform(0, 2, size=(6, dimension))
    corners[3] = corners[2]
    places = np.stack([np.interp(times, knots, column) for column in corners.T], axis=1)
    return times, places + generator.normal(scale=1e-3, size=places.shape) * (np.ptp(places, axis=0) > 0)


def tell(stream: Stream, *trajectories: tuple[np.ndarray, np.ndarray]) -> Stream:
    """The stream after all samples of trajectories that are over."""
    for times, places in trajectories:
        for time, place in zip(times, places, strict=True):
            stream.add(time, place)
        stream.lift()
    return stream


def recording_of(*trajectories: tuple[np.ndarray, np.ndarray], names: tuple[str, ...] = ()) -> Recording:
    """The same samples as a recording."""
    sizes = [len(times) for times, _ in trajectories]
    return Recording(
        np.concatenate([places for _, places in trajectories]), np.concatenate([times for times, _ in trajectories]),
        np.concatenate([[0], np.cumsum(sizes)]), names,
    )  # fmt: skip


def assert_same(found: Demonstrations, wanted: Demonstrations) -> None:
    """Every number and label, to the last bit."""
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)
    assert found.trajectory_names == wanted.trajectory_names
    assert found.names == wanted.names
    assert found.source.notes == wanted.source.notes
