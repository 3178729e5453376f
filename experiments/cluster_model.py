"""A model of blocked sweeps on a cluster: what one sweep waits for. Every number in ``Cluster`` is an assumption.

The numbers are the table of docs/beyond-one-machine.md.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from experiments.common import PALETTE, Headline, Options, run, sheet
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

SWEEPS = 2000
"""Sweeps of a run: 1,000 of warm-up, 1,000 draws."""


@dataclass(frozen=True)
class Cluster:
    """What is assumed. A worker is one core; files are on its own disk or come as fast.

    Attributes
    ----------
    columns:
        Candidates that are computed for each observation: all, or those whose weight can matter.
    pairs_per_second:
        Observation-candidate pairs of one core, as measured, all chains sharing the computed shares.
    parts:
        Jobs of each worker in a sweep.
    spread, slow, slow_factor:
        Log-normal spread of the time of a job; share of jobs that take ``slow_factor`` times as long.
    lost_per_hour, notice:
        Chance that a worker is lost in an hour, and seconds until that is noticed and its jobs are given away.
    per_job:
        Seconds of the one scheduler for each job.
    bandwidth, latency, fan:
        Bytes per second of each link, seconds for each message, and how many a node of the tree sends to or hears.
    tree:
        Weights are sent once to each worker down a tree and sums are added up it; else all goes through the scheduler,
        with each job.
    price:
        Dollars for one core for an hour.
    """

    observations: float = 1e10
    candidates: int = 100_000
    columns: int = 100_000
    in_use: int = 200
    chains: int = 4
    workers: int = 1000
    pairs_per_second: float = 5e8
    bytes_per_observation: int = 32
    disk: float = 5e8
    parts: int = 2
    spread: float = 0.1
    slow: float = 0.001
    slow_factor: float = 4.0
    lost_per_hour: float = 1e-3
    notice: float = 30.0
    per_job: float = 1e-3
    bandwidth: float = 1.25e9
    latency: float = 1e-3
    fan: int = 16
    tree: bool = False
    price: float = 0.04


@dataclass(frozen=True)
class SweepCost:
    """Seconds of a mean sweep: the even share of the work, waiting for the last worker, weights out, sums back, the
    scheduler, lost workers; and their sum."""

    work: float
    waiting: float
    weights: float
    sums: float
    scheduler: float
    lost: float

    @property
    def total(self) -> float:
        """All of them, one after the other."""
        return self.work + self.waiting + self.weights + self.sums + self.scheduler + self.lost


def mean_sweep(cluster: Cluster, seed: int = 0, sweeps: int = 50) -> SweepCost:
    """The mean of some simulated sweeps."""
    pairs = cluster.observations * cluster.columns * cluster.chains
    jobs = cluster.workers * cluster.parts
    read = cluster.observations * cluster.bytes_per_observation / cluster.disk / jobs
    even = max(pairs / cluster.pairs_per_second / jobs, read)
    ends = np.array([_last_end(cluster, even, stream(seed, k)) for k in range(sweeps)])
    out = 8.0 * cluster.candidates * cluster.chains
    back = 16.0 * cluster.in_use * cluster.chains
    levels = int(np.ceil(np.log(cluster.workers) / np.log(cluster.fan)))
    if cluster.tree:
        weights = levels * (cluster.latency + cluster.fan * out / cluster.bandwidth)
        sums = levels * (cluster.latency + cluster.fan * back / cluster.bandwidth)
    else:
        weights = 2 * cluster.latency + 2 * jobs * out / cluster.bandwidth
        sums = 2 * cluster.latency + 2 * jobs * back / cluster.bandwidth
    work = even * cluster.parts
    base = float(ends.mean()) + weights + sums + jobs * cluster.per_job
    losses = cluster.workers * cluster.lost_per_hour * base / 3600
    return SweepCost(
        work,
        float(ends.mean()) - work,
        weights,
        sums,
        jobs * cluster.per_job,
        (1 - np.exp(-losses)) * (cluster.notice + even),
    )


def _last_end(cluster: Cluster, even: float, generator: np.random.Generator) -> float:
    """When the last job of a sweep ends, each given to the first worker that is free."""
    jobs: Floats = even * np.exp(cluster.spread * generator.normal(size=cluster.workers * cluster.parts))
    jobs = np.where(generator.random(jobs.size) < cluster.slow, cluster.slow_factor * jobs, jobs)
    free = np.zeros(cluster.workers)
    for wave in jobs.reshape(cluster.parts, cluster.workers):
        free = np.sort(free) + wave
    return float(free.max())


def plans() -> dict[str, Cluster]:
    """The rows of the table; 420 columns are what four chains with 200 subgoals in use need at η = 1."""
    built = Cluster(columns=420)
    return {
        "every candidate for every observation": Cluster(),
        "candidates whose weight can matter (as built)": built,
        "the same, 8 parts for each worker": replace(built, parts=8),
        "the same as built, weights and sums by a tree": replace(built, tree=True),
        "as built, a tenth of the workers": replace(built, workers=100),
        "as built, ten times the workers": replace(built, workers=10_000),
    }


def table(found: dict[str, Cluster]) -> str:
    """Rows of Markdown: seconds of each share of a sweep, and core hours and dollars of 2,000 sweeps."""
    lines = [
        "| plan | work | last worker | weights out | sums back | scheduler | lost workers | one sweep | 2,000 sweeps |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, cluster in found.items():
        cost = mean_sweep(cluster)
        hours = SWEEPS * cost.total / 3600
        each = (cost.work, cost.waiting, cost.weights, cost.sums, cost.scheduler, cost.lost, cost.total)
        paid = hours * cluster.workers * cluster.price
        cells = " | ".join(f"{value:,.2f} s" if value < 100 else f"{value:,.0f} s" for value in each)
        lines.append(f"| {name} | {cells} | {hours:,.1f} h, ${paid:,.0f} |")
    return "\n".join(lines)


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The mean sweep of each plan."""
    sweeps = 5 if options.quick else 50
    costs = {name: mean_sweep(cluster, options.seed, sweeps) for name, cluster in plans().items()}
    rows = [
        {"plan": name, **asdict(plans()[name]), **asdict(cost), "total": cost.total} for name, cost in costs.items()
    ]
    return {"rows": rows, "table": table(plans())}, picture(costs)


def picture(costs: dict[str, SweepCost]) -> Figure:
    """Seconds of one sweep, by what they go to; the plan that computes every candidate is off the scale."""
    figure = sheet(9.0, 3.6)
    axis = figure.subplots()
    figure.suptitle("What one sweep over 10¹⁰ observations would wait for (a model, not a measurement)")
    shown = list(costs)[1:]
    left = np.zeros(len(shown))
    parts = {"work": "work", "waiting": "last worker", "weights": "weights out", "sums": "sums back",
             "scheduler": "scheduler", "lost": "lost workers"}  # fmt: skip
    for k, (field, label) in enumerate(parts.items()):
        seconds = np.array([asdict(costs[name])[field] for name in shown])
        axis.barh(shown, seconds, left=left, color=PALETTE[k], label=label)
        left += seconds
    axis.invert_yaxis()
    axis.set_xlabel(f"seconds; “{next(iter(costs))}” would take {costs[next(iter(costs))].total:,.0f}")
    axis.grid(visible=False, axis="y")
    axis.legend(loc="upper right")
    return figure


if __name__ == "__main__":
    run("cluster_model", experiment)
