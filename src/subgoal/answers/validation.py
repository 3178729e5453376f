"""How well trajectories are foretold that a posterior has not seen: cross-validation, always by whole trajectories.

Steps of one trajectory tell of each other, so that none may be foretold from its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal.answers.filtering import DRAWS, filtering
from subgoal.answers.trajectory_scores import TrajectoryScores
from subgoal.demonstrations.records import Demonstrations
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.trajectories import trajectory_log_likelihood
from subgoal.runtime.checks import Floats, Ints, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream

LOO_DRAWS = 1000
LEAST_DRAWS = 100
MOST_K = 0.7


@dataclass(frozen=True, eq=False, repr=False)
class CrossValidation(TrajectoryScores):
    """Scores of trajectories, each from a posterior of those in other folds.

    Attributes
    ----------
    fold:
        (D,) the fold of each trajectory.
    statuses:
        Whether the posterior of each fold converged.
    """

    fold: Ints
    statuses: tuple[Status, ...]


@dataclass(frozen=True, eq=False, repr=False)
class LeaveOneOut(TrajectoryScores):
    """Scores of trajectories, each as if it had been left out, from one posterior of all (PSIS-LOO).

    Attributes
    ----------
    pareto_k:
        (D,) shape of the tail of the importance weights of each trajectory. Above ``most_k`` its score is not to be
        trusted: the posterior without it is too far from that with it.
    most_k:
        min(1 − 1/log₁₀ S, 0.7) for S draws (Vehtari et al. 2024).
    in_sample:
        (D,) log p(actions of the trajectory | O), from the posterior that has seen it, nats.
    """

    pareto_k: Floats
    most_k: float
    in_sample: Floats

    @property
    def doubtful(self) -> Ints:
        """Trajectories whose Pareto k is too large; refit without them, for example with ``cross_validate``."""
        return np.flatnonzero(~(self.pareto_k <= self.most_k))

    @property
    def effective_parameters(self) -> float:
        """Nats by which the trajectories are told better by a posterior that has seen them."""
        return float((self.in_sample - self.log_predictive).sum())


def cross_validate(
    make: Callable[[Demonstrations], Posterior],
    demonstrations: Demonstrations,
    *,
    folds: int = 5,
    seed: int = 0,
    draws: int = DRAWS,
    progress: Progress | None = None,
) -> CrossValidation:
    """Score every trajectory by a posterior of the trajectories in the other folds.

    Where each step is a trajectory of its own, as for a table without ``offset``, folds are of single steps. That is
    meant for steps that do not follow each other: the exchangeable model can be scored so, while neighbours of one
    recording would foretell each other. Models of time refuse such demonstrations.

    Parameters
    ----------
    make:
        From demonstrations to a posterior: candidates, likelihood and sampling, all from these demonstrations alone.
        Any model that ``filtering`` takes: the exchangeable one, ``Persistent``, ``StickyHMM``, and ``learn``.
    folds:
        At most as many as there are trajectories; as many leaves out one at a time.
    seed:
        Which trajectories go together hangs on it alone, so that models can be compared on the same folds.
    draws:
        As in ``filtering``.
    progress:
        Told the folds.

    Raises ``InputError`` for fewer than two trajectories, for too many folds, where ``make`` gives no posterior, and
    what ``make`` and ``filtering`` raise: groups cannot be scored so.
    """
    count, folds = demonstrations.n_trajectories, whole("folds", folds, least=2)
    if folds > count:
        raise InputError("folds", found=folds, wanted=f"at most {count}, as there are so many trajectories")
    fold = np.empty(count, np.int64)
    fold[stream(seed, count).permutation(count)] = np.arange(count) % folds
    scores, statuses = np.empty(count), []
    with progress or Silent() as display:
        for k in range(folds):
            posterior = make(some_trajectories(demonstrations, np.flatnonzero(fold != k)))
            if not isinstance(posterior, Posterior):
                raise InputError("make", found=type(posterior).__name__, wanted="a function that gives a Posterior")
            held = some_trajectories(demonstrations, np.flatnonzero(fold == k))
            found = filtering(posterior, held, draws=draws, seed=seed)
            scores[fold == k] = np.add.reduceat(found.log_predictive, held.offset[:-1])
            statuses.append(posterior.status)
            display.update(k + 1, folds)
    return CrossValidation(scores, np.diff(demonstrations.offset), fold, tuple(statuses))


def leave_one_out(posterior: Posterior, *, draws: int = LOO_DRAWS, seed: int = 0) -> LeaveOneOut:
    """Score every trajectory as if it had been left out, by Pareto-smoothed importance sampling (Vehtari et al. 2024).

    Draws are weighed by one over the likelihood of the trajectory, its subgoals summed out, under the weights (or rows
    of transitions), persistence and noise of the draw. Where observations are weighted, that likelihood has the
    weights, as the posterior has, and the score has none, as in ``filtering``. What was made from all trajectories
    before sampling (candidates, weights of observations) is taken as given; ``cross_validate`` makes it anew.

    Where each step is a trajectory of its own, single steps are left out: as in ``cross_validate``, that is meant for
    steps that do not follow each other.

    The weights are smoothed by ``arviz_stats``, which comes with the library: the extra ``arviz`` is not needed.

    Parameters
    ----------
    draws:
        Spread over the chains; at least 100.
    seed:
        Draws the weights.

    Raises ``InputError`` for fewer than two trajectories or 100 draws, for groups (their trajectories are not
    independent given what is shared), for the printed samplers, whose draws are not from a posterior, and for a
    posterior without its likelihood; for ``StickyHMM`` also without assignments.
    """
    if posterior.demonstrations.n_trajectories < 2:
        raise InputError("demonstrations", found="one trajectory", wanted="two or more, to leave one out")
    if posterior.status is Status.BIASED:
        raise InputError("posterior", found=posterior.settings.sampler, wanted="draws from a posterior, to be weighed")
    per_chain = whole("draws", draws, least=LEAST_DRAWS) // posterior.n_chains
    columns = np.unique(np.linspace(0, posterior.n_draws - 1, max(per_chain, 1)).astype(int))
    rows = (np.arange(posterior.n_chains)[:, None] * posterior.n_draws + columns).ravel()
    if rows.size < LEAST_DRAWS:
        raise InputError("posterior", found=f"{rows.size} draws", wanted=f"at least {LEAST_DRAWS}")
    plain = trajectory_log_likelihood(posterior, rows, seed=seed, weighted=False)
    likelihood = posterior.likelihood
    factor = plain
    if likelihood is not None and likelihood.weight is not None:
        factor = trajectory_log_likelihood(posterior, rows, seed=seed)
    log_weight, pareto_k = _smoothed(factor, posterior.n_chains)
    return LeaveOneOut(
        log_predictive=np.logaddexp.reduce(log_weight + plain, axis=0),
        decisions=np.diff(posterior.demonstrations.offset),
        pareto_k=pareto_k,
        most_k=min(1 - 1 / np.log10(rows.size), MOST_K),
        in_sample=np.logaddexp.reduce(plain, axis=0) - np.log(rows.size),
    )


def _smoothed(factor: Floats, chains: int) -> tuple[Floats, Floats]:
    """Log weights (S, D) that sum to one over the draws, and Pareto k (D,), for weights 1/exp(factor)."""
    from arviz_stats import base

    array_stats: Any = vars(base)["array_stats"]
    log_weight, pareto_k = np.empty(factor.shape), np.empty(factor.shape[1])
    for d, column in enumerate(factor.T):
        raised = column - column.min()
        ratio = np.exp(-raised)
        if np.ptp(ratio) == 0:
            log_weight[:, d], pareto_k[d] = -np.log(column.size), -np.inf
            continue
        effective = float(array_stats.ess(ratio.reshape(chains, -1), method="mean")) / column.size
        try:
            log_weight[:, d], pareto_k[d] = array_stats.psislw(raised, r_eff=min(max(effective, 1e-3), 1.0))
        except ValueError:
            log_weight[:, d], pareto_k[d] = -raised - np.logaddexp.reduce(-raised), np.inf
    return log_weight, np.where(np.isnan(pareto_k), np.inf, pareto_k)


def some_trajectories(demonstrations: Demonstrations, which: Ints) -> Demonstrations:
    """The demonstrations of trajectories ``which``, in that order."""
    offset = demonstrations.offset
    rows = np.concatenate([np.arange(offset[d], offset[d + 1]) for d in which.tolist()])
    names, groups = demonstrations.trajectory_names, demonstrations.groups
    return replace(
        demonstrations,
        states=demonstrations.states[rows],
        actions=demonstrations.actions[rows],
        offset=np.concatenate([[0], np.cumsum(np.diff(offset)[which])]),
        times=None if demonstrations.times is None else demonstrations.times[rows],
        final_states=demonstrations.final_states[which],
        truncated=demonstrations.truncated[which],
        trajectory_names=tuple(names[d] for d in which.tolist()),
        groups=tuple(groups[d] for d in which.tolist()) if groups else (),
    )
