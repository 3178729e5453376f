"""Figure 7-7: more demonstrations of the same six manoeuvres do not make more subgoals.

One drive of thirty seconds and then up to ten more by the same driver, of a car whose rear wheels are driven; the
number of subgoals that serve at least 3 % of the time against the length of what was recorded, with the setting of
figure 7-6.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.car_methods import temporal
from experiments.car_study import LEAST_SHARE, Run
from experiments.common import GREY, PALETTE, Headline, Options, run, sheet
from subgoal.answers.validation import some_trajectories
from subgoal.dynamics.car import REAR_DRIVE
from subgoal.dynamics.driver import Driven, drive
from subgoal.mdp.planners.outcome import PlanningWarning
from subgoal.runtime.executor import run_all

NAME = "fig_7_7"
DRIVERS = range(100, 125)
"""Seeds of the drivers; none of them had a part in any choice."""
DRIVES = (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11)
SECONDS = 30.0
SIX = 6


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every driver with one drive, two, and so on."""
    drivers = list(DRIVERS)[: 2 if options.quick else None]
    drives = (1, 2, 3) if options.quick else DRIVES
    alone: dict[str, Any] = {"workers": 1} if options.quick else {"workers": None, "backend": "loky"}
    found = run_all(learner, [(seed, drives) for seed in drivers], **alone)
    count = np.array([[each.subgoals for each in row] for row in found])
    v = np.array([[each.v for each in row] for row in found])
    mean, sd = count.mean(axis=0), count.std(axis=0)
    away = np.abs(mean - SIX) <= 2 * sd + 1e-9
    headline = {
        "drivers": drivers, "minutes": np.array(drives) * SECONDS / 60, "n_subgoals": mean, "sd": sd,
        "least": count.min(axis=0), "most": count.max(axis=0), "six_of": [(count == SIX).sum(axis=0), len(drivers)],
        "v_measure": v.mean(axis=0), "v_measure_min": v.min(axis=0), "least_share": LEAST_SHARE,
        "claims": [
            {"claim": "within two standard deviations of six throughout",
             "verdict": "holds" if away.all() else "does not hold"},
            {"claim": "the mean is within a half of six throughout",
             "verdict": "holds" if (np.abs(mean - SIX) <= 0.5).all() else "does not hold"},
        ],
    }  # fmt: skip
    figure = sheet(11.0, 4.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.4, 1))
    _counts(left, np.array(drives) * SECONDS / 60, count)
    _agreement(right, np.array(drives) * SECONDS / 60, v)
    figure.suptitle("Eleven times the data, the same six manoeuvres" if away.all() else "More data, more subgoals",
                    x=0.01, ha="left")  # fmt: skip
    return headline, figure


def learner(seed: int, drives: tuple[int, ...]) -> list[Any]:
    """What is found in the first so many drives of one driver."""
    warnings.simplefilter("ignore", PlanningWarning)
    whole = drive(REAR_DRIVE, trajectories=max(drives), seed=seed)
    return [temporal(Run(first(whole, number), REAR_DRIVE), seed)[0] for number in drives]


def first(driven: Driven, number: int) -> Driven:
    """The first drives alone."""
    some = some_trajectories(driven.demonstrations, np.arange(number))
    return replace(driven, demonstrations=some, labels=driven.labels[: some.n_observations])


def _counts(axes: Axes, minutes: Any, count: Any) -> None:
    mean, sd = count.mean(axis=0), count.std(axis=0)
    axes.axhline(SIX, color=GREY, lw=1, zorder=0)
    axes.fill_between(minutes, mean - 2 * sd, mean + 2 * sd, color=PALETTE[0], alpha=0.15, lw=0)
    axes.plot(minutes, mean, "o-", color=PALETTE[0], label=f"mean of {len(count)} drivers ± 2 standard deviations")
    axes.plot(minutes, count.min(axis=0), "_", color=PALETTE[1], ms=9, label="fewest and most")
    axes.plot(minutes, count.max(axis=0), "_", color=PALETTE[1], ms=9)
    axes.set(ylim=(0, max(10, count.max() + 1)), xlabel="length of what was recorded (min)", ylabel="subgoals",
             title=f"Subgoals that serve at least {100 * LEAST_SHARE:g} % of the time")  # fmt: skip
    axes.legend(loc="lower right")


def _agreement(axes: Axes, minutes: Any, v: Any) -> None:
    axes.plot(minutes, v.mean(axis=0), "o-", color=PALETTE[0], label="mean")
    axes.plot(minutes, v.min(axis=0), "_", color=PALETTE[1], ms=9, label="least")
    axes.set(ylim=(0, 1), xlabel="length of what was recorded (min)", ylabel="V-measure",
             title="Agreement with the script, per step of 0.01 s")  # fmt: skip
    axes.legend(loc="lower right")


if __name__ == "__main__":
    run(NAME, experiment)
