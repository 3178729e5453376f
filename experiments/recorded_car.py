"""A recording of a 1/10-scale car driven by hand: four topics, each with a clock of its own, on one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from subgoal.demonstrations import Demonstrations
from subgoal.runtime.checks import Floats, Ints

RATE = 20.0
"""Hz, of the common clock."""
LONGEST_GAP = 0.5
"""Seconds without a message of some topic at which the recording is cut."""
SHORTEST = 5.0
"""Seconds; pieces between cuts that are shorter are dropped."""
WINDOW = 0.2
"""Seconds before and after, over which poses are differentiated."""
POSE_LATE = 0.02
"""Seconds by which the pose is behind the gyroscope: where their yaw rates agree best."""
NAMES = {"vx": "m/s", "vy": "m/s", "yaw rate": "rad/s", "wheels": "m/s"}
FLOOR = {"vx": 0.5, "vy": 0.4, "yaw rate": 1.0, "wheels": 0.5}
"""Least differences that matter, those of the simulated car."""
TOPICS = ("command", "odom", "imu", "pfPose")


@dataclass(frozen=True, eq=False)
class Recorded:
    """One recording on a common clock, in pieces without gaps.

    Attributes
    ----------
    times:
        (M,) seconds from the first message, ``RATE`` of them in a second.
    states:
        (M,) each of body velocity ahead and to the left, yaw rate (gyroscope) and speed of the wheels (motor).
    commands:
        (M, 2) steering (rad) and speed (m/s), as last sent.
    path:
        (M, 2) position in metres.
    offset:
        (D+1,) where pieces begin.
    """

    times: Floats
    states: dict[str, Floats]
    commands: Floats
    path: Floats
    offset: Ints

    def demonstrations(self, names: tuple[str, ...], pieces: tuple[int, ...] | None = None) -> Demonstrations:
        """Pairs of the states ``names`` and the commands; of some pieces only, where they are given."""
        which = tuple(range(len(self.offset) - 1)) if pieces is None else pieces
        rows = np.concatenate([np.arange(self.offset[k], self.offset[k + 1]) for k in which])
        lengths = [self.offset[k + 1] - self.offset[k] for k in which]
        return Demonstrations(
            states=np.stack([self.states[name][rows] for name in names], axis=1), actions=self.commands[rows],
            offset=np.concatenate([[0], np.cumsum(lengths)]), times=self.times[rows], names=names,
        )  # fmt: skip

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """(2,) least and greatest commands."""
        return self.commands.min(axis=0), self.commands.max(axis=0)


def topic(folder: Path, name: str) -> tuple[Floats, pd.DataFrame]:
    """Times in seconds (M,), increasing, and the messages of one topic. Messages of the same time count once."""
    table = pd.read_csv(folder / f"{name}Data.csv", index_col=0)
    times = table["s"].to_numpy(float) + 1e-9 * table["ns"].to_numpy(float)
    kept = np.unique(times, return_index=True)[1]
    return times[kept], table.iloc[kept]


def read_recording(folder: Path, steer_late: float = 0.0, speed_late: float = 0.0) -> Recorded:
    """The topics of ``folder`` on one clock.

    States are interpolated between messages, commands held until the next. ``steer_late`` and ``speed_late`` are
    seconds by which commands are taken to work later than they are sent.
    """
    topics = {name: topic(folder, name) for name in TOPICS}
    start = min(times[0] for times, _ in topics.values())
    topics = {name: (times - start, table) for name, (times, table) in topics.items()}
    pieces = spans([times for times, _ in topics.values()])
    clock = [a + np.arange(int((b - a) * RATE + 1e-9) + 1) / RATE for a, b in pieces]
    times = np.concatenate(clock)
    (tc, command), (to, odom), (ti, imu), pose = (topics[name] for name in TOPICS)
    vx, vy, _ = body_motion(pose, times + POSE_LATE)
    return Recorded(
        times=times,
        states={
            "vx": vx, "vy": vy, "yaw rate": np.interp(times, ti, np.radians(imu["wz"])),
            "wheels": np.interp(times, to, odom["vx"]),
        },
        commands=np.stack([held(tc, command["delta"], times - steer_late), held(tc, command["V"], times - speed_late)],
                          axis=1),
        path=np.stack([np.interp(times + POSE_LATE, pose[0], pose[1][name]) for name in ("x", "y")], axis=1),
        offset=np.cumsum([0, *(len(each) for each in clock)]),
    )  # fmt: skip


def spans(clocks: list[Floats]) -> list[tuple[float, float]]:
    """Stretches in which no topic is silent for ``LONGEST_GAP``, ``WINDOW`` and 0.1 s off at each end.

    Those shorter than ``SHORTEST`` are dropped.
    """
    cuts = sorted(
        (float(times[k]), float(times[k + 1])) for times in clocks for k in np.flatnonzero(np.diff(times) > LONGEST_GAP)
    )
    first, last = max(times[0] for times in clocks), min(times[-1] for times in clocks)
    margin, found, begin = WINDOW + 0.1, [], float(first)
    for a, b in [*cuts, (float(last), np.inf)]:
        if a - begin - 2 * margin >= SHORTEST:
            found.append((begin + margin, a - margin))
        begin = max(begin, b)
    return found


def body_motion(pose: tuple[Floats, pd.DataFrame], times: Floats) -> tuple[Floats, Floats, Floats]:
    """Speed ahead, speed to the left and yaw rate (M,) by differences of the pose over ``WINDOW`` before and after."""
    at, table = pose
    heading = np.unwrap(2 * np.arctan2(table["q.z"].to_numpy(), table["q.w"].to_numpy()))

    def slope(values: Floats) -> Floats:
        rise = np.interp(times + WINDOW, at, values) - np.interp(times - WINDOW, at, values)
        return np.asarray(rise / (2 * WINDOW))

    turned = np.interp(times, at, heading)
    dx, dy = slope(table["x"].to_numpy()), slope(table["y"].to_numpy())
    ahead = dx * np.cos(turned) + dy * np.sin(turned)
    return np.asarray(ahead), np.asarray(dy * np.cos(turned) - dx * np.sin(turned)), slope(heading)


def held(at: Floats, values: pd.Series[float], times: Floats) -> Floats:
    """(M,) the last of ``values`` sent before each time."""
    return np.asarray(values, float)[np.maximum(np.searchsorted(at, times, side="right") - 1, 0)]


def delay(cause: Callable[[float], Floats], effect: Callable[[float], Floats]) -> float:
    """Seconds by which ``effect`` comes after ``cause``, where their correlation is greatest (±0.4 s, by 0.02)."""
    lags = np.arange(-20, 21) / 50
    return float(lags[np.argmax([np.corrcoef(cause(0.0), effect(lag))[0, 1] for lag in lags])])


def delays(folder: Path) -> dict[str, float]:
    """Seconds by which each follows another: the pose the gyroscope, turning the steering, the wheels the command."""
    topics = {name: topic(folder, name) for name in TOPICS}
    times = read_recording(folder).times + min(at[0] for at, _ in topics.values())
    (tc, command), (to, odom), (ti, imu), pose = (topics[name] for name in TOPICS)

    def rate(lag: float) -> Floats:
        return np.asarray(np.interp(times + lag, ti, np.radians(imu["wz"])))

    def wheels(lag: float) -> Floats:
        return np.asarray(np.interp(times + lag, to, odom["vx"]))

    steered = held(tc, command["delta"], times) * wheels(0.0)
    return {
        "pose_after_gyroscope": delay(rate, lambda lag: body_motion(pose, times + lag)[2]),
        "yaw_rate_after_steering": delay(lambda lag: steered, rate),
        "wheels_after_command": delay(lambda lag: held(tc, command["V"], times), wheels),
    }
