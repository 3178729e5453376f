"""Figure 7-6: six manoeuvres of a model car from thirty unsegmented seconds, by GPSRL in three forms and its rivals.

A simulated driver takes a car whose drift is an unstable equilibrium through stop, straight, left, right, left drift
and right drift. Eight conditions of car and driver, twelve drivers each; one fixed setting for all of them. Beside the
temporal form stand the exchangeable one, the thesis's own with and without the filter of candidates that cannot be
held, an oracle that is given the six true places, and four ways to cut a drive that plan nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.car_methods import (
    SCALES,
    exchangeable,
    gaussian_mixture,
    k_means,
    oracle,
    proximity,
    temporal,
    thesis,
    thesis_with_filter,
)
from experiments.car_pictures import manoeuvre_page
from experiments.car_study import CONDITIONS, Judged, Run, summed
from experiments.common import Headline, Options, run
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.executor import run_all

NAME = "fig_7_6"
DRIVERS = range(100, 112)
"""Seeds of the drivers; none of them had a part in any choice."""
HARD = "RWD n1"
FORMS: dict[str, Callable[[Run, int], Judged]] = {
    "temporal": lambda run, seed: temporal(run, seed)[0],
    "exchangeable": exchangeable,
    "thesis, with filter": thesis_with_filter,
    "thesis": thesis,
    "oracle: the six true places": oracle,
}
PARTS = ("states", "actions", "states and actions")
RIVALS: dict[str, Callable[[Run, int], Judged]] = {
    **{f"k-means, six given, {p}": lambda run, seed, p=p: k_means(run, seed, p) for p in PARTS},  # type: ignore[misc]
    "Gaussian mixture": gaussian_mixture,
    **{
        f"proximity in time, {p}, scale {s:g}": lambda run, seed, p=p, s=s: proximity(run, seed, p, s)  # type: ignore[misc]
        for p in PARTS
        for s in SCALES
    },
}


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The numbers of every condition and method, and the page of one drive."""
    drivers = list(DRIVERS)[: 1 if options.quick else None]
    names = ["AWD n1", HARD] if options.quick else list(CONDITIONS)
    jobs = [(name, seed, options.quick) for name in names for seed in drivers]
    cells = dict(zip([job[:2] for job in jobs], run_all(cell, jobs, workers=None, backend="loky"), strict=True))
    rows: dict[str, Any] = {}
    for name in names:
        found = [cells[name, seed] for seed in drivers]
        rows[name] = {
            method: summed([each["judged"][method] for each in found]) for method in found[0]["judged"]
        } | {"planning": _planning(found)}  # fmt: skip
    hard = rows[HARD]
    best = max((name for name in RIVALS if name in hard), key=lambda name: hard[name]["v_measure"])
    shown = CONDITIONS[HARD].run(drivers[0])
    headline = {
        "drivers": drivers,
        "n_subgoals": hard["temporal"]["n_subgoals"],
        "v_measure": hard["temporal"]["v_measure"],
        "v_measure_min": hard["temporal"]["v_measure_min"],
        "six_of": hard["temporal"]["six_of"],
        "bellman_residual": hard["planning"]["held_out_mean"],
        "all_conditions": _all(rows, cells),
        "best_rival": best,
        "above_best_rival": hard["temporal"]["v_measure"] - hard[best]["v_measure"],
        "conditions": rows,
    }
    return headline, manoeuvre_page(shown, temporal(shown, drivers[0])[1], rows, best)


def cell(name: str, seed: int, quick: bool) -> dict[str, Any]:
    """One driver in one condition, by every method."""
    given = CONDITIONS[name].run(seed)
    start = time.perf_counter()
    judged, found = temporal(given, seed)
    seconds = time.perf_counter() - start
    methods = {**FORMS, **(dict(list(RIVALS.items())[:2]) if quick else RIVALS)}
    del methods["temporal"]
    return {
        "judged": {"temporal": judged, **{method: function(given, seed) for method, function in methods.items()}},
        "seconds_of_learning": seconds,
        **planned(found),
    }


def planned(found: Posterior) -> dict[str, float]:
    """How well its values solve the Bellman equation."""
    source = found.known_likelihood.source
    if not isinstance(source, GaussianProcessValues):
        raise TypeError("a posterior of gpsrl was expected")
    held_out = source.bellman_residuals()
    return {
        "sweep_residual": source.plan.residual, "sweeps": source.plan.residuals.size, "gain": source.plan.gain,
        "held_out_mean": float(held_out.mean()), "held_out_most": float(held_out.max()),
    }  # fmt: skip


def _planning(found: list[dict[str, Any]]) -> dict[str, float]:
    """The most over drivers of what planning says of itself; of the mean held-out residual the mean too."""
    keys = ("sweep_residual", "sweeps", "gain", "held_out_mean", "held_out_most", "seconds_of_learning")
    most = {key: float(np.max([each[key] for each in found])) for key in keys}
    mean = float(np.mean([each["held_out_mean"] for each in found]))
    return {**most, "held_out_mean": mean, "held_out_mean_of_the_worst_driver": most["held_out_mean"]}


def _all(rows: dict[str, Any], cells: dict[Any, Any]) -> Headline:
    """The temporal form over all conditions together."""
    all_of = summed([each["judged"]["temporal"] for each in cells.values()])
    good = np.mean([each["judged"]["temporal"].v >= 0.8 for each in cells.values()])
    behind = max(
        row["oracle: the six true places"]["v_measure"] - row["temporal"]["v_measure"] for row in rows.values()
    )
    del all_of["n_subgoals"]
    return {**all_of, "share_above_0.8": float(good), "most_behind_the_oracle": behind}


if __name__ == "__main__":
    run(NAME, experiment)
