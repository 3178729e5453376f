"""Figure 5-4: where pedestrians are heading (Edinburgh Informatics Forum), by action comparison.

Tracks that start in the upper right, positions every 9th frame, velocities over 5 frames, whole tracks in seeded
random order until there are 1,000 pairs; confidence 10, concentration 1, ε-net of 20 pixels. A full run repeats this
for ten selections and counts how often each known exit has a subgoal.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from subgoal.answers.segments import segments
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.candidates import epsilon_net
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.readers import read_recording
from subgoal.demonstrations.recordings import select_trajectories, starting_in
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.plots.style import colour
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

FILE = "tracks.01Jul.txt"
EXITS = {"front door": (118, 443), "lifts": (583, 15), "stairs": (291, 8), "labs": (610, 445)}
NEAR = 100.0
"""Pixels within which a subgoal is at an exit."""
WEIGHTY = 0.02
PAIRS = 1000
CONFIDENCE, CONCENTRATION, EPSILON = 10.0, 1.0, 20.0
SELECTIONS = 10


def experiment(options: Options) -> tuple[Headline, Figure]:
    """One selection in detail, and ten for the count of exits (one in a quick run)."""
    recording = starting_in(read_recording(options.recordings / FILE), (480, -np.inf), (np.inf, 140))
    posterior, found = learn(selection(recording, options.seed), options.seed)
    others = [] if options.quick else [learn(selection(recording, k), k) for k in range(SELECTIONS)]
    headline = {
        "n_subgoals": found.n_subgoals,
        "subgoals": [_entry(item) for item in found],
        "iterations_to_mode": float(np.median([settling_sweep(trace) for trace in posterior.traces["n_active"]])),
        "pairs": posterior.n_observations,
        "status": posterior.status.name,
        "n_subgoals_distribution": found.n_subgoals_distribution,
        "exits": exits_found(found),
        "selections": _tally(others),
    }
    return headline, picture(recording, posterior, found)


def selection(recording: Recording, seed: int, pairs: int = PAIRS) -> Demonstrations:
    """Whole tracks in seeded random order until there are so many pairs."""
    everything = demonstrate(recording, every=9, window=5)
    sizes = np.diff(everything.offset)
    order = stream(seed, 54).permutation(sizes.size)
    taken = order[: int(np.searchsorted(np.cumsum(sizes[order]), pairs)) + 1]
    names = {everything.trajectory_names[k] for k in taken}
    wanted = np.array([name in names for name in recording.trajectory_names])
    return demonstrate(select_trajectories(recording, wanted, recording.source), every=9, window=5)


def learn(demos: Demonstrations, seed: int) -> tuple[Posterior, Subgoals]:
    """Default draws and warm-up."""
    likelihood = action_comparison(demos, epsilon_net(demos, EPSILON), confidence=CONFIDENCE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(likelihood, concentration=CONCENTRATION, seed=seed)
    return posterior, subgoals(posterior)


def settling_sweep(trace: Floats) -> int:
    """First sweep after which the running mode of the trace stays what it is at the end."""
    values = trace.astype(np.int64)
    seen = np.zeros(values.max() + 1, np.int64)
    mode, settled = -1, 0
    for sweep, value in enumerate(values):
        seen[value] += 1
        if value != mode and (mode < 0 or seen[value] > seen[mode]):
            mode, settled = int(value), sweep
    return settled


def exits_found(found: Subgoals) -> dict[str, bool]:
    """Whether each exit has a subgoal with at least 2 % of the pairs within 100 pixels."""
    places = [item.position for item in found if item.share >= WEIGHTY]
    return {
        name: any(float(np.linalg.norm(place - np.array(exit_place))) <= NEAR for place in places)
        for name, exit_place in EXITS.items()
    }


def _entry(item: Any) -> dict[str, Any]:
    x, y = item.position
    return {"x": float(x), "y": float(y), "weight": item.share, "radius": item.radius}


def _tally(runs: list[tuple[Posterior, Subgoals]]) -> dict[str, Any] | None:
    if not runs:
        return None
    hits = [exits_found(found) for _, found in runs]
    return {
        "count": len(runs),
        "with_exit": {name: sum(hit[name] for hit in hits) for name in EXITS},
        "with_all_exits": sum(all(hit.values()) for hit in hits),
        "most_subgoals_above_2_percent": max(sum(s.share >= WEIGHTY for s in found) for _, found in runs),
        "converged": sum(posterior.status.name == "CONVERGED" for posterior, _ in runs),
        "seconds_each": float(np.median([posterior.seconds for posterior, _ in runs])),
    }


def picture(recording: Recording, posterior: Posterior, found: Subgoals) -> Figure:
    """Tracks, pairs with subgoals, and the number of candidates in use against sweep."""
    figure = sheet(8.5, 11)
    top, middle, bottom = figure.subplots(3, 1, height_ratios=(3, 3, 1.5))
    for a, b in zip(recording.offset[:-1], recording.offset[1:], strict=True):
        top.plot(*recording.positions[a:b].T, color=GREY, lw=0.6, alpha=0.6)
    top.set_title(f"{recording.n_trajectories} pedestrian tracks that start in the upper right")
    _draw_pairs(middle, posterior, segments(posterior, found).labels, found)
    for axis in (top, middle):
        for name, (x, y) in EXITS.items():
            axis.annotate(
                name, (x, y), xytext=(0, -12), textcoords="offset points", ha="center", va="top", fontsize=8.5,
                color=INK, zorder=5, bbox={"facecolor": "white", "alpha": 0.75, "lw": 0, "pad": 0.8},
            )  # fmt: skip
            axis.plot(x, y, "+", color=INK, ms=9, mew=1.5)
        axis.set(xlim=(0, 650), ylim=(480, -15), aspect="equal", xlabel="x (pixels)", ylabel="y (pixels)")
    for k, trace in enumerate(posterior.traces["n_active"]):
        bottom.plot(
            np.arange(1, trace.size + 1), trace, lw=0.7, color=PALETTE[k % len(PALETTE)], label=f"chain {k + 1}"
        )
    bottom.axvspan(0, posterior.settings.warmup, color=GREY, alpha=0.2, lw=0)
    bottom.set(xlabel="sweep (warm-up shaded)", ylabel="candidates in use", xscale="log", xlim=(1, None))
    bottom.legend(ncols=4, loc="lower right", fontsize=8)
    return figure


def _draw_pairs(axis: Any, posterior: Posterior, labels: Ints, found: Subgoals) -> None:
    demos = posterior.demonstrations
    for k in range(len(found)):
        rows = labels == k
        axis.quiver(
            *demos.states[rows].T, *demos.actions[rows].T, color=colour(k), angles="xy", width=0.0018, scale=120
        )
    for item in found:
        axis.scatter(*item.position, s=60 + 1500 * item.share, color="#d62728", edgecolor="white", zorder=3)
        axis.annotate(f"{item.share:.0%}", item.position, xytext=(8, 4), textcoords="offset points", fontsize=8.5)
    axis.set_title(
        f"{posterior.n_observations} pairs, {len(found)} subgoals with 1 % of them ({found.n_subgoals} with 5 %)"
    )


if __name__ == "__main__":
    run("fig_5_4", experiment, needs="edinburgh_forum")
