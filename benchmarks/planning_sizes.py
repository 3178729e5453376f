"""``python -m benchmarks.planning_sizes --out DIR``: planning for 80 subgoals against the size of the world.

Draws a figure for grids of 20 × 20 to 1,000 × 1,000 cells. Beside it, compiled value iteration and the package
mdpsolver, a goal at a time, scaled up from one goal, as far as they go in reasonable time.
"""

from __future__ import annotations

import argparse
import io
import json
from pathlib import Path

import numpy as np

from benchmarks.common import peak_megabytes, seconds
from benchmarks.planning import ACCURACY, GOALS, TOP, by_mdpsolver, goals_along_a_walk, grid, plain
from experiments.common import INK, PALETTE, figure_style, save, sheet
from subgoal.mdp.planners.first_passage import plan_subgoals

SIDES = (20, 50, 100, 200, 500, 1000)
LARGEST_PEER = 100
FEW = 2
"""Runs of sizes above ``LARGEST_PEER``."""


def main() -> None:
    """Time, print a line for each size, draw."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.planning_sizes")
    parser.add_argument("--out", type=Path, required=True)
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    rows = [measure(side) for side in SIDES]
    save(out / "planning_sizes.json", (json.dumps(rows, indent=1) + "\n").encode())
    save(out / "planning_sizes.png", picture(rows))


def measure(side: int) -> dict[str, float]:
    """Seconds for one size; the memory is that of the process so far."""
    world = grid(side)
    built = seconds(lambda: world.mdp, repeats=1, warm=False)
    goals = goals_along_a_walk(world)
    kept = goals[:1] if side > LARGEST_PEER else None
    plan_subgoals(world.mdp, goals[:1], states=goals[:1], tolerance=ACCURACY * TOP)
    repeats = 5 if side <= LARGEST_PEER else FEW if side < SIDES[-1] else 1
    ours = seconds(
        lambda: plan_subgoals(world.mdp, goals, states=kept, tolerance=ACCURACY * TOP), repeats=repeats, warm=False
    )
    row = {"side": side, "states": side * side, "seconds": ours, "world_seconds": built, "megabytes": peak_megabytes()}
    if side <= LARGEST_PEER:
        exact = plan_subgoals(world.mdp, goals[:1], tolerance=1e-9 * TOP).value
        row["value_iteration"] = plain(world.mdp, exact, goals, count=1)[0]
        row["mdpsolver"] = by_mdpsolver(world.mdp, int(goals[0]))[0] * GOALS
    print(json.dumps(row), flush=True)
    return row


def picture(rows: list[dict[str, float]]) -> bytes:
    """Both axes logarithmic."""
    with figure_style():
        figure = sheet(6.5, 4.6)
        axis = figure.subplots()
        for k, (key, name) in enumerate((
            ("seconds", "subgoal: all 80 at once"), ("mdpsolver", "mdpsolver value iteration × 80"),
            ("value_iteration", "compiled value iteration × 80"),
        )):  # fmt: skip
            shown = [row for row in rows if key in row]
            x, y = (np.array([row[field] for row in shown]) for field in ("states", key))
            axis.plot(x, y, "o-", color=PALETTE[k], label=name)
            axis.annotate(f"{y[-1]:.2g} s", (x[-1], y[-1]), xytext=(0, 7), textcoords="offset points", ha="center",
                          fontsize=8.5, color=INK)  # fmt: skip
        axis.set(xscale="log", yscale="log", xlabel="states", ylabel="seconds for 80 subgoals")
        axis.set_title("Planning for 80 subgoals, values within 1e-6 of the largest")
        axis.legend()
        content = io.BytesIO()
        figure.savefig(content, format="png", metadata={"Software": None})
    return content.getvalue()


if __name__ == "__main__":
    main()
