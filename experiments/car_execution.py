"""Pictures of options at the wheel: demonstrated and executed paths, states over time, and what was held."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.car_pictures import WORDS, colour
from experiments.car_study import EVERY, Run
from experiments.common import GREY, INK, sheet
from subgoal.demonstrations import Demonstrations
from subgoal.dynamics.car import Car
from subgoal.dynamics.driver import path
from subgoal.options import ContinuousOption, execute
from subgoal.runtime.checks import Floats, Ints

Skills = dict[str, tuple[ContinuousOption, Demonstrations]]
"""By manoeuvre: the option, and the stretches of the demonstration that its subgoal serves."""
PATHS = ("left", "right", "left drift")
LIKE = "left drift"
LONG = 4.0
"""Seconds for which a path is drawn at least."""
PARTS = 5
"""Moments between two decisions at which an execution is drawn."""


def executed(skill: ContinuousOption, shown: Demonstrations, car: Car, *, begin: Ints | None = None) -> Demonstrations:
    """``skill`` from the first state of each stretch, or from rows ``begin`` of it, held for as long as the longest."""
    rows = shown.offset[:-1] if begin is None else begin
    steps = int((shown.offset[1:] - rows).max())
    return execute(skill, car, start=np.asarray(shown.states)[rows], duration=steps * skill.world.step, hold=True)


def option_page(run: Run, skills: Skills, table: dict[str, Any]) -> Figure:
    """Paths above, a drift over time in the middle, counts and errors below."""
    figure = sheet(13.0, 11.0)
    grid = figure.add_gridspec(3, 12, height_ratios=(3.7, 2.1, 2.6))
    for k, name in enumerate(name for name in PATHS if name in skills):
        drawn_paths(figure.add_subplot(grid[0, 4 * k : 4 * k + 4]), run, skills, name)
    if LIKE in skills:
        over_time([figure.add_subplot(grid[1, 4 * k : 4 * k + 4]) for k in range(3)], run, skills)
    held_counts(figure.add_subplot(grid[2, :6]), run, table)
    refinements(figure.add_subplot(grid[2, 6:9]), run, next(iter(table.values())))
    errors(figure.add_subplot(grid[2, 9:]), run, next(iter(table.values())))
    figure.suptitle("Learned from thirty seconds at the wheel, driven again by the options of six subgoals", x=0.01,
                    ha="left")  # fmt: skip
    return figure


def longest(shown: Demonstrations) -> tuple[int, int]:
    """First and last row but one of the longest stretch."""
    k = int(np.argmax(np.diff(shown.offset)))
    return int(shown.offset[k]), int(shown.offset[k + 1])


def settled(skill: ContinuousOption, shown: Demonstrations) -> int:
    """The row of the longest stretch from which on it stays within one unit of the metric of the subgoal."""
    first, last = longest(shown)
    away = np.flatnonzero(skill.distance(np.asarray(shown.states)[first:last]) > 1)
    return first + (int(away[-1]) + 1 if away.size and away[-1] + 1 < last - first else 0)


def finely(skill: ContinuousOption, shown: Demonstrations, car: Car, row: int, seconds: float) -> tuple[Floats, Floats]:
    """Times (M,) and states (M, 4) of ``skill`` from a row of ``shown``, ``PARTS`` of them to a decision."""
    done = execute(skill, car, start=np.asarray(shown.states)[row], duration=seconds, hold=True)
    states, actions, every = np.asarray(done.states), np.asarray(done.actions), skill.world.step / 2
    parts = [states if k == 0 else car(states, actions, k * every / PARTS) for k in range(PARTS)]
    fine = np.concatenate([np.stack(parts, axis=1).reshape(-1, states.shape[1]), done.final_states])
    return every / PARTS * np.arange(len(fine), dtype=float), fine


def at_full_rate(run: Run, shown: Demonstrations, first: int, last: int) -> tuple[Floats, Floats]:
    """Times from zero and states (M, 4) of the recording, from one row of ``shown`` until another has ended."""
    times = np.asarray(run.driven.demonstrations.times)
    if shown.times is None:
        raise ValueError("stretches without times")
    begin = int(np.searchsorted(times, shown.times[first] - 1e-9))
    rows = slice(begin, begin + EVERY * (last - first))
    return times[rows] - times[begin], np.asarray(run.driven.demonstrations.states)[rows]


def drawn_paths(axes: Axes, run: Run, skills: Skills, name: str) -> None:
    """The longest stretch in black, and the option from where that has settled; what is before, in grey."""
    skill, shown = skills[name]
    (first, last), ink = longest(shown), tint(run, name)
    begin = settled(skill, shown) if "drift" in name else first
    times, states = at_full_rate(run, shown, first, last)
    pose = path(states, times)
    before = EVERY * (begin - first)
    lasted = times[-1] - times[before]
    clock, fine = finely(skill, shown, run.model, begin, max(LONG, lasted))
    ours = placed(path(fine, clock)[:, :2], pose[before])
    along = int(np.searchsorted(clock, lasted))
    if before:
        axes.plot(*pose[: before + 1, :2].T, color=GREY, lw=1.4, label=f"demonstrated, {times[before]:.1f} s before")
    axes.plot(*pose[before:, :2].T, color=INK, lw=2.2, label="demonstrated")
    axes.plot(*ours[: along + 1].T, color=ink, lw=2.8, label="option")
    if lasted < LONG - 1:
        axes.plot(*ours[along:].T, color=ink, lw=1.2, label=f"option, on to {LONG:g} s")
    axes.plot(*pose[before, :2], "o", color=INK, ms=7)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12, 0.3 if before else 0.12)
    axes.set(title=f"{name.capitalize()}: {lasted:.1f} s from the same state (dot)", xlabel="x (m)", ylabel="y (m)")
    axes.legend(loc="upper left" if before else "center", fontsize=8.5)


def placed(points: Floats, pose: Floats) -> Floats:
    """Points (M, 2) of a path from the origin along x, moved to begin at a pose (3,)."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + pose[:2])


def tint(run: Run, name: str) -> str:
    """The colour of a manoeuvre."""
    return colour(list(run.driven.places).index(name))


def over_time(axes: list[Axes], run: Run, skills: Skills) -> None:
    """Three states of the drift from its entry on, by driver and by option."""
    skill, shown = skills[LIKE]
    first, last = longest(shown)
    times, states = at_full_rate(run, shown, first, last)
    clock, fine = finely(skill, shown, run.model, first, times[-1])
    words = ("forward speed (m/s)", "sideways speed (m/s)", "yaw rate (rad/s)")
    for k, (axis, word) in enumerate(zip(axes, words, strict=True)):
        axis.axhline(run.driven.places[LIKE].state[k], color=GREY, lw=1, ls="--")
        axis.plot(times, states[:, k], color=INK, lw=1.8)
        axis.plot(clock, fine[:, k], color=tint(run, LIKE), lw=2.2)
        axis.set(xlabel="time since the manoeuvre began (s)", ylabel=word)
    axes[0].set_title(f"{LIKE.capitalize()} from its entry: driver black, option coloured, true steady state dashed")


def held_counts(axes: Axes, run: Run, table: dict[str, Any]) -> None:
    """In how many of the executions each goal was held, by condition; pale, how many stayed within a whole unit."""
    names = list(run.driven.places)
    drivers = next(iter(table.values()))["drivers"]
    for row, (column, name) in product(range(len(table)), enumerate(names)):
        count, near, tried = list(table.values())[row]["by_manoeuvre"][name]
        for many, alpha in ((near, 0.3), (count, 0.85)):
            axes.barh(row, 0.9 * many / tried, left=column, height=0.55, color=colour(column), alpha=alpha, lw=0)
        axes.barh(row, 0.9, left=column, height=0.55, fill=False, edgecolor=GREY, lw=0.8)
        ink = "white" if 2 * count > tried else INK
        axes.text(column + 0.45, row, f"{count}/{tried}", ha="center", va="center", color=ink, weight="bold")
    axes.set_yticks(range(len(table)), [WORDS[name] for name in table])
    axes.set_xticks(np.arange(len(names)) + 0.45, names)
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.grid(False)
    axes.spines[:].set_visible(False)
    axes.set_title(
        f"Held within 0.5 (pale: 1.0) in the last of 4 s, from 4 starts; {drivers} driver{'s' if drivers > 1 else ''}"
    )


def refinements(axes: Axes, run: Run, hard: dict[str, Any]) -> None:
    """How many unstable drifts are held, by how far actions are refined."""
    by, tried = hard["by_refinement"], hard["drift_tried"]
    for row, count in enumerate(by.values()):
        axes.barh(row, count / tried, color=tint(run, LIKE), height=0.6, alpha=0.85)
        axes.text(0.03, row, f"{count}/{tried}", va="center", weight="bold")
    axes.set_yticks(range(len(by)), [how.replace(", ", ",\n") for how in by])
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set(xticks=[], title="Unstable drifts held,\nby refinement of the actions")
    axes.grid(False)


def errors(axes: Axes, run: Run, hard: dict[str, Any]) -> None:
    """Root mean square difference of option and driver, second half of each stretch."""
    by = hard["rmse_second_half_by_manoeuvre"]
    words = ("forward (m/s)", "sideways (m/s)", "yaw rate (rad/s)", "wheels (m/s)")
    for what, word, marker in zip(Car.names, words, "o^sD", strict=True):
        for column, each in enumerate(by.values()):
            axes.plot(column, each[what], marker, color=colour(column), ms=6.5, mfc="white" if what == "w" else None)
        axes.plot([], [], marker, color=INK, label=word, ms=6, mfc="white" if what == "w" else None)
    axes.set_xticks(range(len(by)), [name.replace(" ", "\n") for name in by], fontsize=8)
    axes.set_ylim(0, 1.45 * np.nanmax([list(each.values()) for each in by.values()]))
    axes.legend(fontsize=7.5, ncols=2, loc="upper left", handletextpad=0.1, columnspacing=0.8)
    axes.set_title("Option less driver, r.m.s.\nover the second half")
