"""Words of the command line turned into the library's functions and records."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.candidates import Candidates, epsilon_net, read_candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.readers import PAIRS, RECORDINGS, accepted, format_of
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.controllers import proportional
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Sampler
from subgoal.plots.words import counted
from subgoal.runtime.errors import InputError

POSTERIOR = "posterior.npz"
FEW = 10
"""Pairs below which it is told that little can be learned."""
FINE = 1 / 40
"""Seconds between samples below which --rate is recommended."""


def clock_told(data: Recording | Demonstrations, file: Path, reading: dict[str, Any]) -> str:
    """The unit of the times, and whether it is only assumed."""
    if data.times is None:
        return "times: none"
    kind = format_of(file, reading.get("format"))
    if (
        data.time_unit == "s"
        and "time_scale" not in reading
        and "time_scale" in accepted({**RECORDINGS, **PAIRS}[kind])
    ):
        return "times: taken as seconds (--time-scale 0.001 if they are milliseconds)"
    return f"times: in {data.time_unit}"


def rate_hint(data: Recording | Demonstrations, reading: dict[str, Any]) -> str:
    """A line on samples so close that segments come out many; empty where they are not, or a rate was asked for."""
    if data.times is None or data.time_unit != "s" or {"rate", "every"} & reading.keys() or len(data.times) < 2:
        return ""
    step = float(np.median(np.diff(data.times)))
    return f"{1 / step:.0f} samples a second: --rate 20 makes segments fewer and longer" if 0 < step < FINE else ""


def few_told(data: Demonstrations, reading: dict[str, Any]) -> str:
    """A line where hardly anything is left to learn from, and what may have left it out; empty elsewhere."""
    if data.n_observations >= FEW:
        return ""
    chosen = [f"--{name}" for name in ("every", "window") if (reading.get(name) or 1) > 1]
    cause = f": {' and '.join(chosen)} may be too large" if chosen else ""
    return f"warning: learned from {counted(data.n_observations, 'pair')} of state and action only{cause}"


def candidate_places(
    demonstrations: Demonstrations,
    metric: Metric,
    *,
    file: Path | None = None,
    epsilon: float | None = None,
    grid: float | None = None,
) -> Candidates:
    """Places from a file, a grid over the visited range, or an ε-net (the default)."""
    asked = [
        name for name, value in (("--candidates", file), ("--epsilon", epsilon), ("--grid", grid)) if value is not None
    ]
    if len(asked) > 1:
        raise InputError("candidate places", found=" and ".join(asked), wanted="one of them")
    if file is not None:
        return read_candidates(file, demonstrations.names, metric=metric)
    if grid is not None:
        everywhere = np.vstack([demonstrations.states, demonstrations.final_states])
        return Candidates.grid(everywhere.min(axis=0), everywhere.max(axis=0), grid, metric=metric)
    return epsilon_net(demonstrations, epsilon, metric=metric)


def likelihood_table(
    demonstrations: Demonstrations,
    candidates: Candidates,
    *,
    confidence: float,
    controller: str,
    gain: float | None,
    speed_limit: float | None,
) -> LogLikelihood:
    """Action comparison with the controller of that name."""
    if controller == "direction":
        told = [name for name, value in (("--gain", gain), ("--speed-limit", speed_limit)) if value is not None]
        if told:
            raise InputError(" and ".join(told), found="the controller 'direction'", wanted="--controller proportional")
        return action_comparison(demonstrations, candidates, confidence=confidence)
    if controller != "proportional":
        raise InputError("--controller", found=repr(controller), wanted="'direction' or 'proportional'")
    if speed_limit is None:
        speed = np.linalg.norm(demonstrations.actions * candidates.metric.weights, axis=1)
        speed_limit = float(np.median(speed[speed > 0])) if (speed > 0).any() else 1.0
    law = proportional(1.0 if gain is None else gain, speed_limit, candidates.metric)
    return action_comparison(demonstrations, candidates, confidence=confidence, controller=law)


def named_sampler(name: str) -> Sampler:
    """The function of ``subgoal.samplers`` with that name."""
    from subgoal import samplers

    if name not in samplers.__all__:
        raise InputError("--sampler", found=repr(name), wanted=", ".join(samplers.__all__))
    sampler: Sampler = getattr(samplers, name)
    return sampler


def model_and_sampler(
    demonstrations: Demonstrations, sampler: str | None, *, grouped: bool, learn_all: bool
) -> dict[str, Sampler]:
    """Arguments ``model`` and ``sampler``, where they are not the defaults of ``sample`` or ``learn``.

    Groups have a model, and so has ``learn``; these have samplers of their own.
    """
    if sampler is not None and (grouped or learn_all):
        beside = "--group" if grouped else "--learn-all"
        raise InputError("--sampler", found=repr(sampler), wanted=f"none beside {beside}, which has its own")
    if grouped:
        from subgoal.models import Grouped

        return {"model": Grouped(demonstrations.group)}
    return {} if sampler is None else {"sampler": named_sampler(sampler)}


def tell_replaced(folder: Path, *, quiet: bool) -> None:
    """Tell that results which stand in the folder will be replaced."""
    if not quiet and (folder / POSTERIOR).exists():
        print(f"replaces the results in {folder}/", flush=True)


@contextmanager
def output_folder(path: Path) -> Iterator[Path]:
    """The folder, made if it is not there; taken away again if nothing came to stand in it."""
    made = not path.exists()
    if path.is_file():
        raise InputError("--out", found=f"the file {path}", wanted="a folder", hint="another name")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise InputError("--out", found=str(problem), wanted="a folder that can be written") from None
    try:
        yield path
    finally:
        if made and not any(path.iterdir()):
            path.rmdir()
