"""Three turns of different radius: reading them, and finding three."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.common import Options, figure_style
from experiments.skidpad import RATE, experiment, left_out, read_drive, read_turns
from subgoal.demonstrations import Demonstrations

TURNS = {"0.1": (1.8, -0.25), "0.3": (1.7, -0.76), "0.5": (1.5, -1.2)}
STILL, DRIVEN, AFTER = 1.0, 30.0, 0.5


def row(time: float, throttle: float, steer: float, x: float, y: float, speed: float, rate: float) -> str:
    """A line of the simulator: 18 columns, the first a date."""
    milliseconds = round(1000 * time)
    stamp = f"2024_02_10_20_{milliseconds // 60000:02}_{milliseconds // 1000 % 60:02}_{milliseconds % 1000:03}"
    values = [throttle, steer, 0, 0, x, y, 0.1, 0, 0, 0, speed, 0, 0, rate, 0, 0, 0]
    return ",".join([stamp, *map(str, values)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A placeholder, a second at rest, a start of a second and a circle, then back to the start, for each turn."""
    made = tmp_path_factory.mktemp("hunter")
    for name, (speed, rate) in TURNS.items():
        lines = [row(0.0, 0, 0.1, 0, 0, 0.4, 0)]
        rng = np.random.default_rng(0)
        time = 0.03
        while time < STILL + DRIVEN + AFTER:
            since = time - STILL
            grown = 1 - np.exp(-since / 0.2) if since > 0 else 0.0
            angle = rate * since
            driven = 0 < since < DRIVEN
            place = (-speed / rate * np.array([np.sin(angle), np.cos(angle)])) if driven else (0.0, 0.0)
            if driven:
                lines.append(row(time, 0.6, -float(name), *place, round(grown * speed, 2), grown * rate))
            else:
                lines.append(row(time, 0.0, 0.0, *place, 0.0, 0.0))
            time += float(rng.uniform(0.03, 0.045))
        (made / f"skidpad_cw_t0.6_s{name}.csv").write_text("\n".join(lines))
    return made


def test_only_what_is_driven_at_full_throttle_is_read(folder: Path) -> None:
    seconds, table = read_drive(folder / "skidpad_cw_t0.6_s0.3.csv")
    assert seconds[0] > STILL
    assert seconds[-1] < STILL + DRIVEN
    assert (table["throttle"] == 0.6).all()
    assert set(table["steering"]) == {-0.3}


def test_the_three_recordings_are_three_trajectories_on_an_even_clock(folder: Path) -> None:
    turns, paths, radii = read_turns(folder)
    assert turns.n_trajectories == 3
    assert turns.names == ("speed", "yaw rate")
    for begin, end, (speed, rate) in zip(turns.offset[:-1], turns.offset[1:], TURNS.values(), strict=True):
        np.testing.assert_allclose(np.diff(turns.times[begin:end]), 1 / RATE, atol=1e-9)
        np.testing.assert_allclose(turns.states[end - 1], [speed, rate], atol=1e-6)
    np.testing.assert_allclose(radii, [-speed / rate for speed, rate in TURNS.values()], rtol=0.01)
    assert len(paths) == turns.n_observations


def test_models_are_compared_at_a_steering_angle_that_they_have_not_seen() -> None:
    """A speed that grows with the square of what is steered: lines err at every angle left out, and by how much is
    known: a line through two of three points of a parabola 1, 4, 9 misses the third by 2 at a middle or an end."""
    size, angle = 400, [1.0, 2.0, 3.0]
    states = []
    for steer in angle:
        state = np.zeros(size)
        for k in range(size - 1):
            state[k + 1] = state[k] + 0.3 * (steer**2 - state[k])
        states.append(np.stack([state, -state + 0.01 * np.sin(np.arange(size))], axis=1))
    turns = Demonstrations(
        states=np.concatenate(states), actions=np.repeat(angle, size)[:, None], offset=size * np.arange(4),
        times=np.tile(np.arange(size) / RATE, 3), names=("speed", "yaw rate"),
    )  # fmt: skip
    speed = left_out(turns, "linear", 0)[0] * np.asarray(turns.states)[:, 0].std()
    assert speed == pytest.approx(np.sqrt((2**2 + 1**2 + 2**2) / 3), rel=0.1)


def test_three_are_found(folder: Path) -> None:
    with figure_style():
        headline, figure = experiment(Options(out=folder, quick=True, data=folder))
    assert headline["n_subgoals"] == 3
    assert headline["v_measure"] > 0.95
    found = sorted(row["radius"] for row in headline["subgoals"])
    np.testing.assert_allclose(found, sorted(-speed / rate for speed, rate in TURNS.values()), rtol=0.1)
    assert {"held_out_error", "bellman_residual", "sweep"} <= set(headline)
    assert len(figure.axes) == 3
