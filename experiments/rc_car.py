"""Manoeuvres of a real car: 115 seconds of a 1/10-scale car driven by hand, nothing labelled, no model of the car.

Dynamics are learned from the recording itself. Two held-out errors chose the settings, both from one half of the
recording to the other (it has a gap in its middle):

* of the dynamics: a forecast of yaw rate and wheel speed 0.6 s ahead, for the step, the lag of the commands and the
  sideways velocity;
* of the driver: bits per decision, for the velocity of the pose, the confidence and how long a subgoal is kept.

A full run prints both tables (``tried``). There is no truth to compare with: what can be told is whether the same comes
out again, from the other half and from other seeds.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import subgoal
from experiments.common import Headline, Options, run
from experiments.rc_car_picture import page, words
from experiments.recorded_car import FLOOR, RATE, Recorded, delays, read_recording
from experiments.recorded_study import (
    Answer,
    Settings,
    agreement,
    answer,
    forecast_error,
    matched,
    planned,
    quietly,
)
from subgoal.continuous import hold_actions, spread_metric
from subgoal.demonstrations import Demonstrations
from subgoal.dynamics import learn_dynamics

HALVES = (0, 1)
EVERY = 4
"""Samples that one held action lasts: 0.2 s."""
STATE = ("yaw rate", "wheels")
CONFIDENCE, DWELL = 20.0, 0.5
STATES = (STATE, ("vx", *STATE), ("vx", "vy", *STATE))
STEPS = (0.2, 0.3)
LAGS = (-0.1, -0.05, 0.0, 0.05, 0.1, 0.15)
CONFIDENCES, DWELLS = (10.0, 15.0, 20.0, 30.0), (0.25, 0.5, 1.0, 4.0)
HORIZON = 0.6
"""Seconds of a forecast, a multiple of both steps."""
SWEEPS: dict[str, Any] = {"chains": 4, "warmup": 300, "draws": 300, "thin": 1}
SOME: dict[str, Any] = {"chains": 4, "warmup": 150, "draws": 150, "thin": 1}
FEW: dict[str, Any] = {"chains": 2, "warmup": 50, "draws": 50, "thin": 1}


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The answer, how far it can be trusted, and in a full run how its settings were chosen."""
    car = read_recording(options.recordings / "DS5")
    sweeps = FEW if options.quick else SWEEPS
    settings = settings_of(car, STATE, {"confidence": CONFIDENCE, "dwell": DWELL, **sweeps})
    every = {which: learned(car, pieces, settings, options.seed) for which, pieces in PIECES.items()}
    seeds = [options.seed + k for k in range(1, 2 if options.quick else 4)]
    again = [answer(every["whole"].pairs, every["whole"].dynamics, settings, seed) for seed in seeds]
    whole = every["whole"]
    headline: Headline = {
        "n_subgoals": whole.goals.n_candidates,
        "manoeuvres": told(whole),
        "held_out_error": held_out(whole),
        "bellman_residual": planned(whole.found),
        "stability": {"halves": halves(every, settings), "seeds": over_seeds(whole, again, settings)},
        "bits_over_flat": {which: gained(each) for which, each in every.items()},
        "settings": {"state": STATE, "step": EVERY / RATE, "confidence": CONFIDENCE, "dwell": DWELL},
        "seconds_recorded": len(car.times) / RATE,
        "pairs": whole.pairs.n_observations,
        "stalled": stalled(car),
        "delays": delays(options.recordings / "DS5"),
    }
    if not options.quick:
        headline["tried"] = {"forecast": forecasts(options), "bits_per_decision": bits(car, options.seed)}
    return headline, page(car, every, headline, EVERY)


PIECES: dict[str, tuple[int, ...] | None] = {"whole": None, "first half": (0,), "second half": (1,)}


def settings_of(car: Recorded, state: tuple[str, ...], learning: dict[str, Any]) -> Settings:
    """The metric and the bounds are those of the whole recording, so that halves can be compared."""
    floor = np.array([FLOOR[name] for name in state])
    metric = spread_metric(np.asarray(car.demonstrations(state).states), floor=floor)
    return Settings(metric, car.bounds, learning)


def learned(car: Recorded, pieces: tuple[int, ...] | None, settings: Settings, seed: int) -> Answer:
    """Dynamics and subgoals of some pieces, from nothing else."""
    demos = car.demonstrations(STATE, pieces)
    dynamics = quietly(learn_dynamics, demos, step=EVERY / RATE)
    return answer(hold_actions(demos, EVERY), dynamics, settings, seed)


def stalled(car: Recorded) -> float:
    """Share of the time in which half a metre a second or more is commanded, and the wheels stand."""
    return float(((np.abs(car.commands[:, 1]) > 0.5) & (np.abs(car.states["wheels"]) < 0.1)).mean())


def told(found: Answer) -> list[Headline]:
    """Each subgoal in words and numbers, by share of the time, with the mean command under it."""
    order = np.argsort(-found.shares)
    return [
        {
            "words": words(found.goals.points[k]), "state": found.goals.points[k], "share": float(found.shares[k]),
            "mean_command": np.asarray(found.pairs.actions)[found.label == k].mean(axis=0),
        }
        for k in order
    ]  # fmt: skip


def held_out(found: Answer) -> Headline:
    """Of one step of the learned dynamics, per dimension, beside "the state stays as it is"."""
    model: Any = found.dynamics
    return {
        "kind": model.kind, "dimensions": STATE, "error": model.held_out.error,
        "state_stays": model.held_out.persistence, "share_of_what_changes": model.held_out.share,
    }  # fmt: skip


def gained(found: Answer) -> float:
    """Mean bits per decision, seen ones, by which the subgoals tell the commands better than "anything goes"."""
    table = found.found.known_likelihood
    rows = table.rows(0, found.pairs.n_observations)
    at = [int(np.argmin(np.linalg.norm(found.found.candidates.points - p, axis=1))) for p in found.goals.points]
    chosen = rows[np.arange(len(rows)), np.array(at)[found.label]]
    flat = table.source.log_flat(0, len(rows))
    return float((chosen - flat).mean() / np.log(2))


def halves(every: dict[str, Answer], settings: Settings) -> Headline:
    """Subgoals of the halves against each other and the whole; each half as the other's subgoals cut it."""
    first, second = every["first half"], every["second half"]
    n = first.pairs.n_observations
    rows = {"first half": slice(0, n), "second half": slice(n, None)}
    apart, nearest = matched(first, second, settings.metric)
    numbers: Headline = {
        "n_subgoals": {which: each.goals.n_candidates for which, each in every.items()},
        "distances_of_matched": apart,
        "matched_within_half_a_unit": int((apart <= 0.5).sum()),
        "matched_within_one_unit": int((apart <= 1.0).sum()),
        "nearest_of_the_other_half": {"first half": nearest, "second half": matched(second, first, settings.metric)[1]},
        "in_the_whole": {which: matched(every[which], every["whole"], settings.metric)[1] for which in rows},
    }
    for own, other in ((first, second), (second, first)):
        which = "first half" if own is first else "second half"
        cut = settings.cut(own.pairs, other.dynamics, other.goals, other.support)
        numbers[f"{which}, own cut against the other's"] = agreement(own.label, cut)
        numbers[f"{which}, own cut against the whole's"] = agreement(own.label, every["whole"].label[rows[which]])
    return numbers


def over_seeds(whole: Answer, again: list[Answer], settings: Settings) -> Headline:
    """The same pairs sampled again."""
    found = [whole, *again]
    pairs = [(a, b) for k, a in enumerate(found) for b in found[k + 1 :]]
    v = [agreement(a.label, b.label) for a, b in pairs]
    return {
        "n_subgoals": [each.goals.n_candidates for each in found],
        "v_measure": [each["v_measure"] for each in v],
        "ari": [each["ari"] for each in v],
        "farthest_of_matched": [float(matched(a, b, settings.metric)[0].max()) for a, b in pairs],
    }


def forecasts(options: Options) -> list[Headline]:
    """Error of yaw rate and wheel speed 0.6 s ahead on the other half, as a share of what changes."""
    folder = options.recordings / "DS5"
    plain = read_recording(folder)
    rows = []
    for state in STATES:
        for step in STEPS:
            error = [forecast(plain, state, step, kind="gp", seed=options.seed + k) for k in range(3)]
            rows.append({"state": state, "step": step, "lag": 0.0, "kind": "gp", "error": np.mean(error, axis=0)})
    for kind in ("linear", "neighbours"):
        error_of = forecast(plain, STATE, EVERY / RATE, kind=kind)
        rows.append({"state": STATE, "step": EVERY / RATE, "lag": 0.0, "kind": kind, "error": error_of})
    for lag in LAGS:
        for which in ("steer_late", "speed_late"):
            shifted = read_recording(folder, **{which: lag})
            error_of = forecast(shifted, STATE, EVERY / RATE, kind="neighbours")
            rows.append({"state": STATE, "step": EVERY / RATE, which: lag, "kind": "neighbours", "error": error_of})
    return rows


def forecast(car: Recorded, state: tuple[str, ...], step: float, **how: Any) -> list[float]:
    """Share of what changes in yaw rate and in wheel speed."""
    parts = [
        forecast_error(
            car.demonstrations(state, (half,)), car.demonstrations(state, (1 - half,)), step=step, horizon=HORIZON,
            told=STATE, **how,
        )
        for half in HALVES
    ]  # fmt: skip
    error, change = (np.concatenate(each) for each in zip(*parts, strict=True))
    return [float(share) for share in np.sqrt(error.mean(axis=0) / change.mean(axis=0))]


def bits(car: Recorded, seed: int) -> list[Headline]:
    """Log₂ density of the commands of each half from the other, per decision; a flat density has −2.4."""
    rows = []
    for state in STATES[:2]:
        models = [quietly(learn_dynamics, car.demonstrations(state, (h,)), step=EVERY / RATE) for h in HALVES]
        pairs = hold_actions(car.demonstrations(state), EVERY)
        for confidence in CONFIDENCES:
            for dwell in DWELLS:
                settings = settings_of(car, state, {"confidence": confidence, "dwell": dwell, **SOME})
                make = partial(half_learned, settings=settings, models=models, car=car, seed=seed)
                score = quietly(subgoal.validation.cross_validate, make, pairs, folds=2, seed=seed)
                rows.append({"state": state, "confidence": confidence, "dwell": dwell, "bits": score.bits_per_decision,
                             "standard_error": score.standard_error})  # fmt: skip
    return rows


def half_learned(pairs: Demonstrations, *, settings: Settings, models: list[Any], car: Recorded, seed: int) -> Any:
    """Subgoals of one half, with the dynamics of that half."""
    second = np.asarray(pairs.times)[0] >= car.times[car.offset[1]]
    return settings.learn(pairs, models[int(second)], seed)


if __name__ == "__main__":
    run("rc_car", experiment, needs="frictionmaps_f1tenth")
