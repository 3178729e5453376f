"""Blocked sweeps over sharded observations: observations per second and memory against N, from 10^4 to 10^8.

Simulated walkers head for some of 20 places. "directions": 32 bytes of position and direction per observation, from
which its likelihood is computed in each sweep; "stored": a table of float32. Four chains share each reading of the
files. Every figure is from a child process: seconds are of the median sweep, by the clock and of processor time over
all threads, which other programs disturb less; memory is the resident set above that of the process after its imports
and a first, small run. Files are in the page cache.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import GREY, INK, MARKERS, PALETTE, Headline, Options, run, sheet
from subgoal._kernels.shard_rows import draw_directions, draw_rows, encode
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.sharded_blocked import LOST, LOWEST, NONE_LEFT
from subgoal.runtime.checks import Floats
from subgoal.runtime.progress import Silent
from subgoal.runtime.seeds import stream
from subgoal.sharded import DirectionWriter, open_shards, sample_shards, write_shards
from subgoal.storage.shards import BLOCK

PLACES, CHAINS, CONFIDENCE, NOISE = 20, 4, 3.0, 0.3
PART = 2**18
ROWS = 2**22
SIZES = {"directions": (10**4, 10**5, 10**6, 10**7, 10**8), "stored": (10**4, 10**5, 10**6, 10**7)}
QUICK = {"directions": (10**4, 10**5), "stored": (10**5,)}
WORK, QUICK_WORK = 2e8, 4e6
"""Observations times chains in one run, about; at least two sweeps and at most 60."""
KERNEL_SIZES = (20, 100, 1000)


def experiment(options: Options) -> tuple[Headline, Figure]:
    """All sizes, kinds and numbers of workers."""
    sizes = QUICK if options.quick else SIZES
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(dir=options.out, prefix="scaling-") as place:
        for kind, counts in sizes.items():
            for n in counts:
                folder = Path(place) / f"{kind}-{n}"
                begin = time.perf_counter()
                simulate(folder, n, kind, options.seed)
                written = time.perf_counter() - begin
                for workers in (1,) if options.quick and n < 10**5 else (1, 2):
                    row = in_a_child(folder, n, workers, options)
                    rows.append({"kind": kind, "n": n, "workers": workers, **row, "seconds_to_write": written})
                shutil.rmtree(folder)
    headline = {
        "rows": rows, "candidates": PLACES, "chains": CHAINS, "confidence": CONFIDENCE,
        "kernel": [kernel_rate(kind, g, options.seed) for kind in SIZES for g in KERNEL_SIZES],
    }  # fmt: skip
    return headline, picture(rows)


def places_of(seed: int) -> Candidates:
    """Twenty places in a square of 100 by 100."""
    return Candidates(stream(seed, 1).uniform(0, 100, (PLACES, 2)), radius=2.0)


def walkers(points: Floats, count: int, generator: np.random.Generator) -> tuple[Floats, Floats]:
    """Positions and directions (count, 2) of walkers to the first six places, more to the first than to the last."""
    share = 0.6 ** np.arange(6)
    states = generator.uniform(0, 100, (count, 2))
    way = points[generator.choice(6, count, p=share / share.sum())] - states
    angle = np.arctan2(way[:, 1], way[:, 0]) + generator.normal(scale=NOISE, size=count)
    return states, np.stack([np.cos(angle), np.sin(angle)], axis=1)


def simulate(folder: Path, n: int, kind: str, seed: int) -> None:
    """Shards of n walkers, part by part."""
    candidates = places_of(seed)
    directions = folder if kind == "directions" else folder.with_name(folder.name + "-source")
    with DirectionWriter(directions, candidates, confidence=CONFIDENCE, rows=ROWS) as writer:
        for k in range(-(-n // PART)):
            writer.append(*walkers(candidates.points, min(PART, n - k * PART), stream(seed, 2, k)))
    if kind == "stored":
        shutil.rmtree(directions)
        generator = stream(seed, 3)
        way = generator.uniform(0, 2, (n, PLACES))
        write_shards(LogLikelihood.from_table(-CONFIDENCE * way), folder, rows=ROWS)


class Clock(Silent):
    """When each sweep ended, and the processor time of all threads by then."""

    def __init__(self) -> None:
        self.ends, self.work = [time.perf_counter()], [time.process_time()]

    def update(self, done: int, total: int, note: str = "") -> None:
        self.ends.append(time.perf_counter())
        self.work.append(time.process_time())


def in_a_child(folder: Path, n: int, workers: int, options: Options) -> dict[str, Any]:
    """``child`` in a process of its own."""
    work = QUICK_WORK if options.quick else WORK
    code = f"from experiments.scaling import child; child({str(folder)!r}, {n}, {workers}, {options.seed}, {work})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


def child(folder: str, n: int, workers: int, seed: int, amount: float) -> None:
    """Print the figures of one run as JSON."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as small:
        for kind in ("directions", "stored"):
            simulate(Path(small) / kind, 1000, kind, seed)
            sample_shards(open_shards(Path(small) / kind), draws=5, warmup=0, workers=workers)
    before, clock = resident_megabytes(), Clock()
    shards = open_shards(folder, verify=False)
    sweeps = int(np.clip(amount // (n * CHAINS), 2, 60))
    found = sample_shards(
        shards, draws=sweeps, warmup=0, chains=CHAINS, seed=seed, workers=workers, progress=clock, concentration=0.1
    )
    seconds = float(np.median(np.diff(clock.ends)))
    work = float(np.median(np.diff(clock.work)))
    rate = n * CHAINS / seconds
    print(json.dumps({
        "sweeps": sweeps, "seconds_per_sweep": seconds, "processor_seconds_per_sweep": work,
        "observations_per_second": rate, "observations_per_processor_second": n * CHAINS / work,
        "pairs_per_second": rate * PLACES, "megabytes_above_import": peak_megabytes() - before,
        "megabytes_on_disk": sum(each.bytes for each in shards.files.files) / 2**20,
        "log_joint": float(found.log_joint[0, -1]),
    }))  # fmt: skip


def resident_megabytes() -> float:
    """Resident set of this process now; what was its largest is forgotten."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def peak_megabytes() -> float:
    """Largest resident set since then."""
    return _status("VmHWM")


def _status(field: str) -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return float(next(line for line in lines if line.startswith(field)).split()[1]) / 1024


def kernel_rate(kind: str, g_count: int, seed: int) -> dict[str, Any]:
    """Observation-candidate pairs per second of processor time, of the compiled loops alone; the best of five."""
    generator, rows = stream(seed, 4, g_count), min(BLOCK, 2**22 // g_count)
    log_weights = np.log(generator.dirichlet(np.full(g_count, 0.5), CHAINS) + 1e-300)
    log_weights -= log_weights.max(axis=1, keepdims=True)
    lowest = LOWEST["<f4" if kind == "stored" else "<f8"]
    rest = (
        log_weights, np.exp(log_weights), generator.random((CHAINS, rows)),
        np.full(CHAINS, g_count * LOST * math.exp(lowest)), np.empty(g_count), np.empty(g_count),
        np.zeros((CHAINS, g_count), np.int64), np.zeros(CHAINS), NONE_LEFT,
    )  # fmt: skip
    shares, peaks = np.empty((rows, g_count), np.float32), np.empty(rows)
    encode(-CONFIDENCE * generator.uniform(0, 2, (rows, g_count)), lowest, shares, peaks)
    goals = np.ascontiguousarray(generator.uniform(0, 100, (2, g_count)))
    states, units = walkers(goals.T, rows, generator)
    seconds = []
    for _ in range(6):
        begin = time.process_time()
        if kind == "stored":
            draw_rows(shares, *rest)
        else:
            draw_directions(units, states, goals, 1.0, CONFIDENCE, 0.5, *rest)
        seconds.append(time.process_time() - begin)
    return {"kind": kind, "candidates": g_count, "pairs_per_second": rows * g_count * CHAINS / min(seconds[1:])}


def picture(rows: list[dict[str, Any]]) -> Figure:
    """Observations per second, and memory, against N."""
    figure = sheet(10.0, 4.6)
    speed, memory = figure.subplots(1, 2)
    figure.suptitle("Ten thousand or a hundred million observations: the same speed, the same memory")
    for axis, field, title in (
        (speed, "observations_per_processor_second", "Observations assigned per second of processor time"),
        (memory, "megabytes_above_import", "Memory above the process after import, MiB"),
    ):
        lines = [(kind, workers) for kind in SIZES for workers in (1, 2)]
        for k, (kind, workers) in enumerate(lines):
            some = [row for row in rows if (row["kind"], row["workers"]) == (kind, workers)]
            label = f"{kind}, {workers} worker{'s' if workers > 1 else ''}"
            style = "-" if workers == 1 else "--"
            axis.plot([row["n"] for row in some], [max(row[field], 1) for row in some], style, color=PALETTE[k // 2],
                      marker=MARKERS[k], label=label)  # fmt: skip
        axis.set(xscale="log", yscale="log", xlabel="observations N", title=title)
    sizes = np.array(sorted({row["n"] for row in rows}), float)
    memory.plot(sizes, sizes * PLACES * 8 / 2**20, color=GREY, lw=1)
    memory.annotate(f"the table, were it held\n({PLACES} candidates)", (sizes[-2], sizes[-2] * PLACES * 8 / 2**20),
                    xytext=(-8, 2), textcoords="offset points", ha="right", va="bottom", color=GREY)  # fmt: skip
    speed.set_ylim(bottom=min(1e6, *(row["observations_per_processor_second"] for row in rows)) / 1.5)
    speed.legend(loc="lower right", labelcolor=INK)
    return figure


if __name__ == "__main__":
    run("scaling", experiment)
