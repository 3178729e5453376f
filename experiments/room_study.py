"""The study behind figure 3-4: four variants of Bayesian IRL in Room World, under several readings of chapter 3.

Reading R1 takes δ = 1/3 and α = 0.95 as they are printed, so that rewards grow far beyond the 0.01 of the world: only
policies count in a 0-1 loss. The others are listed in ``READINGS``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from experiments.room_worlds import ANEW, FIRST, ONE_AT_RANDOM, Losses, demonstrate, losses, true_losses
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bayesian import CONFIDENCE, STEP, cooling
from subgoal.irl.relevance import Covariance, constant, relevance, squared_exponential
from subgoal.irl.reward_priors import ThreePeaks
from subgoal.irl.reward_walk import RewardChain, RewardLaw
from subgoal.irl.single_reward import shown
from subgoal.mdp.grids.rooms import MAGNITUDE, RoomWorld
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.seeds import stream

PRODUCT, PRINTED = "product", "constant sequences"
EVERY, DENSE = 10, 200
"""The loss is computed at each of the first iterations, then at every tenth."""


@dataclass(frozen=True)
class Reading:
    """What chapter 3 may have meant: prior, size of a step, form of (3.3), expert, what counts for relevance."""

    prior: ThreePeaks = field(default_factory=partial(ThreePeaks, -MAGNITUDE, MAGNITUDE))
    step: float = STEP
    likelihood: str = PRODUCT
    ties: str = FIRST
    may_be_optimal: bool = True
    multiplicity: bool = False


MAIN = "R1: steps of 1/3, any size"
BOUNDED = ThreePeaks(-1, 1, bounded=True)
READINGS = {
    MAIN: Reading(),
    "R2: steps of 0.01/3, up to 0.01": Reading(ThreePeaks(-MAGNITUDE, MAGNITUDE, bounded=True), MAGNITUDE / 3),
    "R3: steps of 1/3, up to 1": Reading(BOUNDED),
    "R1, (3.3) as printed": Reading(likelihood=PRINTED),
    "R3, (3.3) as printed": Reading(BOUNDED, likelihood=PRINTED),
    "R1, exp(αΣQ) without normaliser": Reading(likelihood="unnormalised"),
    "R1, expert's ties drawn once": Reading(ties=ONE_AT_RANDOM),
    "R1, expert's ties drawn anew": Reading(ties=ANEW),
    "R1, errors never optimal": Reading(may_be_optimal=False),
    "R1, relevance counts visits": Reading(multiplicity=True),
}


class Variant(NamedTuple):
    """A covariance function for the relevance, and whether the chain is cooled."""

    covariance: Covariance
    cooled: bool


WALK, COOLED, NARROW, WIDE = "PolicyWalk", "with cooling", "narrow relevance", "wide relevance"
VARIANTS = {
    WALK: Variant(constant(), False),
    COOLED: Variant(constant(), True),
    NARROW: Variant(squared_exponential(0.1), True),
    WIDE: Variant(squared_exponential(1.0), True),
}


class Wandering(NamedTuple):
    """Of PolicyWalk, at states that were visited and at others: how much the reward varies, and how often it moves.

    ``variance`` is that over the second half of the iterations, ``accepted`` accepted proposals for each proposal
    expected, both averaged over the states.
    """

    variance: tuple[float, float]
    accepted: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Trace:
    """R runs: their worlds, the iterations (K,) at which losses (R, K) were computed, and the loss of the truth (R,).

    ``wandering`` is that of the runs of PolicyWalk.
    """

    worlds: tuple[str, ...]
    iterations: Ints
    losses: dict[str, Losses]
    truth: Losses
    wandering: tuple[Wandering, ...]

    def until(self, last: int) -> Trace:
        """The losses up to an iteration, as if the runs had ended there."""
        kept = self.iterations <= last
        cut = {name: Losses(*(each[:, kept] for each in found)) for name, found in self.losses.items()}
        return replace(self, iterations=self.iterations[kept], losses=cut)


def study(worlds: Sequence[RoomWorld], seeds: Sequence[int], reading: Reading, steps: int) -> Trace:
    """All variants in each world with each seed."""
    keep = np.zeros(steps, bool)
    keep[:DENSE] = True
    keep[EVERY - 1 :: EVERY] = True
    runs: dict[str, list[Losses]] = {name: [] for name in VARIANTS}
    truth, wandering, names = [], [], []
    for world in worlds:
        for seed in seeds:
            demos = demonstrate(world, seed, ties=reading.ties, may_be_optimal=reading.may_be_optimal)
            names.append(world.name)
            truth.append(true_losses(world, demos))
            for k, name in enumerate(VARIANTS):
                made = one_chain(world, demos, reading, VARIANTS[name], keep, seed, k)
                runs[name].append(losses(world.grid.mdp, made.values, demos))
                if name == WALK:
                    wandering.append(wandering_of(made, demos, reading.step))
    each = {name: Losses(*map(np.stack, zip(*found, strict=True))) for name, found in runs.items()}
    whole = Losses(*(np.concatenate(column) for column in zip(*truth, strict=True)))
    return Trace(tuple(names), np.flatnonzero(keep) + 1, each, whole, tuple(wandering))


def one_chain(
    world: RoomWorld, demos: Demonstrations, reading: Reading, variant: Variant, keep: Bools, seed: int, index: int
) -> Any:
    """Steps of a chain that begins at the maximum of the prior; values are recorded at the steps of ``keep``."""
    mdp = world.grid.mdp
    weights = relevance(demos, mdp, variant.covariance, multiplicity=reading.multiplicity)
    law = RewardLaw(
        mdp, shown(demos, mdp), np.eye(mdp.n_states), reading.prior, CONFIDENCE, reading.step, reading.likelihood,
        weights,
    )  # fmt: skip
    steps = np.arange(keep.size, dtype=float)
    heat = cooling()(steps) if variant.cooled else np.ones(keep.size)
    return RewardChain(law, stream(seed, 34, index)).advance(heat, keep)


def wandering_of(made: Any, demos: Demonstrations, step: float) -> Wandering:
    """From the rewards at the iterations that were recorded."""
    seen = np.isin(np.arange(made.points.shape[1]), np.asarray(demos.states))
    points = step * made.points
    variance = points[len(points) // 2 :].var(axis=0)
    moves = (np.diff(made.points[:DENSE], axis=0) != 0).mean(axis=0) * made.points.shape[1]
    return Wandering((variance[seen].mean(), variance[~seen].mean()), (moves[seen].mean(), moves[~seen].mean()))


def end_of(loss: Floats) -> Floats:
    """(R,) where runs (R, K) end: the median over the last tenth."""
    return np.asarray(np.median(loss[:, -max(1, loss.shape[1] // 10) :], axis=1))


def reached(loss: Floats, iterations: Ints, level: Floats) -> Floats:
    """(R,) the first iteration at which a run is at its level (R,) or below; NaN where it never is."""
    below = loss <= level[:, None]
    return np.where(below.any(axis=1), iterations[below.argmax(axis=1)], np.nan)


def settled(loss: Floats, iterations: Ints) -> Floats:
    """(R,) the first iteration at which a run has come nine tenths of the way from where it began to where it ends."""
    end = end_of(loss)
    return reached(loss, iterations, end + 0.1 * np.maximum(loss[:, 0] - end, 0))


def speed_ups(trace: Trace, name: str) -> Floats:
    """(R,) how many times fewer iterations than PolicyWalk a variant takes to the loss at which PolicyWalk settles.

    Of the same run; 0 where the variant never gets there.
    """
    walk, other = trace.losses[WALK].even, trace.losses[name].even
    end = end_of(walk)
    level = end + 0.1 * np.maximum(walk[:, 0] - end, 0)
    taken = reached(other, trace.iterations, level)
    return np.nan_to_num(reached(walk, trace.iterations, level) / taken, nan=0.0)
