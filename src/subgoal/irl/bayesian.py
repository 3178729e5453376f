"""Bayesian inverse reinforcement learning (thesis 3): PolicyWalk, its relevance and its cooling schedule."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.reward_posterior import RewardPosterior, greedy_policy_of
from subgoal.irl.reward_walk import Prior, RewardChain, RewardLaw, Steps
from subgoal.irl.single_reward import SingleReward, check_features, shown, told, undetermined_directions
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.posterior.diagnostics import Status, gate
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Bools, Floats, whole
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.executor import run_all, worker_count
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream

CONFIDENCE, STEP = 0.95, 1 / 3
"""α and δ of thesis 3.4."""
ROUND_SECONDS = 0.4
FIRST_STEPS, MOST_STEPS = 256, 2**16
"""Of a round."""
LEAST_ACCEPTED = 0.01
"""A chain that accepts a smaller share of its proposals hardly moves."""
ANNEALING = "Michini 2013, equation 3.11 and algorithm 3"


def bayesian_irl(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    prior: Prior,
    confidence: float = CONFIDENCE,
    step: float = STEP,
    likelihood: str = "product",
    relevance: Any = None,
    chains: int = 4,
    draws: int = 1_000,
    warmup: int = 500,
    thin: int = 1,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> RewardPosterior:
    """Draw rewards from their posterior given demonstrations of one agent that is after one reward.

    PolicyWalk (Ramachandran & Amir 2007; thesis algorithm 3 at temperature 1): one coordinate moves by ±δ at a time and
    is accepted by Metropolis; the optimal values are kept exact by low-rank updates, so that no world is solved anew.

    Parameters
    ----------
    demonstrations, mdp:
        N pairs of a discrete world of S states and A actions with a discount below 1. Trajectories or unordered pairs:
        only the pairs count.
    features:
        (S, F) Φ with R = Φw; not given: R(s) is free in each state, w = R.
    prior:
        Law of each w_f, such as those of ``subgoal.irl.reward_priors``.
    confidence:
        α of (3.2), in nats per unit of reward.
    step:
        δ, in units of w: chains live on the lattice start + δ·integers, ``start`` being the mode of the prior.
    likelihood:
        A reading of (3.3): "product" over the observations; "constant sequences", as printed; "unnormalised", exp(αΣQ).
    relevance:
        (F,) how often each coordinate is proposed, up to a constant (3.10): what is never proposed stays at the mode of
        the prior. Symmetric, so that the posterior over the others is exact. Not given: all alike.
    chains, draws, warmup, thin, seed:
        As in ``subgoal.sample``; a sweep here is as many steps as there are coordinates that may be proposed.
    workers, progress:
        Chains at once, in threads; told how many sweeps are done.

    Returns
    -------
    RewardPosterior. Ctrl-C gives the draws so far. A ``ConvergenceWarning`` where the gate is not passed, and where a
    chain accepts less than 1 % of its proposals, as where δ is too wide for the likelihood.

    Raises
    ------
    InputError
        No demonstrations, or impossible ones; NaN; a discount of 1; a relevance below 0; settings out of range.
    BudgetError
        Too many states for an inverse to be held.
    StoppedError
        Ctrl-C before there was a draw.
    """
    law = _law(demonstrations, mdp, features, prior, confidence, step, likelihood, relevance)
    chains, thin = whole("chains", chains), whole("thin", thin)
    sweep = int(np.count_nonzero(law.relevance))
    length = (whole("warmup", warmup, least=0) + whole("draws", draws) * thin) * sweep
    keep = np.zeros(length, bool)
    keep[warmup * sweep + thin * sweep - 1 :: thin * sweep] = True
    generators = [stream(whole("seed", seed, least=0), k) for k in range(chains)]
    begin = time.monotonic()
    walks = [RewardChain(law, generator, _start(law, k, generator)) for k, generator in enumerate(generators)]
    made, done = _advance(walks, np.ones(length), keep, workers, progress or Silent(), sweep)
    drift = max(walk.error_bound for walk in walks)
    posterior = _assemble(law, made, keep[:done], done < length, time.monotonic() - begin, drift)
    for problem in _problems(posterior):
        warnings.warn(problem, ConvergenceWarning, stacklevel=2)
    return posterior


def cooling(start: float = 25.0, rise: float = 1 / 50) -> Callable[[Floats], Floats]:
    """Inverse temperature 1/T_i = start + rise·i of step i (thesis 3.4), increasing where ``rise`` is above 0."""
    return lambda steps: start + rise * steps


def anneal_reward(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    prior: Prior,
    confidence: float = CONFIDENCE,
    step: float = STEP,
    likelihood: str = "product",
    relevance: Any = None,
    schedule: Callable[[Floats], Floats] | None = None,
    steps: int = 1_200,
    trace_every: int = 1,
    seed: int = 0,
    progress: Progress | None = None,
) -> SingleReward:
    """One chain with acceptance min(1, ratio^(1/T_i)) (thesis 3.11, algorithm 3): a search for an optimum.

    What it gives is no posterior: with falling temperature draws say nothing of how sure the reward is (E16). Its
    ``reward`` is that of largest log joint seen, ``trace`` where it was every ``trace_every`` steps. ``schedule`` gives
    1/T of steps 0, 1, ...; not given: ``cooling()``. Other arguments and errors are those of ``bayesian_irl``.
    """
    law = _law(demonstrations, mdp, features, prior, confidence, step, likelihood, relevance)
    steps, every = whole("steps", steps), whole("trace_every", trace_every)
    heat = np.asarray((schedule or cooling())(np.arange(steps, dtype=np.float64)), np.float64)
    if heat.shape != (steps,) or not (heat >= 0).all():
        raise InputError("schedule", found=f"numbers of shape {heat.shape}", wanted=f"{steps} of at least 0")
    walk = RewardChain(law, stream(whole("seed", seed, least=0), 0))
    keep = np.ones(steps, bool)
    made, done = _advance([walk], heat, keep, 1, progress or Silent(), 1)
    weights = np.concatenate([each.points for each in made[0]]) * law.step + law.prior.start
    best = weights[int(np.argmax(np.concatenate([each.log_joint for each in made[0]])))]
    undetermined = undetermined_directions(law.features, law.mdp)
    return SingleReward(
        method="Bayesian IRL, annealed", reference=ANNEALING, policy=greedy_policy_of(law, law.features @ best),
        reward=law.features @ best, weights=best, iterations=done, solutions=done + 1,
        outcome=Outcome.OUT_OF_ITERATIONS if done == steps else Outcome.INTERRUPTED,
        trace=weights[every - 1 :: every] @ law.features.T, undetermined=undetermined, notes=told(undetermined),
    )  # fmt: skip


def _law(
    demonstrations: Any, mdp: Any, features: Any, prior: Any, confidence: float, step: float, reading: str,
    relevance: Any,
) -> RewardLaw:  # fmt: skip
    pairs, table = shown(demonstrations, mdp), check_features(features, mdp)
    if not hasattr(prior, "log_density"):
        raise InputError("prior", found=type(prior).__name__, wanted="one of subgoal.irl.reward_priors")
    weights = np.ones(table.shape[1]) if relevance is None else relevance
    return RewardLaw(mdp, pairs, table, prior, confidence, step, reading, weights)


def _start(law: RewardLaw, chain: int, generator: np.random.Generator) -> Any:
    """Chain 0 starts at the mode of the prior, others a step away in as many coordinates as chance would have it."""
    point = np.zeros(law.features.shape[1], np.int64)
    if chain:
        moved = generator.integers(-1, 2, size=point.size) * (law.relevance > 0)
        inside = law.prior.log_density(law.prior.start + law.step * moved.astype(np.float64)) > -np.inf
        point = np.where(inside, moved, 0)
    return point


def _advance(
    walks: list[RewardChain], heat: Floats, keep: Bools, workers: int | None, display: Progress, sweep: int
) -> tuple[list[list[Steps]], int]:
    """Rounds of all chains until all steps are made or Ctrl-C; returns what they left and how many steps that is."""
    made: list[list[Steps]] = [[] for _ in walks]
    done, length = 0, FIRST_STEPS
    with Interrupt() as interrupt, display:
        while done < heat.size and not interrupt.requested:
            stop, begin = min(done + length, heat.size), time.monotonic()
            jobs = [(walk, heat[done:stop], keep[done:stop]) for walk in walks]
            for record, steps in zip(
                made, run_all(RewardChain.advance, jobs, workers=worker_count(workers)), strict=True
            ):
                record.append(steps)
            pace = (time.monotonic() - begin) / (stop - done)
            length = int(np.clip(ROUND_SECONDS / max(pace, 1e-9), FIRST_STEPS, min(4 * length, MOST_STEPS)))
            done = stop
            display.update(done // sweep, heat.size // sweep)
    return made, done


def _assemble(
    law: RewardLaw, made: list[list[Steps]], keep: Bools, interrupted: bool, seconds: float, drift: float
) -> RewardPosterior:
    kept = int(keep.sum())
    if not kept:
        raise StoppedError("stopped during the warm-up: there are no draws yet")
    points = np.stack([np.concatenate([each.points for each in chain]) for chain in made])
    values = np.stack([np.concatenate([each.values for each in chain]) for chain in made])
    traces = {
        name: np.stack([np.concatenate([getattr(each, name) for each in chain])[keep] for chain in made])
        for name in ("log_likelihood", "log_joint")
    }
    first = int(np.argmax(keep))
    accepted = np.stack([np.concatenate([each.accepted for each in chain])[first:].mean() for chain in made])
    weights = law.prior.start + law.step * points
    summaries = {"log joint": traces["log_joint"], "log likelihood": traces["log_likelihood"]}
    summaries |= {f"weight {f}": weights[:, :, f] for f in np.flatnonzero(law.relevance).tolist()}
    diagnostics, status = gate(summaries, interrupted=interrupted, biased=False)
    if status is Status.CONVERGED and not accepted.all():
        status = Status.NOT_CONVERGED
    return RewardPosterior(
        weights, values, traces["log_likelihood"], traces["log_joint"], accepted, diagnostics, status, law, seconds,
        drift, undetermined_directions(law.features, law.mdp),
    )  # fmt: skip


def _problems(posterior: RewardPosterior) -> Iterator[str]:
    """What the gate found, and chains that hardly move; a chain that never does is no sign of convergence."""
    if posterior.status is not Status.CONVERGED:
        yield posterior.status.value
    least, step = float(posterior.acceptance.min()), posterior.law.step
    if least < LEAST_ACCEPTED:
        yield (
            f"a chain accepted {least:.2%} of its proposals: one step δ = {step:g} changes the likelihood or the prior "
            f"too much. Try: step={step / 10:.3g}, or a smaller confidence"
        )
