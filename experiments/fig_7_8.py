"""Figure 7-8: how many subgoals there are at each confidence, of a drive with right turns of three radii.

Eight drivers at half and at full noise; three samplers side by side; the confidence at which a second subgoal appears
in closed form; and the thesis's own protocol, fifty chains of 1,500 sweeps at each level, with the time it took.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.car_pictures import drawn_path, strips
from experiments.car_study import LEAST_SHARE
from experiments.common import GREY, INK, MARKERS, PALETTE, Headline, Options, run, sheet
from experiments.turn_study import LEVELS, METHODS, PLATEAU, THREE, Turns, as_sweep, last_draws, of_plateau
from subgoal.continuous import confidence_sweep, second_subgoal
from subgoal.irl.sweep_record import Sweep
from subgoal.mdp.planners.outcome import PlanningWarning
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.executor import run_all
from subgoal.runtime.progress import Silent

NAME = "fig_7_8"
DRIVERS = range(300, 308)
"""Seeds of the drivers; none of them had a part in any choice of figure 7-6."""
NOISES = (0.5, 1.0)
TRIALS = 5
SHOWN = 15.0
ONE_UP_TO = 2.0
WIDE = {0.5: 6.0, 1.0: 1.5}
"""Least width of the plateau of three, in ratio, by the noise of the driver."""
INKS = dict(zip(METHODS, (PALETTE[0], PALETTE[4], PALETTE[1]), strict=True))


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Counts and V-measures of all drives, the protocol of the thesis on one, and their page."""
    drivers = list(DRIVERS)[: 1 if options.quick else None]
    trials = 2 if options.quick else TRIALS
    jobs = [(noise, seed, trials) for noise in NOISES for seed in drivers]
    alone: dict[str, Any] = {"workers": 1} if options.quick else {"workers": None, "backend": "loky"}
    cells = dict(zip([job[:2] for job in jobs], run_all(cell, jobs, **alone), strict=True))
    rows = {f"noise {noise:g}": summed([cells[noise, seed] for seed in drivers]) for noise in NOISES}
    table = Turns(1.0, drivers[0]).table()
    protocol = confidence_sweep(
        table, LEVELS[::2] if options.quick else LEVELS[:12], trials=5 if options.quick else 50,
        sweeps=300 if options.quick else 1500, progress=Silent(),
    )  # fmt: skip
    headline: Headline = {
        "drivers": drivers, "confidences": LEVELS, "noises": rows, "sweep_seconds": protocol.seconds,
        "sweep": {"confidences": protocol.confidences, "mean": protocol.mean, "sd": protocol.sd,
                  "trials": protocol.counts.shape[1], "sweeps": protocol.settings["sweeps"],
                  "plateau_of_three": plateau(protocol), "one_up_to": protocol.last_with_one},
        "claims": claims(rows),
    }  # fmt: skip
    return headline, page(rows, protocol, Turns(1.0, drivers[0]), cells[1.0, drivers[0]]["second"])


def cell(noise: float, seed: int, trials: int) -> dict[str, Any]:
    """One driver by every sampler: subgoals and V-measure (L, trials) at each level, and α* in closed form."""
    warnings.simplefilter("ignore", PlanningWarning)
    drive = Turns(noise, seed)
    tables = {hold: drive.table(hold) for hold in {method.hold for method in METHODS.values()}}
    found: dict[str, Any] = {"second": second_subgoal(tables[None]).confidence}
    source: Any = tables[None].source
    found["residual"], found["candidates"] = source.plan.residual, tables[None].n_candidates
    for name, method in METHODS.items():
        judged = [
            [drive.run.judged(draw) for draw in last_draws(tables[method.hold], method, level, trials, seed)]
            for level in range(LEVELS.size)
        ]
        found[name] = {
            "count": np.array([[each.subgoals for each in row] for row in judged]),
            "v": np.array([[each.v for each in row] for row in judged]),
        }
    return found


def summed(cells: list[dict[str, Any]]) -> dict[str, Any]:
    """Over drivers."""
    row: dict[str, Any] = {
        "second_subgoal": float(np.median([each["second"] for each in cells])),
        "second_subgoal_of_each": [each["second"] for each in cells],
        "candidates": [each["candidates"] for each in cells],
        "largest_residual": float(np.max([each["residual"] for each in cells])),
    }
    for name in METHODS:
        swept = as_sweep(np.concatenate([each[name]["count"] for each in cells], axis=1))
        by_driver = np.array([each[name]["count"].mean(axis=1) for each in cells])
        v = np.concatenate([each[name]["v"] for each in cells], axis=1).mean(axis=1)
        row[name] = {
            "mean": swept.mean, "sd": swept.sd, "most": swept.counts.max(axis=1), "v_measure": v,
            "sd_between_drivers": by_driver.std(axis=0), "plateau_of_three": plateau(swept),
            "one_up_to": swept.last_with_one, "drivers": len(cells),
        }  # fmt: skip
    return row


def plateau(swept: Sweep) -> dict[str, float]:
    """Where three subgoals last."""
    found = swept.plateau(THREE)
    return {"low": found.low, "high": found.high, "ratio": found.ratio}


def claims(rows: dict[str, Any]) -> list[dict[str, str]]:
    """The thesis's three ranges, with numbers to them."""
    kinds = [(f"noise {noise:g}", noise) for noise in NOISES]
    mine = {name: rows[name]["temporal"] for name, _ in kinds}
    low = LEVELS <= ONE_UP_TO
    three = np.array([of_plateau(np.asarray(each["mean"])) for each in mine.values()])
    fit = np.array([of_plateau(np.asarray(each["v_measure"])) for each in mine.values()])
    told = {
        f"one subgoal in every chain of every driver up to confidence {ONE_UP_TO:g}":
            all((each["most"][low] == 1).all() for each in mine.values()),
        f"on average 2.7 to 3.3 subgoals at {PLATEAU[0]:g} and {PLATEAU[1]:g}": (np.abs(three - THREE) <= 0.3).all(),
        f"V-measure of at least 0.8 at {PLATEAU[0]:g} and {PLATEAU[1]:g}": (fit >= 0.8).all(),
        "more subgoals at the highest confidence": all(each["mean"][-1] > THREE + 0.5 for each in mine.values()),
        **{f"three last over a factor of {WIDE[noise]:g} at {name}":
           mine[name]["plateau_of_three"]["ratio"] >= WIDE[noise] for name, noise in kinds},
    }  # fmt: skip
    return [{"claim": words, "verdict": "holds" if yes else "does not hold"} for words, yes in told.items()]


def page(rows: dict[str, Any], protocol: Sweep, drive: Turns, second: float) -> Figure:
    """The drive with its subgoals; the thesis's protocol; drivers; samplers side by side."""
    figure = sheet(13.0, 11.0)
    grid = figure.add_gridspec(3, 2, height_ratios=(3.2, 0.55, 3.0))
    label = coloured(drive)
    drawn_path(figure.add_subplot(grid[0, 0]), drive.run, label)
    strips(figure.add_subplot(grid[1, :]), drive.run, label, list(drive.run.driven.places))
    _protocol(figure.add_subplot(grid[0, 1]), protocol, second)
    _drivers(figure.add_subplot(grid[2, 0]), rows)
    _samplers(figure.add_subplot(grid[2, 1]), rows["noise 1"])
    figure.suptitle("One, three, many: what the confidence makes of turns of three radii", x=0.01, ha="left")
    return figure


def coloured(drive: Turns) -> Ints:
    """(N,) number of the radius nearest to the subgoal of each pair at α = 15; −1 for subgoals below 3 %."""
    table = drive.table()
    label = last_draws(table, METHODS["temporal"], int(np.flatnonzero(LEVELS == SHOWN)[0]), 1, drive.seed)[0]
    near = drive.run.metric.distance(table.candidates.points[:, None], drive.run.truth[None]).argmin(axis=1)
    served = np.bincount(label, minlength=near.size) >= LEAST_SHARE * label.size
    return np.asarray(np.where(served, near, -1)[label])


def _curve(axes: Axes, mean: Floats, sd: Floats, ink: str, label: str, marker: str, shift: float = 1.0) -> None:
    at = LEVELS[: len(mean)] * shift
    axes.errorbar(at, mean, yerr=2 * np.asarray(sd), color=ink, fmt=f"{marker}-", ms=5, lw=1.4, capsize=2, label=label)


def _counting(axes: Axes, title: str) -> None:
    axes.axhline(THREE, color=GREY, lw=1, zorder=0)
    axes.set(xscale="log", xlabel="confidence α (nats per whole future)", ylabel="number of subgoals", title=title)
    axes.set_ylim(0, 13)
    axes.legend(loc="upper left", fontsize=8.5)


def _protocol(axes: Axes, protocol: Sweep, second: float) -> None:
    chains, sweeps = protocol.counts.shape[1], protocol.settings["sweeps"]
    axes.errorbar(protocol.confidences, protocol.mean, yerr=2 * protocol.sd, color=INK, fmt="o-", ms=5, capsize=2)
    axes.axvline(
        second, color=PALETTE[3], lw=1.2, ls="--", label=f"a second subgoal, in closed form: α* = {second:.2g}"
    )
    title = f"One drive as in the thesis: {chains} chains of {sweeps:,} sweeps (± 2 sd), {protocol.seconds:.0f} s"
    _counting(axes, title)


def _drivers(axes: Axes, rows: dict[str, Any]) -> None:
    for k, (name, row) in enumerate(rows.items()):
        mine, ink = row["temporal"], (PALETTE[2], PALETTE[0])[k]
        wide, at = mine["plateau_of_three"]["ratio"], row["second_subgoal"]
        label = f"{name}: three over a factor of {wide:.2g}; α* = {at:.2g}"
        _curve(axes, mine["mean"], mine["sd"], ink, label, MARKERS[k], 1 + 0.04 * k)
        axes.axvline(at, color=ink, lw=1.1, ls="--")
    _counting(axes, f"{row['temporal']['drivers']} drivers each, subgoals that persist (± 2 sd)")


def _samplers(axes: Axes, row: dict[str, Any]) -> None:
    for k, name in enumerate(METHODS):
        best = float(np.max(row[name]["v_measure"]))
        label = f"{name} (V-measure at its best α: {best:.2f})"
        _curve(axes, row[name]["mean"], row[name]["sd"], INKS[name], label, MARKERS[k], 1 + 0.04 * k)
    _counting(axes, "Samplers side by side, noise 1 (± 2 sd)")


if __name__ == "__main__":
    run(NAME, experiment)
