"""Figure 7-9: learned subgoals of a drive, carried out as options from other places, against what was demonstrated.

Thirty seconds of a noisy driver, six subgoals by GPSRL, each an option (thesis 6.6) that looks one step of 0.2 s ahead
and decides anew every 0.1 s; four seconds from standing, straight, left and right, the goal held throughout. A drift of
the rear-driven car is an unstable steady state that grows by e in 0.15 s if nothing is done. Held: no farther from the
subgoal than 0.5 in the metric during the last second.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import linear_sum_assignment

from experiments.car_execution import Skills, executed, option_page
from experiments.car_methods import temporal
from experiments.car_study import CONDITIONS, Run
from experiments.common import Headline, Options, run
from subgoal.demonstrations import Demonstrations
from subgoal.dynamics.car import Car
from subgoal.dynamics.equilibria import manoeuvres
from subgoal.options import ContinuousOption, deviation, execute, option, outcome, stretches
from subgoal.options.comparison import trajectories
from subgoal.runtime.checks import Floats
from subgoal.runtime.executor import run_all

NAME = "fig_7_9"
DRIVERS = range(200, 212)
"""Seeds of the drivers; none of them had a part in any choice."""
HARD = "RWD n1"
SHOWN = (HARD, "AWD n1", "RWD friction −15 %")
STARTS = ("stop", "straight", "left", "right")
SECONDS, WITHIN, NEAR = 4.0, 0.5, 1.0
SHORTEST = 5
"""Pairs of a stretch of demonstration that is compared: 1 s."""
REFINEMENTS: dict[str, Any] = {
    "none": {"starts": 1, "rounds": 0}, "from 1, twice": {"starts": 1, "rounds": 2},
    "from 1, four times": {"starts": 1, "rounds": 4}, "from 4, four times": {},
}  # fmt: skip
"""From how many of the best test actions, and how often; the last is the default."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Counts of what was held, errors against the demonstrations, and the page of one driver."""
    drivers = [1000 * options.seed + seed for seed in list(DRIVERS)[: 1 if options.quick else None]]
    conditions = SHOWN[: 2 if options.quick else None]
    jobs = [(name, seed, options.quick) for name in conditions for seed in drivers]
    workers = 1 if options.quick else None
    found = run_all(cell, jobs, workers=workers, backend="threading" if options.quick else "loky")
    cells = {job[:2]: each for job, each in zip(jobs, found, strict=True)}
    table = {name: summed([cells[name, seed] for seed in drivers]) for name in conditions}
    hard = table[HARD]
    headline: Headline = {
        "drivers": drivers, "grip_held": hard["grip_held"], "grip_tried": hard["grip_tried"],
        "drift_held": hard["drift_held"], "drift_tried": hard["drift_tried"],
        "drift_grows_per_second": manoeuvres(CONDITIONS[HARD].car)["left drift"].growth,
        "rmse": hard["rmse"], "rmse_second_half": hard["rmse_second_half"],
        "driver_second_half": hard["driver_second_half"],
        "drift_held_by_refinement": hard["by_refinement"], "conditions": table,
    }  # fmt: skip
    shown = CONDITIONS[HARD].run(drivers[0])
    return headline, option_page(shown, learned(shown, drivers[0]), table)


def learned(run: Run, seed: int) -> Skills:
    """Option and stretches of each manoeuvre: subgoals served for a second, one to one with the true steady states."""
    found = temporal(run, seed)[1]
    runs = np.split(found.best_assignment, np.flatnonzero(np.diff(found.best_assignment)) + 1)
    used = np.unique([each[0] for each in runs if each.size >= SHORTEST])
    rows, columns = linear_sum_assignment(run.metric.distance(found.candidates.points[used][:, None], run.truth[None]))
    names, skills = list(run.driven.places), {}
    for r, c in zip(rows, columns, strict=True):
        g = int(used[r])
        skills[names[c]] = option(found, g), stretches(found, g, shortest=SHORTEST)
    return skills


def cell(name: str, seed: int, quick: bool) -> dict[str, Any]:
    """One driver: what each option came to from each start, and against each stretch of demonstration."""
    tried = list(REFINEMENTS)[:: 3 if quick else 1]
    condition = CONDITIONS[name]
    given = condition.run(seed)
    places = given.driven.places
    start = np.array([places[each].state for each in STARTS])
    row: dict[str, Any] = {"held": {}, "near": {}, "reached": {}, "whole": {}, "half": {}, "own": {}, "refined": {}}
    skills = learned(given, seed)
    for what in places:
        if what not in skills:
            row["held"][what] = row["near"][what] = [False] * len(start)
            row["reached"][what] = [np.inf] * len(start)
            continue
        skill, shown = skills[what]
        told = outcome(skill, execute(skill, condition.car, start=start, duration=SECONDS, hold=True), within=WITHIN)
        row["held"][what], row["near"][what] = told.held.tolist(), (told.distance <= NEAR).tolist()
        row["reached"][what] = told.reached.tolist()
        row["whole"][what], row["half"][what], row["own"][what] = against_shown(skill, shown, condition.car)
        if "drift" in what and name == HARD:
            row["refined"][what] = {
                how: held(replace(skill, **REFINEMENTS[how]), condition.car, start) for how in tried
            }
    return row


def held(skill: ContinuousOption, car: Car, start: Floats) -> int:
    """From how many starts the goal is held."""
    done = execute(skill, car, start=start, duration=SECONDS, hold=True)
    return int(outcome(skill, done, within=WITHIN).held.sum())


def against_shown(skill: ContinuousOption, shown: Demonstrations, car: Car) -> tuple[Floats, Floats, Floats]:
    """(stretches, 4) root mean square differences from the demonstration, begun in the same state: all, second half.

    And standard deviations of the demonstration over that half.
    """
    done = executed(skill, shown, car)
    own = np.array([part[len(part) // 2 :].std(axis=0) for part in trajectories(shown)])
    return deviation(skill.metric, done, shown), deviation(skill.metric, done, shown, after=0.5), own


def summed(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts and errors over drivers."""
    names = list(rows[0]["held"])
    tried = len(rows) * len(STARTS)
    by = {what: [*(int(np.sum([row[part][what] for row in rows])) for part in ("held", "near")), tried]
          for what in names}  # fmt: skip
    drift, grip = ([what for what in names if ("drift" in what) == wanted] for wanted in (True, False))
    out: dict[str, Any] = {
        f"{kind}_{what}": sum(by[name][k] for name in of)
        for kind, of in (("grip", grip), ("drift", drift))
        for k, what in enumerate(("held", "within_1", "tried"))
    }
    times = np.concatenate([np.ravel(row["reached"][what]) for row in rows for what in names])
    out |= {
        "drivers": len(rows), "by_manoeuvre": by, "reached": int(np.isfinite(times).sum()),
        "median_seconds_to_reach": round(float(np.median(times)), 6),
    }  # fmt: skip
    for key, part in (("rmse", "whole"), ("rmse_second_half", "half"), ("driver_second_half", "own")):
        each = {what: pooled([row[part][what] for row in rows if what in row[part]]) for what in names}
        out[key] = pooled([row[part][what] for row in rows for what in row[part]])
        out[f"{key}_by_manoeuvre"] = each
    refined = [part for row in rows for part in row["refined"].values()]
    out["by_refinement"] = {name: sum(part[name] for part in refined) for name in refined[0]} if refined else {}
    return out


def pooled(parts: list[Floats]) -> dict[str, float]:
    """Root mean square over stretches, by dimension of the state; NaN where there are none."""
    all_of = np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0)) if parts else np.full(len(Car.names), np.nan)
    return dict(zip(Car.names, all_of.tolist(), strict=True))


if __name__ == "__main__":
    run(NAME, experiment)
