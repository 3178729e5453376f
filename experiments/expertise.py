"""How exactly a driver holds one turn, as the confidence with an interval (thesis 7.3.1), and whether that is right.

The same right turn by drivers of eight noise levels: does the estimate order them? And actions drawn from the model
itself at a known confidence: how often does the 90 % interval hold it, drawn one by one and drawn in series.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import norm, spearmanr

import subgoal
from experiments.car_study import EVERY, FLOOR
from experiments.common import GREY, INK, MARKERS, PALETTE, Headline, Options, run, sheet
from subgoal.continuous import ContinuousWorld, action_grid, expertise, gp_actions, hold_actions, spread_metric
from subgoal.demonstrations import Demonstrations
from subgoal.dynamics.car import ALL_DRIVE
from subgoal.dynamics.driver import drive
from subgoal.dynamics.equilibria import steady_state
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.checks import Floats
from subgoal.runtime.executor import run_all
from subgoal.runtime.seeds import stream

NAME = "expertise"
DRIVERS = range(100, 104)
NOISES = np.round(np.geomspace(0.7, 4.2, 8), 2)
STEP, RADIUS = 0.2, 0.5
TURN = {"right": steady_state(ALL_DRIVE, (-0.2, 1.5), (1.45, 0.0, -1.4, 1.5))}
FINE, COARSE = 33, 17
"""Test actions along each of the two dimensions: to tell drivers, and where α is moderate and known."""
KNOWN = (10.0, 30.0)
SETS = 200
SERIES = 0.8
"""Correlation of the ranks of neighbouring actions that are drawn in series."""
LEVEL = 0.9


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Drivers by their noise, and intervals by how often they hold the truth."""
    drivers = list(DRIVERS)[: 1 if options.quick else None]
    noises = NOISES[3::2] if options.quick else NOISES
    per_axis = COARSE if options.quick else FINE
    alone: dict[str, Any] = {"workers": 1} if options.quick else {"workers": None, "backend": "loky"}
    told = run_all(by_noise, [(seed, noises, per_axis) for seed in drivers], **alone)
    median = np.array([[each.confidence for each in row] for row in told])
    open_above = np.array([[each.open_above for each in row] for row in told])
    rank = [float(spearmanr(noises, row).statistic) for row in median]
    sets, known = (5, KNOWN[:1]) if options.quick else (SETS, KNOWN)
    jobs = [(alpha, series, sets, options.seed) for alpha in known for series in (0.0, SERIES)]
    held = {
        f"α = {alpha:g}, {'in series' if series else 'one by one'}": row
        for (alpha, series, *_), row in zip(jobs, run_all(coverage, jobs, **alone), strict=True)
    }
    headline = {
        "drivers": drivers, "noises": noises, "confidence": median, "open_above": open_above.sum(axis=0),
        "low": [[each.interval[0] for each in row] for row in told],
        "high": [[each.interval[1] for each in row] for row in told],
        "worth": [[each.worth for each in row] for row in told],
        "rank_correlation": rank, "rank_correlation_most": max(rank), "slope": slope(noises, median, open_above),
        "coverage": held, "sets": sets, "level": LEVEL,
        "claims": [
            {"claim": "rank correlation of at most -0.9 with the noise, every driver",
             "verdict": "holds" if max(rank) <= -0.9 else "does not hold"},
            {"claim": "90 % intervals hold the truth in at least 85 %, every case",
             "verdict": "holds" if all(row["weighed"] >= 0.85 for row in held.values()) else "does not hold"},
        ],
    }  # fmt: skip
    figure = sheet(11.5, 4.8)
    left, right = figure.subplots(1, 2, width_ratios=(1.35, 1))
    _drivers(left, noises, told, max(rank))
    _coverage(right, held)
    figure.suptitle("The confidence of a driver says how exactly a turn is held", x=0.01, ha="left")
    return headline, figure


def by_noise(seed: int, noises: Floats, per_axis: int) -> list[Any]:
    """Expertise of one driver at each noise: one plan, made of all drives, so that α means the same throughout."""
    parts = [turn(float(noise), seed) for noise in noises]
    whole = planned(parts, per_axis)
    return [expertise(same_likelihood(whole, part), level=LEVEL) for part in parts]


def turn(noise: float, seed: int) -> Demonstrations:
    """The right turn held for thirty seconds; a pair every 0.2 s."""
    driven = drive(ALL_DRIVE, [("right", 30.0)], places=TURN, noise=noise, seed=seed)
    return hold_actions(driven.demonstrations, EVERY)


def planned(parts: list[Demonstrations], per_axis: int) -> LogLikelihood:
    """The table of all drives together."""
    n = np.cumsum([0, *(part.n_observations for part in parts)])
    pooled = Demonstrations(
        np.concatenate([part.states for part in parts]), np.concatenate([part.actions for part in parts]), n
    )
    net = subgoal.epsilon_net(pooled, RADIUS, metric=spread_metric(np.asarray(pooled.states), floor=FLOOR))
    tests = action_grid(*ALL_DRIVE.bounds, per_axis)
    return gp_actions(pooled, net, ContinuousWorld(ALL_DRIVE, *ALL_DRIVE.bounds, step=STEP, test_actions=tests))


def coverage(alpha: float, series: float, sets: int, seed: int) -> dict[str, float]:
    """Share of the intervals that hold α: with the weight that the data give, and with none."""
    part = turn(2.0, DRIVERS[0])
    whole = planned([part], COARSE)
    source = whole.source
    if not isinstance(source, GaussianProcessValues):
        raise TypeError("a likelihood of Gaussian-process planning was expected")
    goal = int(np.asarray(whole.at(alpha).dense).sum(axis=0).argmax())
    near = source.metric.distance(source.candidates.points, source.candidates.points[goal]).argsort()[:4]
    plan = source.plan.only(near)
    few = replace(source, plan=plan, candidates=source.candidates.some(near))
    tested = few.tested(0, part.n_observations)[:, :, 0]
    chance = np.exp(alpha * (tested - tested.max(axis=1, keepdims=True)))
    below = (chance / chance.sum(axis=1, keepdims=True)).cumsum(axis=1)
    held = {"weighed": 0.0, "unweighed": 0.0, "worth": 0.0, "width": 0.0}
    for k in range(sets):
        generator = stream(seed, k)
        drawn = (below < ranks(len(tested), series, generator)[:, None]).sum(axis=1)
        actions = source.world.test_actions[np.minimum(drawn, len(source.world.test_actions) - 1)]
        ahead = source.world.ahead(source.states, actions, source.metric)
        own = replace(few, action=actions, ahead_of_taken=ahead)
        own.__dict__["_whole"] = few.tested(0, part.n_observations)
        own.__dict__["unit"] = few.unit
        table = replace(whole, source=own, candidates=own.candidates)
        for name, weight in (("weighed", None), ("unweighed", 1.0)):
            found = expertise(table, level=LEVEL, weight=weight)
            held[name] += (found.interval[0] <= alpha <= found.interval[1]) / sets
            if weight is None:
                held["worth"] += found.worth / sets
                held["width"] += found.interval[1] / found.interval[0] / sets
    return held


def ranks(n: int, series: float, generator: np.random.Generator) -> Floats:
    """(n,) uniform numbers, neighbours of which are correlated through a Gaussian of that correlation."""
    shocks = generator.standard_normal(n)
    value = shocks.copy()
    for i in range(1, n):
        value[i] = series * value[i - 1] + np.sqrt(1 - series**2) * shocks[i]
    return np.asarray(norm.cdf(value))


def slope(noises: Floats, median: Floats, open_above: Any) -> float:
    """d log α / d log noise, over those whose test actions are fine enough."""
    sure = ~open_above.any(axis=0)
    return float(np.polyfit(np.log(noises[sure]), np.log(median[:, sure]).mean(axis=0), 1)[0])


def _drivers(axes: Axes, noises: Floats, told: list[Any], rank: float) -> None:
    for k, row in enumerate(told):
        at = noises * (1 + 0.015 * (k - (len(told) - 1) / 2))
        reach = np.array([[each.confidence - each.interval[0], each.interval[1] - each.confidence] for each in row])
        axes.errorbar(at, [each.confidence for each in row], yerr=reach.T, fmt=f"{MARKERS[k]}-", ms=5, lw=1,
                      color=PALETTE[k], capsize=2, label=f"driver {k + 1}")  # fmt: skip
        for x, each in zip(at, row, strict=True):
            if each.open_above:
                axes.annotate("", (x, each.searched[1] * 1.35), (x, each.searched[1]),
                              arrowprops={"arrowstyle": "->", "color": PALETTE[k], "lw": 1})  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel="noise of the driver", ylabel="confidence α (nats per whole future)",
             title=f"One right turn, held for 30 s: rank correlation {rank:.2f} at worst; bars 90 %")  # fmt: skip
    axes.set_ylim(8, 500)
    axes.set_xticks([0.7, 1, 1.5, 2, 3, 4], ["0.7", "1", "1.5", "2", "3", "4"])
    axes.minorticks_off()
    axes.text(0.02, 0.04, "arrow: no upper end, test actions are too far apart", transform=axes.transAxes, color=GREY)
    axes.legend(loc="upper right")


def _coverage(axes: Axes, held: dict[str, dict[str, float]]) -> None:
    for k, (name, ink, label) in enumerate(
        (("weighed", PALETTE[0], "observations weighed (default)"), ("unweighed", PALETTE[1], "each counts as one"))
    ):
        axes.plot([row[name] for row in held.values()], np.arange(len(held)) + 0.12 * (k - 0.5), MARKERS[k], ms=8,
                  color=ink, label=label)  # fmt: skip
    axes.axvline(LEVEL, color=INK, lw=1, ls="--")
    axes.set_yticks(range(len(held)), list(held))
    axes.set(xlim=(0.0, 1.0), ylim=(len(held) - 0.4, -0.8), xlabel="share of the 90 % intervals that hold the truth",
             title="Actions drawn from the model itself")  # fmt: skip
    axes.legend(loc="upper left", fontsize=8.5)


if __name__ == "__main__":
    run(NAME, experiment)
