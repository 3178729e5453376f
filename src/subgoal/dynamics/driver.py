"""A noisy driver: steers a car to steady states by feedback, with a slow hand and wandering errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.dynamics.car import Car
from subgoal.dynamics.equilibria import Equilibrium, jacobians, manoeuvres, steady_state
from subgoal.dynamics.scripts import SCRIPT, Order, Script, check_script, timetable
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

TRUTH_STEP = 0.0025
"""s, the longest step with which the driven car is integrated."""

GAIN_STEP = 0.02
"""s between decisions of the regulator that the gains are optimal for."""

STATE_COST, ACTION_COST = np.diag([4.0, 4.0, 1.0, 0.01]), np.diag([1 / 0.15**2, 1 / 0.7**2])
HAND_LAG = 0.1
WANDER, WANDER_TIME = np.array([0.03, 0.10]), 0.2
OFFSET = 0.04 * np.array([0.25, 1.5])
AT_REST = 0.3
"""Share of the noise while stopping."""


@dataclass(frozen=True, eq=False, repr=False)
class Driven:
    """What a driver did, and what the driver was about.

    Attributes
    ----------
    demonstrations:
        States (N, 4) and the commands (N, 2) as applied to the car from each on; times in s.
    labels:
        (N,) what each observation belongs to: the number of the place in ``places``.
    places:
        Name of each steady state the driver was after, and the state; those of the script, in its words.
    """

    demonstrations: Demonstrations
    labels: Ints
    places: dict[str, Equilibrium]

    def __repr__(self) -> str:
        return f"Driven({self.demonstrations.n_observations} pairs, {', '.join(self.places)})"


def drive(
    car: Car,
    script: Script = SCRIPT,
    *,
    places: Mapping[str, Equilibrium] | None = None,
    noise: float = 1.0,
    feedback: bool = True,
    order: Order = "script",
    rate: float = 100.0,
    duration: float = 30.0,
    trajectories: int = 1,
    seed: int = 0,
) -> Driven:
    """Drive ``car`` through a script of steady states, (name, seconds) each, lengths varied, in all ``duration`` s.

    The command that is wanted is the steady one, an offset of the segment, and −K (s − s*); the hand follows it with a
    lag of 0.1 s, wanders by 0.03 rad and 0.10 m/s (Ornstein-Uhlenbeck, 0.2 s), and is clipped to the car's bounds.

    Parameters
    ----------
    places:
        The steady states by name; not given: ``manoeuvres(car)``. Each trajectory starts in the first of its script.
    noise:
        Scales the wandering of the commands and the offset from the right command that each segment keeps.
    feedback:
        Whether the commands answer errors of the state, by a linear-quadratic regulator about each steady state.
    order:
        "shuffled": everything between the first and the last segment in random order.
    rate:
        Commands per second, each held until the next; the rows of the demonstrations.
    seed:
        Trajectory k hangs on the seed and on k alone.

    Raises
    ------
    InputError
        A script that names no place, a rate, duration or noise out of range, naming the argument.
    """
    goals = dict(manoeuvres(car) if places is None else places)
    check_script(script, goals, order)
    noise, rate = positive("noise", noise, zero=True), positive("rate", rate)
    steps = round(rate * positive("duration", duration))
    if steps < 1:
        raise InputError("duration", found=duration, wanted=f"at least {1 / rate:g} s, one command")
    truth = replace(car, step=min(car.step, TRUTH_STEP))
    gains = {name: regulator(truth, goal) * feedback for name, goal in goals.items()}
    runs = []
    for k in range(whole("trajectories", trajectories)):
        generator = stream(seed, k)
        ends = timetable(script, order, steps / rate, generator)
        runs.append(_driven(truth, ends, goals, gains, noise, rate, steps, generator))
    number = {name: k for k, name in enumerate(goals)}
    labels = np.array([number[name] for run in runs for name in run[3]], np.int64)
    return Driven(_recorded(car, runs, steps, rate), frozen(labels), goals)


def turns(car: Car, *, noise: float = 1.0, duration: float = 30.0, trajectories: int = 1, seed: int = 0) -> Driven:
    """Right turns of three radii, twice each (thesis, Figure 7-8): δ −0.10, −0.20 and −0.32 rad at w_c 1.5 m/s."""
    angles = {"wide right": -0.10, "right": -0.20, "tight right": -0.32}
    places = {name: steady_state(car, (angle, 1.5), (1.45, 0.0, 7 * angle, 1.5)) for name, angle in angles.items()}
    script = [(name, 5.0) for name in (*places, *places)]
    return drive(car, script, places=places, noise=noise, duration=duration, trajectories=trajectories, seed=seed)


def path(states: Any, times: Any) -> Floats:
    """(N, 3) x, y in m and heading in rad of a car with body velocities ``states`` (N, ≥ 3) at ``times`` (N,).

    It starts at the origin, heading along x. Yaw rate and body velocities are averaged over each step, at the heading
    half way. Raises ``InputError`` for times that do not increase.
    """
    motion, clock = real_array("states", states, ndim=2), real_array("times", times, ndim=1)
    if motion.shape[1] < 3 or clock.shape != motion.shape[:1]:
        found = f"shapes {motion.shape} and {clock.shape}"
        raise InputError("states and times", found=found, wanted="(N, 3 or more) and (N,)")
    lengths = np.diff(clock)
    if not (lengths > 0).all():
        row = int(np.argmin(lengths > 0)) + 1
        raise InputError("times", where=f"row {row}", found=clock[row], wanted=f"more than {clock[row - 1]:g}")
    mean = (motion[1:, :3] + motion[:-1, :3]) / 2
    turned = mean[:, 2] * lengths
    heading = np.cumsum(turned) - turned / 2
    out = np.zeros((len(clock), 3))
    out[1:, 0] = np.cumsum((mean[:, 0] * np.cos(heading) - mean[:, 1] * np.sin(heading)) * lengths)
    out[1:, 1] = np.cumsum((mean[:, 0] * np.sin(heading) + mean[:, 1] * np.cos(heading)) * lengths)
    out[1:, 2] = np.cumsum(turned)
    return frozen(out)


def regulator(car: Car, goal: Equilibrium) -> Floats:
    """K (2, 4) of the discrete linear-quadratic regulator about a steady state; none at rest, where nothing steers."""
    if not goal.action.any():
        return np.zeros((2, 4))
    by_state, by_action = jacobians(car, goal.state, goal.action)
    whole_step = expm(GAIN_STEP * np.block([[by_state, by_action], [np.zeros((2, 6))]]))
    a, b = whole_step[:4, :4], whole_step[:4, 4:]
    cost = solve_discrete_are(a, b, STATE_COST, ACTION_COST)
    return np.asarray(np.linalg.solve(ACTION_COST + b.T @ cost @ b, b.T @ cost @ a))


def _recorded(car: Car, runs: list[Any], steps: int, rate: float) -> Demonstrations:
    return Demonstrations(
        states=np.concatenate([run[0] for run in runs]), actions=np.concatenate([run[1] for run in runs]),
        offset=steps * np.arange(len(runs) + 1), times=np.tile(np.arange(steps) / rate, len(runs)),
        final_states=np.array([run[2] for run in runs]), truncated=np.ones(len(runs), bool),
        names=car.names, source=Source("simulated driver"),
    )  # fmt: skip


def _driven(
    car: Car, ends: Any, goals: Any, gains: Any, noise: float, rate: float, steps: int, generator: np.random.Generator
) -> tuple[Floats, Floats, Floats, list[str]]:
    """States (steps, 4), commands (steps, 2), the state after the last (4,), and the segment of each step."""
    keep, hold = np.exp(-1 / (rate * HAND_LAG)), np.exp(-1 / (rate * WANDER_TIME))
    shocks = generator.standard_normal((steps, 2))
    shocks[1:] *= np.sqrt(1 - hold**2)
    offsets = noise * OFFSET * generator.standard_normal((len(ends), 2))
    segment = np.searchsorted([end for _, end in ends], np.arange(steps) / rate, side="right")
    states, commands, labels = np.empty((steps + 1, 4)), np.empty((steps, 2)), list[str]()
    states[0], hand, wander = goals[ends[0][0]].state, goals[ends[0][0]].action, np.zeros(2)
    for i in range(steps):
        name = ends[segment[i]][0]
        goal = goals[name]
        resting = not goal.action.any()
        wanted = goal.action if resting else goal.action + offsets[segment[i]] - gains[name] @ (states[i] - goal.state)
        hand = wanted + keep * (hand - wanted)
        wander = hold * wander + shocks[i]
        scale = noise * WANDER * (AT_REST if resting else 1.0)
        commands[i] = np.clip(hand + scale * wander, *car.bounds)
        states[i + 1] = car(states[i : i + 1], commands[i : i + 1], 1 / rate)[0]
        labels.append(name)
    return states[:-1], commands, states[-1], labels
