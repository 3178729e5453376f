"""Figure 7-8 on recorded turns: three right turns of different radius, driven one after the other; are they three?

A 1:5 vehicle (simulated, AutoDRIVE) drives circles with three steering angles, open loop. The three recordings are
three trajectories, and nothing says which is which; the true answer is three.

* Kept is what was driven at full throttle: before it the vehicle stands, after it the simulator puts it back at the
  start. The first row of a file is a placeholder, and stands too.
* The throttle never changes there: nothing was chosen, so that the steering alone is the action.
* The state is speed and yaw rate. There is no slip: the velocity sideways stays within 0.006 m/s and would be noise
  in units of itself.
* Where actions lead is learned from the same recordings. They hold next to no change: at each steering angle one start
  of 1.5 s, else a steady circle. Held-out stretches of time therefore say nothing of a model (their error is 0 for
  "the state stays"). Kinds of model are compared on the recording, so the steering angle, that was left out.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.car_methods import marginal_modes
from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from experiments.recorded_study import Answer, Settings, agreement, answer, forecast_error, main_of, planned, quietly
from subgoal.answers.validation import some_trajectories
from subgoal.continuous import held_rows, hold_actions, spread_metric
from subgoal.demonstrations import Demonstrations
from subgoal.dynamics import Dynamics, learn_dynamics
from subgoal.likelihood.gp_actions import DEFAULT_CONFIDENCE
from subgoal.runtime.checks import Floats, Ints

RATE = 20.0
"""Hz, after resampling; the simulator writes about 27 a second, unevenly."""
EVERY = 4
"""Samples that one held action lasts: 0.2 s."""
COLUMNS = (
    "timestamp", "throttle", "steering", "left", "right", "x", "y", "z", "roll", "pitch", "yaw", "speed", "rate_x",
    "rate_y", "rate_z", "acc_x", "acc_y", "acc_z",
)  # fmt: skip
KINDS = ("linear", "neighbours", "gp")
HORIZON = 3.0
"""Seconds of a forecast: from a start to the steady circle."""
CLOCK = "%Y_%m_%d_%H_%M_%S_%f"
CONFIDENCES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 3.0, 5.0, 10.0, 15.0, 30.0, 60.0, 240.0, 1000.0)
QUICK = (0.02, 1.0, 15.0, 60.0)
SWEEPS: dict[str, Any] = {"chains": 2, "warmup": 50, "draws": 50, "thin": 1}
ANNEALING = 75
"""Sweeps in which the concentration of the exchangeable model falls."""
SEEDS, MORE_SEEDS = 1, 8


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The three turns with the default settings, and what α does."""
    turns, paths, radii = read_turns(options.recordings)
    pairs = hold_actions(turns, EVERY)
    errors = {kind: left_out(turns, kind, options.seed) for kind in KINDS}
    kind = min(KINDS, key=lambda each: max(errors[each]))
    dynamics = quietly(learn_dynamics, turns, step=EVERY / RATE, kind=kind, seed=options.seed)
    settings = Settings(spread_metric(np.asarray(turns.states)), bounds_of(turns), SWEEPS)
    found = answer(pairs, dynamics, settings, options.seed)
    true = pairs.trajectory
    seeds = range(options.seed, options.seed + (SEEDS if options.quick else MORE_SEEDS))
    headline: Headline = {
        "n_subgoals": found.goals.n_candidates,
        **agreement(true, found.label),
        "exchangeable": exchangeable(pairs, dynamics, settings, options.seed),
        "subgoals": [
            {"speed": p[0], "yaw_rate": p[1], "radius": abs(p[0] / p[1]) if p[1] else None, "share": share}
            for p, share in zip(found.goals.points.tolist(), found.shares.tolist(), strict=True)
        ],
        "true_radii": radii,
        "dynamics": kind,
        "held_out_error": errors,
        "bellman_residual": planned(found.found),
        "pairs": pairs.n_observations,
        "confidence": DEFAULT_CONFIDENCE,
        "sweep": sweep(pairs, dynamics, settings, QUICK if options.quick else CONFIDENCES, seeds),
    }
    return headline, picture(turns, paths, found, headline)


def read_turns(folder: Path) -> tuple[Demonstrations, Floats, Floats]:
    """The three recordings as three trajectories at ``RATE``, their paths (M, 2), and the radii (3,) of the circles."""
    states, actions, paths, times, radii = [], [], [], [], []
    for path in sorted(folder.glob("skidpad_cw_*.csv")):
        seconds, table = read_drive(path)
        clock = seconds[0] + np.arange(int((seconds[-1] - seconds[0]) * RATE + 1e-9) + 1) / RATE
        at = {name: np.interp(clock, seconds, table[name]) for name in ("speed", "rate_z", "steering", "x", "y")}
        states.append(np.stack([at["speed"], at["rate_z"]], axis=1))
        actions.append(at["steering"][:, None])
        paths.append(np.stack([at["x"], at["y"]], axis=1))
        times.append(clock)
        radii.append(np.ptp(paths[-1], axis=0).mean() / 2)
    turns = Demonstrations(
        states=np.concatenate(states), actions=np.concatenate(actions), times=np.concatenate(times),
        offset=np.cumsum([0, *map(len, times)]), names=("speed", "yaw rate"),
    )  # fmt: skip
    return turns, np.concatenate(paths), np.array(radii)


def read_drive(path: Path) -> tuple[Floats, pd.DataFrame]:
    """Seconds (M,) and rows of one file while the throttle is at its greatest."""
    table = pd.read_csv(path, header=None, names=list(COLUMNS))
    clock = pd.to_datetime(table["timestamp"], format=CLOCK)
    seconds = (clock - clock.iloc[0]).dt.total_seconds().to_numpy(float)
    driven = np.flatnonzero(table["throttle"] == table["throttle"].max())
    rows = slice(driven[0], driven[-1] + 1)
    return np.asarray(seconds[rows], float), table.iloc[rows]


def bounds_of(turns: Demonstrations) -> tuple[Floats, Floats]:
    """Least and greatest steering."""
    actions = np.asarray(turns.actions, float)
    return actions.min(axis=0), actions.max(axis=0)


def left_out(turns: Demonstrations, kind: str, seed: int) -> list[float]:
    """Root mean square error of speed and yaw rate 3 s ahead, over the standard deviation of the states.

    Of each recording, by dynamics learned from the other two: at a steering angle that was never seen.
    """
    errors = []
    for k in range(turns.n_trajectories):
        others = np.array([j for j in range(turns.n_trajectories) if j != k])
        error, _ = forecast_error(
            some_trajectories(turns, others), some_trajectories(turns, np.array([k])), step=EVERY / RATE,
            horizon=HORIZON, told=turns.names, kind=kind, seed=seed,
        )  # fmt: skip
        errors.append(error)
    spread = np.asarray(turns.states).std(axis=0)
    return [float(share) for share in np.sqrt(np.concatenate(errors).mean(axis=0)) / spread]


def exchangeable(pairs: Demonstrations, dynamics: Dynamics, settings: Settings, seed: int) -> Headline:
    """The same where the order of the pairs, and so the file they are in, says nothing."""
    found = Settings(settings.metric, settings.bounds, {**settings.learning, "dwell": 0, "warmup": ANNEALING})
    label = marginal_modes(found.learn(pairs, dynamics, seed))
    return {"n_subgoals": main_of(label).size, **agreement(pairs.trajectory, label)}


def sweep(
    pairs: Demonstrations, dynamics: Dynamics, settings: Settings, confidences: tuple[float, ...], seeds: range
) -> list[Headline]:
    """For each α, how many subgoals serve 5 % of the pairs in the best draw of each seed, and their V-measures."""
    rows = []
    for confidence in confidences:
        each = Settings(settings.metric, settings.bounds, {**settings.learning, "confidence": confidence})
        label = [each.learn(pairs, dynamics, seed).best_assignment for seed in seeds]
        rows.append({
            "confidence": confidence, "n_subgoals": [main_of(one).size for one in label],
            "v_measure": [agreement(pairs.trajectory, one)["v_measure"] for one in label],
        })  # fmt: skip
    return rows


def picture(turns: Demonstrations, paths: Floats, found: Answer, headline: Headline) -> Figure:
    """The circles in the colours of their subgoals, the states, and how many there are by α."""
    figure = sheet(13.0, 7.6)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1))
    label = found.label[held_rows(turns, EVERY)]
    circles(figure.add_subplot(grid[:, 0]), turns, paths, label, headline)
    portrait(figure.add_subplot(grid[0, 1]), found)
    by_confidence(figure.add_subplot(grid[1, 1]), headline)
    figure.suptitle(f"Three right turns, driven without a word: {headline['n_subgoals']} subgoals found", x=0.01,
                    ha="left")  # fmt: skip
    return figure


def circles(axes: Axes, turns: Demonstrations, paths: Floats, label: Ints, headline: Headline) -> None:
    """Each recording from above, laid so that their centres are the same."""
    for k, (begin, end) in enumerate(zip(turns.offset[:-1], turns.offset[1:], strict=True)):
        xy = paths[begin:end]
        xy = xy - (xy.max(axis=0) + xy.min(axis=0)) / 2
        axes.scatter(xy[:, 0], xy[:, 1], s=7, c=[PALETTE[g] for g in label[begin:end]], lw=0)
        axes.plot(*xy[0], "o", color=INK, ms=5)
        radius = headline["true_radii"][k]
        axes.annotate(f"{radius:.2f} m", (0, -radius), xytext=(0, 6), textcoords="offset points", ha="center")
    axes.set_aspect("equal")
    axes.set(title="The circles, one about the other, in the colours of the subgoals (dots: starts)", xlabel="x (m)",
             ylabel="y (m)")  # fmt: skip


def portrait(axes: Axes, found: Answer) -> None:
    """Pairs by speed and yaw rate; large marks are the subgoals."""
    states = np.asarray(found.pairs.states)
    axes.scatter(states[:, 0], states[:, 1], s=14, c=[PALETTE[k] for k in found.label], lw=0)
    for k, (speed, rate) in enumerate(found.goals.points):
        axes.plot(speed, rate, "o", color=PALETTE[k], mec="white", ms=15, zorder=3)
        told = f"{speed:.2f} m/s, {rate:.2f} rad/s\n{found.shares[k]:.0%} of the pairs"
        axes.annotate(told, (speed, rate), xytext=(-6, -9), textcoords="offset points", ha="right", va="top",
                      fontsize=8.5, color=PALETTE[k])  # fmt: skip
    axes.margins(y=0.25)
    axes.set(title="Every pair (dots) and the subgoals", xlabel="speed (m/s)", ylabel="yaw rate (rad/s)")


def by_confidence(axes: Axes, headline: Headline) -> None:
    """Number of subgoals over α: mean and range over seeds."""
    rows = headline["sweep"]
    alpha = [row["confidence"] for row in rows]
    counts = [np.array(row["n_subgoals"]) for row in rows]
    axes.fill_between(alpha, [c.min() for c in counts], [c.max() for c in counts], color=PALETTE[4], alpha=0.35, lw=0)
    axes.plot(alpha, [c.mean() for c in counts], "o-", color=PALETTE[0])
    axes.axhline(3, color=GREY, lw=1, zorder=0)
    axes.axvline(headline["confidence"], color=PALETTE[1], lw=1.2)
    axes.annotate("default", (headline["confidence"], 0.3), xytext=(4, 0), textcoords="offset points", color=PALETTE[1])
    axes.set_xscale("log")
    axes.set_ylim(0, max(c.max() for c in counts) + 0.7)
    axes.set(title="How many subgoals serve 5 % of the pairs: mean and range over seeds", xlabel="confidence α",
             ylabel="subgoals")  # fmt: skip


if __name__ == "__main__":
    run("skidpad", experiment, needs="hunter_se_sim")
