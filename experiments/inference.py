"""Effective draws per second of every exact sampler on four posteriors, all given the same time on each.

Four chains take turns; seconds are those of the thread that samples, so that whatever else the machine does is left
out. The worth of a run is the least bulk effective sample size over log joint, K and the three largest shares, after
the first quarter of the sweeps. A sampler whose R-hat is above 1.05 has not mixed: its figure is shown hollow and
wins nothing. Compiled code is warm before the clock starts.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments import fig_4_3, fig_5_4, grid_worlds
from experiments.common import GREY, INK, PALETTE, Headline, Options, find_data, run, sheet
from subgoal import samplers
from subgoal.candidates import Candidates, epsilon_net
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.readers import read_recording
from subgoal.demonstrations.recordings import starting_in
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Arrays, Chain, Sampler, Stretch
from subgoal.posterior.diagnostics import diagnose
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

SAMPLERS: tuple[Sampler, ...] = (
    samplers.collapsed_blocks, samplers.alg4_corrected, samplers.blocked, samplers.collapsed,
    samplers.cluster_collapsed, samplers.split_merge, samplers.tempered,
)  # fmt: skip
CHAINS = 4
BUDGET, QUICK_BUDGET = 8.0, 0.25
"""Seconds for each sampler and case."""
ROUNDS = 12
"""Turns that each chain is meant to take."""
LARGEST_RHAT = 1.05
MOST_KEPT = 2**24
"""Numbers of assignments that are held at a time."""
LARGE, QUICK_LARGE, LARGE_PATIENCE = 100_000, 5_000, 4.0
CONCENTRATION, PLANE_CONFIDENCE = 1.0, 30.0
SUMMARIES = ("log joint", "K", "share 1", "share 2", "share 3")


@dataclass(frozen=True)
class Case:
    """A posterior to sample."""

    name: str
    likelihood: LogLikelihood
    patience: float = 1.0
    """So many times the usual seconds."""

    @property
    def size(self) -> str:
        """N × G in words."""
        return f"{self.likelihood.n_observations:,} × {self.likelihood.n_candidates:,}"


@dataclass
class Run:
    """Four chains of one sampler as far as they have come."""

    states: list[Arrays | None] = field(default_factory=lambda: [None] * CHAINS)
    parts: list[list[Floats]] = field(default_factory=lambda: [[] for _ in range(CHAINS)])
    seconds: float = 0.0


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every sampler on every case that can be had."""
    cases, left_out = cases_of(options)
    budget = QUICK_BUDGET if options.quick else BUDGET
    warm()
    rows = [row for case in cases for row in compared(case, budget * case.patience, options.seed)]
    ratios = {
        row["case"]: row["ratio_to_alg4"] if row["mixed"] else None
        for row in rows if row["sampler"] == "collapsed_blocks"
    }  # fmt: skip
    counted = [value for value in ratios.values() if value is not None]
    headline = {
        "rows": rows,
        "default_over_alg4": {"list": ratios, "median": float(np.median(counted)) if counted else None},
        "wins": {case.name: winner(rows, case.name) for case in cases},
        "seconds_each": budget,
        "chains": CHAINS,
        "left_out": left_out,
    }
    return headline, picture(cases, rows)


def cases_of(options: Options) -> tuple[list[Case], list[str]]:
    """The cases, and why others are left out."""
    recording = starting_in(read_recording(options.recordings / fig_5_4.FILE), (480, -np.inf), (np.inf, 140))
    demos = fig_5_4.selection(recording, options.seed)
    places = epsilon_net(demos, fig_5_4.EPSILON)
    cases = [Case("Edinburgh tracks", action_comparison(demos, places, confidence=fig_5_4.CONFIDENCE))]
    folder, reason = find_data("lasa_handwriting", options.recordings.parent)
    if folder is not None:
        strokes = demonstrate(read_recording(folder / "Zshape.mat"), every=20)
        cases.append(Case("LASA Zshape", action_comparison(strokes, epsilon_net(strokes))))
    grid = grid_worlds.world(0)
    shown = grid_worlds.demonstrate(
        grid, fig_4_3.SETTING.start, fig_4_3.SETTING.subgoals, loops=fig_4_3.SETTING.loops, seed=options.seed
    ).demonstrations
    cases.append(
        Case("Figure 4-3's grid", grid_worlds.table(shown, grid, grid_worlds.CANDIDATES["visited"](shown, grid)))
    )
    size, patience = (QUICK_LARGE, 1.0) if options.quick else (LARGE, LARGE_PATIENCE)
    cases.append(Case("simulated plane", plane(size, options.seed), patience))
    return cases, [] if reason is None else [f"LASA Zshape: {reason}"]


def plane(count: int, seed: int) -> LogLikelihood:
    """``count`` walkers, uniform in a square, heading for 8 of 10 × 10 places with errors of the model's own law.

    With 100,000 walkers and a confidence of 3 no sampler mixed in 8 seconds, with 10 only ``collapsed`` in 64.
    """
    generator, confidence = stream(seed, 55), PLANE_CONFIDENCE
    axis = np.arange(5.0, 100.0, 10.0)
    points = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    goals = generator.choice(len(points), 8, replace=False)
    shares = np.arange(8, 0, -1) / 36
    states = generator.uniform(0, 100, (count, 2))
    way = points[generator.choice(goals, count, p=shares)] - states
    angle = np.linspace(-np.pi, np.pi, 20_001)
    mass = np.cumsum(np.exp(-2 * confidence * np.abs(np.sin(angle / 2))))
    turned = np.arctan2(way[:, 1], way[:, 0]) + np.interp(generator.random(count) * mass[-1], mass, angle)
    demos = Demonstrations.from_arrays(states, np.column_stack([np.cos(turned), np.sin(turned)]))
    return action_comparison(demos, Candidates(points, radius=1.0), confidence=confidence)


def warm() -> None:
    """Compile every loop on a table of a moment."""
    table = LogLikelihood.from_table(np.log(np.random.default_rng(0).uniform(0.1, 1, (20, 4))))
    for sampler in SAMPLERS:
        sampler(Chain(table, CONCENTRATION, np.random.default_rng(1)), np.ones(5, bool))


def compared(case: Case, budget: float, seed: int) -> Iterator[Headline]:
    """One row for each sampler."""
    case.likelihood.relative  # noqa: B018  (made once, before the clock starts)
    measured = {sampler.__name__: measure(sampler, case.likelihood, budget, seed) for sampler in SAMPLERS}
    base = measured["alg4_corrected"]["ess_per_second"]
    for name, found in measured.items():
        yield {"case": case.name, "sampler": name, **found, "ratio_to_alg4": found["ess_per_second"] / base}


def measure(sampler: Sampler, likelihood: LogLikelihood, budget: float, seed: int) -> Headline:
    """Chains in turn until the time is up; all are of one length."""
    generators = [stream(seed, 56, k) for k in range(CHAINS)]
    done, sweeps = Run(), 1
    most = max(1, MOST_KEPT // max(likelihood.n_observations, likelihood.n_candidates))
    while done.seconds < budget:
        before = done.seconds
        for k in range(CHAINS):
            advance(done, k, sampler, Chain(likelihood, CONCENTRATION, generators[k], done.states[k]), sweeps)
        # Sweeps get faster once few candidates are in use, so each turn is set by the last one.
        wanted = budget / ROUNDS / max(done.seconds - before, 1e-6) * sweeps
        sweeps = int(np.clip(wanted, 1, min(4 * sweeps, most)))
    values = np.stack([np.concatenate(parts, axis=1) for parts in done.parts], axis=1)
    total = values.shape[2]
    kept = values[:, :, total // 4 :]
    found = [diagnose(each) for each in kept]
    rhat = max(each.rhat for each in found)
    least = int(np.argmin([each.ess_bulk for each in found]))
    seconds = done.seconds * kept.shape[2] / total
    return {
        "ess_per_second": found[least].ess_bulk / seconds,
        "least_of": SUMMARIES[least],
        "rhat": rhat,
        "mixed": bool(rhat <= LARGEST_RHAT),
        "sweeps_per_second": CHAINS * total / done.seconds,
        "sweeps": CHAINS * total,
        "seconds": done.seconds,
    }


def advance(done: Run, k: int, sampler: Sampler, chain: Chain, sweeps: int) -> None:
    """One turn of chain ``k``; only the sampler is timed."""
    keep = np.ones(sweeps, bool)
    begin = time.thread_time()
    stretch = sampler(chain, keep)
    done.seconds += time.thread_time() - begin
    done.states[k] = stretch.state
    done.parts[k].append(summaries(stretch, chain.table.n_candidates))


def summaries(stretch: Stretch, g_count: int) -> Floats:
    """(5, sweeps) log joint, K and the three largest shares."""
    sweeps, n = stretch.assignments.shape
    shares = np.zeros((sweeps, 3))
    for s, theta in enumerate(stretch.assignments):
        counts = np.sort(np.bincount(theta, minlength=g_count))[::-1][:3]
        shares[s, : counts.size] = counts / n
    return np.vstack([stretch.log_joint, stretch.n_active, shares.T])


def winner(rows: list[Headline], case: str) -> str | None:
    """The fastest of those that mixed."""
    mixed = [row for row in rows if row["case"] == case and row["mixed"]]
    return max(mixed, key=lambda row: row["ess_per_second"])["sampler"] if mixed else None


def picture(cases: list[Case], rows: list[Headline]) -> Figure:
    """One panel for each case, one dot for each sampler, on a logarithmic axis."""
    figure = sheet(9.5, 2.9 * -(-len(cases) // 2) + 0.5)
    figure.suptitle("Effective draws per second of sampling")
    panels: Any = figure.subplots(-(-len(cases) // 2), 2, squeeze=False)
    for axis, case in zip(panels.flat, cases, strict=False):
        draw(axis, case, [row for row in rows if row["case"] == case.name], winner(rows, case.name))
    for axis in panels.flat[len(cases) :]:
        axis.set_axis_off()
    return figure


def draw(axis: Any, case: Case, rows: list[Headline], best: str | None) -> None:
    """Dots; hollow where the sampler did not mix, blue for the fastest."""
    for k, row in enumerate(reversed(rows)):
        tint = PALETTE[0] if row["sampler"] == best else INK if row["mixed"] else GREY
        rate = row["ess_per_second"]
        axis.plot(rate, k, "o", ms=7, mec=tint, mfc=tint if row["mixed"] else "white", mew=1.4)
        label = f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"
        words = label if row["mixed"] else f"{label}, not mixed"
        axis.annotate(words, (rate, k), xytext=(8, 0), textcoords="offset points", va="center", fontsize=8, color=tint)
    axis.set_yticks(range(len(rows)), [row["sampler"] for row in reversed(rows)])
    rates = [row["ess_per_second"] for row in rows]
    axis.set(xscale="log", xlim=(min(rates) / 2, max(rates) * 8), ylim=(-0.6, len(rows) - 0.4))
    axis.set_title(f"{case.name}, {case.size}")
    axis.grid(axis="y", visible=False)


if __name__ == "__main__":
    run("inference", experiment, needs="edinburgh_forum")
