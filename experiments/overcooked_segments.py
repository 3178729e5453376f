"""When does a cook turn to another tile? Learned change points against the true times of use, in Overcooked.

Layout asymmetric_advantages, both rooms, once with all keys seen, once with "interact" hidden: steps and turns alone.
The recording knows when a tile was used with success: there a segment ends. Fixed before the test games were scored:

* A change point lies between two rows in which something was done, and has the time of the first. True ones lie after
  the last row up to a successful use (the use itself, where it is seen). Times are game steps of 0.15 s.
* Found and true ones are matched one to one within ± 3 steps; the F-score is that of all games of both rooms together;
  its 95 % interval resamples games, both cooks of a game together. ± 1 and 0 steps are shown beside, nothing chosen by
  them. In one room half of the uses come within 5 steps of the last, so ± 3 is generous: trivial rules are the mark.
* Change points of a model are where P(θ_t ≠ θ_{t+1} | O) is above a threshold, all of them or the local maxima alone: a
  probability per boundary needs no list of subgoals, and the hidden Markov model has the same. Likelihood, candidates
  and convention are those of ``experiments.overcooked``.
* γ, α, thresholds, all or maxima, penalty, kernel and number of hidden states are those of the best F-score in the
  training games. In the test games all models learn anew without labels, and only the scores see the uses.
* Trivial rules: points evenly spaced at the rate of use in the training games, in time and in rows; every turn on the
  spot; and every press of "interact", which is nearly an oracle: most presses succeed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from functools import cache, partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from experiments import overcooked_rivals as rivals
from experiments.change_points import Tally, gap_interval, interval, tally, total
from experiments.common import Headline, Options, run
from experiments.overcooked import ALPHAS, DEFAULT_GAMMA, GAMMAS, SCORED
from experiments.overcooked_segments_picture import Strip, picture
from experiments.overcooked_sides import Side, side
from experiments.overcooked_world import INTERACT, read_games, read_kitchens
from subgoal.answers.segments import boundaries
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.persistence import Persistent
from subgoal.partition.priors import Beta
from subgoal.partition.protocol import Sampler
from subgoal.partition.sticky_hmm import StickyHMM
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats

MODELS: dict[str, Sampler | None] = {
    "subgoals, exchangeable": None,
    "subgoals that persist": Persistent(),
    "subgoals that persist until arrival": Persistent(keep_there=Beta()),
    "subgoals, sticky transitions": StickyHMM(),
}
RUPTURES, HIDDEN = "ruptures (kernel change points)", "hidden Markov model (hmmlearn)"
EVEN, EVEN_ROWS, TURNS, PRESSES = "evenly spaced in time", "evenly spaced in rows", "every turn", "every press"
KEYS = {"interact seen": False, "interact hidden": True}
TOLERANCE, BESIDE = 3.0, (1.0, 0.0)
LEAST = (*np.round(np.arange(0.05, 1.0, 0.05), 2).tolist(), 0.98)
LONG: dict[str, Any] = {"draws": 250, "warmup": 250, "thin": 4}
SHORT: dict[str, Any] = {"draws": 50, "warmup": 100, "thin": 1, "chains": 2}


class Method(NamedTuple):
    """A way to find change points, and the settings among which the training games choose."""

    points: Callable[[Side, Headline], list[Floats]]
    grid: list[Headline]


def experiment(options: Options) -> tuple[Headline, Figure]:
    """With all keys seen, and with "interact" hidden."""
    maps, table = read_kitchens(options.recordings), read_games(options.recordings, (SCORED,))
    headline: Headline = {"tolerance": TOLERANCE}
    strips = {}
    for keys, hidden in KEYS.items():
        train, test = ([side(maps, table, player, split, hidden) for player in (0, 1)] for split in ("train", "test"))
        headline[keys], strips[keys] = compared(train, test, options)
    return headline, picture({keys: headline[keys] for keys in KEYS}, strips)


def compared(train: list[Side], test: list[Side], options: Options) -> tuple[Headline, Strip]:
    """Every method's settings chosen on the training games, and its scores in the test games."""
    tried, final = methods(train, options, SHORT), methods(train, options, SHORT if options.quick else LONG)
    rows: Headline = {}
    found: dict[str, list[list[Floats]]] = {}
    for name, method in tried.items():
        setting, in_training = chosen(method, train)
        found[name] = [final[name].points(each, setting) for each in test]
        rows[name] = {
            "setting": setting, "f_score_in_training": in_training, **scores(found[name], test, options.seed)
        }  # fmt: skip
    best = max(MODELS, key=lambda name: rows[name]["f_score_in_training"])
    posteriors = {name: [learned(each, name, rows[name]["setting"], options) for each in test] for name in MODELS}
    headline = {
        "methods": rows,
        "status": {name: [status for _, status in each] for name, each in posteriors.items()},
        "best_model_in_training": best,
        "gaps": {
            f"{best} over {other}": gap(found[best], found[other], test, options.seed)
            for other in rows if other not in MODELS
        },
        "games": len(set(test[0].names)),
        "rows": [each.times.size for each in test],
        "true_change_points": [sum(map(len, each.true)) for each in test],
        "median_steps_between_them": [float(np.median(np.concatenate(list(map(np.diff, each.true))))) for each in test],
    }  # fmt: skip
    first = test[0].games[0]
    return headline, Strip(
        best, test[0].times[first], posteriors[best][0][0][first], test[0].true[0],
        {name: each[0][0] for name, each in found.items()},
    )  # fmt: skip


def learned(each: Side, model: str, setting: Headline, options: Options) -> tuple[Floats, str]:
    """The probabilities behind a model's final change points, and whether their chains converged."""
    length = _fixed(SHORT if options.quick else LONG)
    return boundary_probability(each, model, setting["gamma"], setting["alpha"], length, options.seed)


def methods(train: list[Side], options: Options, length: dict[str, Any]) -> dict[str, Method]:
    """Everything that is compared; what is evenly spaced has the rate of use in the training games."""
    quick, seed = options.quick, options.seed
    uses = sum(len(game) for each in train for game in each.true)
    steps = sum(float(np.ptp(each.times[rows])) for each in train for rows in each.games)
    acted = sum(each.times.size for each in train)
    rules = {"least": LEAST[::3] if quick else LEAST, "only_peaks": (True, False)}
    planned = settings(gamma=(DEFAULT_GAMMA,) if quick else GAMMAS, alpha=(10.0,) if quick else ALPHAS, **rules)
    kernels = settings(kernel=rivals.KERNELS, penalty=rivals.PENALTIES[:: 4 if quick else 1])
    hidden = settings(states=(4, 8) if quick else rivals.STATES, **rules)
    made = {
        name: Method(partial(model_points, model=name, length=_fixed(length), seed=seed), planned) for name in MODELS
    }
    made[RUPTURES] = Method(rivals.kernel_points, kernels)
    made[HIDDEN] = Method(partial(rivals.hidden_markov_points, starts=1 if quick else 3, seed=seed), hidden)
    made[EVEN] = Method(rivals.even_times, [{"gap": steps / uses}])
    made[EVEN_ROWS] = Method(rivals.even_rows, [{"gap": acted / uses}])
    made[TURNS] = Method(rivals.turns, [{}])
    if any((each.actions == INTERACT).any() for each in train):
        made[PRESSES] = Method(rivals.presses, [{}])
    return made


def settings(**values: Iterable[Any]) -> list[Headline]:
    """All combinations."""
    return [dict(zip(values, each, strict=True)) for each in product(*values.values())]


def chosen(method: Method, train: list[Side]) -> tuple[Headline, float]:
    """The setting with the best F-score in the training games, and that score."""
    tried = [total(tallies([method.points(each, setting) for each in train], train, TOLERANCE)).f_score
             for setting in method.grid]  # fmt: skip
    best = int(np.argmax(tried))
    return method.grid[best], tried[best]


def tallies(found: list[list[Floats]], sides: list[Side], tolerance: float) -> list[Tally]:
    """Of every game of every room."""
    return [
        tally(points, true, tolerance)
        for room, each in zip(found, sides, strict=True) for points, true in zip(room, each.true, strict=True)
    ]  # fmt: skip


def scores(found: list[list[Floats]], sides: list[Side], seed: int) -> Headline:
    """F-score with its interval, its parts, each room's, and those of narrower tolerances."""
    each = tallies(found, sides, TOLERANCE)
    both = total(each)
    low, high = interval(each, game_names(sides), seed)
    return {
        "f_score": both.f_score,
        "low": low,
        "high": high,
        "precision": both.precision,
        "recall": both.recall,
        "found": both.found,
        "f_score_of_rooms": [
            total(tallies([points], [room], TOLERANCE)).f_score for points, room in zip(found, sides, strict=True)
        ],
        "f_score_within": {f"{width:g}": total(tallies(found, sides, width)).f_score for width in BESIDE},
    }


def gap(first: list[list[Floats]], second: list[list[Floats]], sides: list[Side], seed: int) -> Headline:
    """Difference of two F-scores with its interval."""
    one, other = tallies(first, sides, TOLERANCE), tallies(second, sides, TOLERANCE)
    low, high = gap_interval(one, other, game_names(sides), seed)
    return {"mean": total(one).f_score - total(other).f_score, "low": low, "high": high}


def game_names(sides: list[Side]) -> list[str]:
    """Of every game of every room, the same for both cooks."""
    return [name for each in sides for name in each.names]


def model_points(
    each: Side, setting: Headline, model: str, length: tuple[tuple[str, Any], ...], seed: int
) -> list[Floats]:
    """Where the probability of a boundary is high enough."""
    strength, _ = boundary_probability(each, model, setting["gamma"], setting["alpha"], length, seed)
    return rivals.cut(each, strength, setting)


@cache
def boundary_probability(
    each: Side, model: str, gamma: float, alpha: float, length: tuple[tuple[str, Any], ...], seed: int
) -> tuple[Floats, str]:
    """(N,) P(θ_t ≠ θ_{t+1} | O), which says nothing at the last row of a game; and whether the chains converged."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(likelihood(each, gamma).at(alpha), model=MODELS[model], seed=seed, **dict(length))
    return np.append(boundaries(posterior)[1:], 0.0), posterior.status.name


@cache
def likelihood(each: Side, gamma: float) -> LogLikelihood:
    """Planned once for each γ."""
    room = each.rooms[gamma]
    return planned_actions(each.demonstrations, room.candidates, room.mdp)


def _fixed(length: dict[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(length.items())


if __name__ == "__main__":
    run("overcooked_segments", experiment, needs="overcooked_human")
