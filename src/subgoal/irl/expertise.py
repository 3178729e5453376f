"""How exactly a demonstrator acts, as the confidence α with an interval (thesis 7.3.1, used in the opposite way)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import trapezoid
from scipy.interpolate import CubicSpline
from scipy.special import logsumexp

from subgoal.answers.evidence import autocorrelation
from subgoal.irl.expertise_record import RESOLVED, Expertise, ExpertiseTable, quantiles
from subgoal.likelihood.gp_values import TestedValues
from subgoal.likelihood.source import Assigned
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.checks import Floats, Ints, frozen, positive
from subgoal.runtime.errors import InputError

RANGE = 1e-2, 1e4
"""Of α, in units of the likelihood's own scale."""
COARSE, FINE, MANY = 21, 41, 801
NEGLIGIBLE = 12.0
"""Nats below the most probable α beyond which others are left out."""
IN_PLAY = 30.0
"""Nats below the best candidate, and a tenth for each observation, within which others are in play."""
SLOPE = 1e-3
"""Of log α, over which scores are taken."""
BACKGROUND = "0: with a background no single goal explains all"


def expertise(likelihood: LogLikelihood, *, level: float = 0.9, weight: float | None = None) -> Expertise:
    """α of a demonstrator who was after one goal all along, from how far actions fall short of the best for it.

    p(α | O) ∝ Σ_g p_g Π_i p(a_i | s_i, g, α)^w, flat in log α: the goal is summed out under its prior. For several
    goals use ``sample(likelihood, confidence=OneConfidence())``.

    Parameters
    ----------
    likelihood:
        The table of a demonstration of one manoeuvre, repeated or held; its own confidence plays no part.
    level:
        Probability of the interval, which leaves as much below as above.
    weight:
        w, how many independent observations each one counts for. Not given: the weights of the likelihood if it has
        some, else 1/τ, where τ is the autocorrelation time, by the rule of ``subgoal.evidence.evidence``, of the scores
        ∂ log p(a_i | s_i, g)/∂(action asked for) at the best α and g, less their mean, or of those by log α where it is
        longer. One who is off for a second is off once, not in every sample of that second; without w the interval is
        too short. One who is off by the same throughout is so in this recording: of another it says nothing.

    Returns
    -------
    Expertise. Its ``warning`` says where the answer is at an edge. Where the density needs test actions, only such α
    are told as leave it at least half a step between them wide: above, their mean is no integral any more.

    Raises
    ------
    InputError
        A posterior, a table of given numbers, a background, a level outside (0, 1), a weight that is not above zero.
    """
    one, by = _checked(likelihood, level, weight)
    return _expertises(one, np.zeros(one.n_observations, np.int64), ("",), by, level)[""]


def compare_expertise(
    demonstrators: Mapping[str, LogLikelihood] | LogLikelihood, *, level: float = 0.9, weight: float | None = None
) -> ExpertiseTable:
    """``expertise`` of several demonstrators, and the probability that one is more expert than another.

    Parameters
    ----------
    demonstrators:
        A likelihood for each by name; or one likelihood of demonstrations that have groups, each after one goal of its
        own. α compares where goals, world and metric are the same: one likelihood for all sees to that.
    level, weight:
        As in ``expertise``.

    Raises
    ------
    InputError
        What ``expertise`` raises, for the demonstrator at fault; demonstrations without groups; nobody.
    """
    if not isinstance(demonstrators, Mapping):
        one, by = _checked(demonstrators, level, weight)
        demos = one.demonstrations
        return ExpertiseTable(_expertises(one, demos.group[demos.trajectory], demos.group_names, by, level))
    if not demonstrators:
        raise InputError("demonstrators", found="none", wanted="a likelihood for each, by name")
    return ExpertiseTable({
        str(name): expertise(each, level=level, weight=weight) for name, each in demonstrators.items()
    })  # fmt: skip


def _checked(likelihood: Any, level: Any, weight: Any) -> tuple[LogLikelihood, float | None]:
    if not isinstance(likelihood, LogLikelihood):
        raise InputError(
            "likelihood", found=type(likelihood).__name__, wanted="a LogLikelihood",
            hint="posterior.likelihood for one manoeuvre; sample(..., confidence=subgoal.models.OneConfidence()) for "
            "several, which learns one α for all",
        )  # fmt: skip
    if likelihood.background:
        raise InputError("background", found=likelihood.background, wanted=BACKGROUND, hint="with_background(0)")
    if not 0 < positive("level", level) < 1:
        raise InputError("level", found=level, wanted="a probability below 1")
    if weight is None:
        return likelihood, None if likelihood.weight is None else 1.0
    return replace(likelihood, weight=None), positive("weight", weight)


def _expertises(
    likelihood: LogLikelihood, group: Ints, names: tuple[str, ...], weight: float | None, level: float
) -> dict[str, Expertise]:
    """Of each group of observations, numbered in ``group`` (N,)."""
    coarse = likelihood.source.unit * np.geomspace(*RANGE, COARSE)
    total = np.array([_sums(likelihood, alpha, group, len(names)) for alpha in coarse])
    for k, name in enumerate(names):
        if not np.isfinite(total[:, k]).any():
            raise InputError("likelihood", where=name or None, found="no candidate that allows all observations",
                             wanted="one that does")  # fmt: skip
    told = _Told(likelihood)
    return {
        name: _expertise(likelihood, told, np.flatnonzero(group == k), coarse, total[:, k], weight, level)
        for k, name in enumerate(names)
    }


class _Told:
    """Observations beside one candidate each, made once for all groups."""

    def __init__(self, likelihood: LogLikelihood) -> None:
        self.likelihood, self.held = likelihood, dict[int, Assigned]()

    def of(self, goal: int, rows: Ints) -> Assigned:
        """The rows, had they all been for one candidate."""
        if goal not in self.held:
            self.held[goal] = self.likelihood.source.assigned(np.full(self.likelihood.n_observations, goal))
        return self.held[goal].some(rows)


def _expertise(
    likelihood: LogLikelihood, told: _Told, rows: Ints, coarse: Floats, total: Floats, weight: float | None,
    level: float,
) -> Expertise:  # fmt: skip
    """Of the observations ``rows``; ``total`` (L, G) are their sums at the ``coarse`` levels."""
    joint = total + likelihood.log_prior
    most, fine_enough = _most_that_is_told(told, rows, coarse, joint)
    levels = np.append(coarse[coarse < most], most)
    joint = joint[: levels.size]
    start, goal = np.unravel_index(int(np.argmax(joint)), joint.shape)
    if weight is None:
        weight = _weight(likelihood, told.of(int(goal), rows), rows, float(levels[start]))
    scale = weight * (np.ones(rows.size) if likelihood.weight is None else likelihood.weight[rows])
    best = (weight * total[: levels.size] + likelihood.log_prior).max(axis=0)
    in_play = np.flatnonzero(best >= best.max() - IN_PLAY - scale.sum() / 10)
    accounts = [told.of(int(g), rows) for g in in_play]

    def log_joint(at: Floats) -> Floats:
        """(L, candidates in play)."""
        fits = [[float(scale @ each.log_density(alpha)) for each in accounts] for alpha in at.tolist()]
        return np.asarray(likelihood.log_prior[in_play] + np.array(fits))

    levels, fitted = _zoomed(levels, log_joint)
    law = np.exp(fitted - fitted.max())
    levels, density = _smooth(levels, logsumexp(fitted, axis=1))
    low, middle, high = quantiles(levels, density, ((1 - level) / 2, 0.5, (1 + level) / 2))
    first = int(law.sum(axis=0).argmax())
    return Expertise(
        confidence=middle, interval=(low, high), level=level, n_observations=rows.size, worth=float(scale.sum()),
        confidences=frozen(levels), density=frozen(density), goal=int(in_play[first]),
        goal_probability=float(law.sum(axis=0)[first] / law.sum()), searched=(float(coarse[0]), most),
        fine_enough=fine_enough, steps_wide=_steps_wide(accounts[first], middle),
    )  # fmt: skip


def _sums(likelihood: LogLikelihood, alpha: float, group: Ints, count: int) -> Floats:
    """(groups, G) Σ ℓ_ig over the rows of each group, each times its weight."""
    total = np.zeros((count, likelihood.n_candidates))
    for start, tile in likelihood.at(alpha).tiles():
        np.add.at(total, group[start : start + len(tile)], tile)
    return total


def _most_that_is_told(told: _Told, rows: Ints, coarse: Floats, joint: Floats) -> tuple[float, bool]:
    """The largest α at which test actions are close enough for the best candidate; and whether all levels are below."""

    def wide_enough(goal: int, alpha: float) -> bool:
        return _steps_wide(told.of(goal, rows), alpha) >= RESOLVED

    goal = -1
    for k, alpha in enumerate(coarse.tolist()):
        before, goal = goal, int(joint[k].argmax())
        if wide_enough(goal, alpha):
            continue
        if k == 0:
            raise InputError("test actions", found="too few to tell any confidence", wanted="more",
                             hint="ContinuousWorld(..., test_actions=action_grid(low, high, 33))")  # fmt: skip
        low, high = float(coarse[k - 1]), alpha
        while high > 1.01 * low:
            middle = math.sqrt(low * high)
            low, high = (middle, high) if wide_enough(before, middle) else (low, middle)
        return low, False
    return float(coarse[-1]), True


def _weight(likelihood: LogLikelihood, told: Assigned, rows: Ints, alpha: float) -> float:
    """1/τ of the scores of one candidate: in the action asked for, or in log α, whichever are worth less."""
    below, above = alpha * math.exp(-SLOPE), alpha * math.exp(SLOPE)
    of_alpha = (told.log_density(above) - told.log_density(below)) / (2 * SLOPE)
    of_action = told.score(alpha)
    spoken = (of_action != 0).any(axis=1)
    if not spoken.any():
        return 1.0
    trajectory = likelihood.demonstrations.trajectory[rows]
    return min(
        autocorrelation(
            trajectory, [(np.where(spoken[:, None], score - score[spoken].mean(axis=0), 0.0), spoken)]
        ).weight
        for score in (of_alpha[:, None], of_action)
    )


def _zoomed(levels: Floats, log_joint: Any) -> tuple[Floats, Floats]:
    """Levels, evenly apart in log α, that cover what is not negligible with half of them at least; and their joint."""
    low, high = float(levels[0]), float(levels[-1])
    while True:
        levels = np.geomspace(low, high, FINE)
        joint = log_joint(levels)
        each = logsumexp(joint, axis=1)
        kept = np.flatnonzero(each >= each.max() - NEGLIGIBLE)
        if kept[-1] - kept[0] >= FINE // 2:
            return levels, joint
        low, high = float(levels[max(kept[0] - 1, 0)]), float(levels[min(kept[-1] + 1, FINE - 1)])


def _smooth(levels: Floats, log_joint: Floats) -> tuple[Floats, Floats]:
    """More levels, and the density of log α there, by a cubic spline of its logarithm."""
    finer = np.geomspace(levels[0], levels[-1], MANY)
    value = CubicSpline(np.log(levels), log_joint)(np.log(finer))
    density = np.exp(value - value.max())
    return finer, np.asarray(density / trapezoid(density, np.log(finer)))


def _steps_wide(told: Assigned, alpha: float) -> float:
    """How many steps between test actions the density is wide, in its narrowest dimension; inf where none are used."""
    if not isinstance(told, TestedValues):
        return math.inf
    return float(told.steps_wide(alpha).mean(axis=0).min())
