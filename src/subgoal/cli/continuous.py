"""``learn --likelihood gp``: planning in a continuous world, with a model that is known or learned."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from subgoal.runtime.errors import InputError

if TYPE_CHECKING:
    from subgoal.demonstrations.metric import Metric
    from subgoal.demonstrations.records import Demonstrations
    from subgoal.dynamics.protocol import Dynamics

LEARNED = ("best", "linear", "neighbours", "gp")
CARS = ("rear-drive", "all-drive")
WORTHLESS = (
    "where actions lead was not learned: on held-out stretches the model errs by as much as if nothing moved. Try a "
    "longer recording in which everything is done more than once, or a model of your own (--dynamics model.py:function)"
)


def learn_by_processes(
    file: Path, out: Path, reading: dict[str, Any], places: dict[str, Any], metric: dict[str, Any],
    table: dict[str, Any], run: dict[str, Any], world: dict[str, Any], *, quiet: bool, learn_all: bool, **how: Any,
) -> None:  # fmt: skip
    """As ``learn_file``, with actions planned in a continuous world."""
    from subgoal.cli.compose import candidate_places, clock_told, output_folder
    from subgoal.cli.pipeline import learn_table
    from subgoal.continuous import ContinuousWorld, gp_actions, hold_actions
    from subgoal.demonstrations.held import time_step
    from subgoal.demonstrations.read import read
    from subgoal.irl.gpsrl import CONCENTRATION, EXCHANGEABLE_CONFIDENCE, RADIUS, lasting
    from subgoal.likelihood.gp_actions import DEFAULT_CONFIDENCE
    from subgoal.runtime.progress import progress_display

    _refuse_others(table)
    every = reading.pop("every", 1)
    demonstrations = read(file, **reading)
    pairs = hold_actions(demonstrations, every)
    step, unit = time_step(pairs), _metric(pairs, world.pop("floor", None), metric)
    dynamics = named_dynamics(world.pop("dynamics", "best"), demonstrations, step, unit)
    dwell, hold = world.pop("dwell", None), world.pop("hold", None)
    low, high = _bounds(world.pop("action_bounds", None), dynamics, pairs)
    known = ContinuousWorld(dynamics, low, high, step=step, **world)
    if getattr(getattr(dynamics, "held_out", None), "overall", 0.0) >= 1:
        print(f"warning: {WORTHLESS}", file=sys.stderr)
    candidates = candidate_places(pairs, unit, **(places or {"epsilon": RADIUS}))
    alone = EXCHANGEABLE_CONFIDENCE if dwell == 0 else DEFAULT_CONFIDENCE
    told = getattr(dynamics, "__name__", dynamics)
    if not quiet:
        print(f"{clock_told(demonstrations, file, reading)}; a pair every {step:g} {pairs.time_unit}; {told}")
    likelihood = gp_actions(
        pairs, candidates, known, confidence=alone if table["confidence"] is None else table["confidence"], hold=hold,
        progress=progress_display("planning", quiet=quiet),
    )  # fmt: skip
    if not quiet:
        print(f"{likelihood.n_candidates} of {candidates.n_candidates} candidates can be held; {likelihood.planner}")
    if not learn_all:
        run = {"concentration": CONCENTRATION} | run
        chosen = lasting(step, dwell, {"model"} if "group" in reading else set(run))
        run |= {"sampler": chosen["sampler"].__name__} if "sampler" in chosen else chosen
    with output_folder(out) as folder:
        learn_table(
            likelihood, folder, run, quiet=quiet, learn_all=learn_all, fixed=table["confidence"] is not None,
            grouped="group" in reading, **how,
        )  # fmt: skip


def named_dynamics(name: str, demonstrations: Demonstrations, step: float, metric: Metric) -> Dynamics:
    """Learned from the recording, a model car, or a function in a Python file."""
    from subgoal.dynamics import ALL_DRIVE, REAR_DRIVE, learn_dynamics

    if name in LEARNED:
        kind: Any = name
        return learn_dynamics(demonstrations, kind=kind, step=step, metric=metric)
    if name in CARS:
        return REAR_DRIVE if name == CARS[0] else ALL_DRIVE
    path, _, function = name.rpartition(":")
    if not path:
        raise InputError("--dynamics", found=repr(name), wanted=f"{', '.join((*LEARNED, *CARS))} or model.py:function")
    return _from_file(Path(path), function)


def _from_file(path: Path, function: str) -> Dynamics:
    if not path.is_file():
        raise InputError("--dynamics", found=f"no file {path}", wanted="model.py:function")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise InputError("--dynamics", found=str(path), wanted="a Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as problem:
        raise InputError("--dynamics", where=str(path), found=f"{type(problem).__name__}: {problem}",
                         wanted="a Python file that can be imported") from problem  # fmt: skip
    found = getattr(module, function, None)
    if not callable(found):
        wanted = "a function (states (B, d), actions (B, k), duration) -> (B, d)"
        raise InputError("--dynamics", where=str(path), found=f"no function {function!r}", wanted=wanted)
    made: Dynamics = found
    return made


def _metric(pairs: Demonstrations, floor: list[float] | None, given: dict[str, Any]) -> Metric:
    """Spreads, at least the floors; or the weights that are given."""
    from subgoal.continuous import spread_metric
    from subgoal.demonstrations.metric import Metric

    states = np.asarray(pairs.states)
    if given["weights"] is None:
        period = given["period"]
        return spread_metric(
            states, floor=None if floor is None else np.array(floor),
            period=None if period is None else np.array(period),
        )  # fmt: skip
    if floor is not None:
        raise InputError("--floor", found="given", wanted="none beside --weights")
    return Metric.of(states.shape[1], given["weights"], given["period"])


def _bounds(given: list[tuple[float, float]] | None, dynamics: Any, pairs: Demonstrations) -> Any:
    """As given, as the dynamics name them, or the range of the recorded actions."""
    from subgoal.irl.gpsrl import bounds_of

    if given is None:
        return bounds_of(pairs, dynamics)
    k = np.asarray(pairs.actions).shape[-1]
    if len(given) != k:
        raise InputError("--action-bounds", found=f"{len(given)} intervals", wanted=f"{k}")
    return np.array(given, float).T


def _refuse_others(table: dict[str, Any]) -> None:
    """Raise ``InputError`` for what only a comparison of directions can use."""
    given = {"--gain": table["gain"], "--speed-limit": table["speed_limit"]}
    told = [name for name, value in given.items() if value is not None]
    told += ["--controller"] if table["controller"] != "direction" else []
    if told:
        wanted = "none of them beside --likelihood gp, which plans"
        raise InputError(" and ".join(told), found="given", wanted=wanted)
