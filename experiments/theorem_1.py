"""Theorem 1, read as it holds: the best draw so far reaches the mode, for the right chain and for a wrong one.

Five pairs in a corridor of five cells, every cell a candidate, so that all 3,125 assignments θ can be enumerated. The
expected 0-1 loss (4.13) of an estimate θ̂ is 1 − P(θ̂ | O); for the visited draw of highest joint density it falls to
its minimum with any chain that visits everything. What a biased chain gets wrong is everything else: how often each θ
is drawn.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.special import gammaln, logsumexp

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from subgoal.candidates import every_state
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.grids.grid import GridWorld
from subgoal.partition.protocol import Chain, Sampler
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream
from subgoal.samplers import alg4_corrected, alg4_literal, collapsed_blocks

CONCENTRATION, CONFIDENCE = 1.0, 10.0
CHAINS, SWEEPS, QUICK_CHAINS = 400, 1_000, 40
NEAR = 0.01
SAMPLERS: dict[str, Sampler] = {
    "Algorithm 4, corrected": alg4_corrected,
    "Algorithm 4 as printed": alg4_literal,
    "collapsed_blocks": collapsed_blocks,
}


def corridor() -> LogLikelihood:
    """Two pairs towards the right end, a stay there, two towards the left."""
    grid = GridWorld(np.ones((1, 5), bool), discount=0.9, moves=4)
    names = ["E", "E", "stay", "W", "W"]
    demos = Demonstrations.from_arrays(np.array([1, 3, 4, 3, 2]), np.array([grid.action(name) for name in names]))
    return planned_actions(demos, every_state(grid.mdp), grid.mdp, confidence=CONFIDENCE)


def posterior_by_enumeration(likelihood: LogLikelihood) -> Floats:
    """(G^N,) P(θ | O) of every assignment, the last observation running fastest: Dirichlet-multinomial times ΠL."""
    n, g_count = likelihood.n_observations, likelihood.n_candidates
    thetas = np.array(list(product(range(g_count), repeat=n)))
    mass = CONCENTRATION * np.exp(likelihood.log_prior)
    counts = (thetas[:, :, None] == np.arange(g_count)).sum(axis=1)
    table: Any = likelihood.dense
    log_joint = (gammaln(counts + mass) - gammaln(mass)).sum(axis=1) + table[np.arange(n), thetas].sum(axis=1)
    return np.asarray(np.exp(log_joint - logsumexp(log_joint)))


def chains(likelihood: LogLikelihood, sampler: Sampler, count: int, seed: int) -> Ints:
    """(count, SWEEPS) the number of the assignment after each sweep of each chain."""
    weights = likelihood.n_candidates ** np.arange(likelihood.n_observations)[::-1]
    keep = np.ones(SWEEPS, bool)
    return np.stack([
        sampler(Chain(likelihood, CONCENTRATION, stream(seed, k)), keep).assignments @ weights for k in range(count)
    ])  # fmt: skip


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Loss of the best draw so far, and total variation of what is drawn, for each chain."""
    likelihood = corridor()
    exact = posterior_by_enumeration(likelihood)
    count = QUICK_CHAINS if options.quick else CHAINS
    drawn = {name: chains(likelihood, sampler, count, options.seed) for name, sampler in SAMPLERS.items()}
    losses = {name: best_so_far(exact, visits).mean(axis=0) for name, visits in drawn.items()}
    least = float(1 - exact.max())
    headline = {
        "assignments": exact.size,
        "least_expected_loss": least,
        "sweeps_to_within_1_percent": {
            name: int(np.argmax(loss <= least + NEAR)) + 1 if (loss <= least + NEAR).any() else None
            for name, loss in losses.items()
        },
        "final_expected_loss": {name: float(loss[-1]) for name, loss in losses.items()},
        "total_variation": {name: total_variation(exact, visits) for name, visits in drawn.items()},
        "chains": count,
        "sweeps": SWEEPS,
    }
    return headline, picture(losses, least, headline)


def best_so_far(exact: Floats, visits: Ints) -> Floats:
    """(chains, sweeps) 1 − P of the most probable assignment visited up to each sweep."""
    return np.asarray(1 - np.maximum.accumulate(exact[visits], axis=1))


def total_variation(exact: Floats, visits: Ints) -> float:
    """Half the summed difference between how often assignments were drawn, after the first tenth, and P(θ | O)."""
    often = np.bincount(visits[:, SWEEPS // 10 :].ravel(), minlength=exact.size)
    return float(0.5 * np.abs(often / often.sum() - exact).sum())


def picture(losses: dict[str, Floats], least: float, headline: Headline) -> Figure:
    """Loss of the best draw against the number of sweeps, and the distance of all draws from the posterior."""
    figure = sheet(10.5, 4.2)
    left, right = figure.subplots(1, 2, width_ratios=(3, 2))
    for k, (name, loss) in enumerate(losses.items()):
        left.plot(np.arange(1, SWEEPS + 1), loss, color=PALETTE[k], label=name)
    left.axhline(least, color=INK, lw=0.9, ls=":", label="least there can be")
    left.set(xscale="log", xlabel="sweeps T", ylabel="expected 0-1 loss of the best draw so far")
    left.legend(fontsize=8.5)
    left.set_title("The best draw so far reaches the mode, even with a wrong chain ...")
    variation = headline["total_variation"]
    bars = right.barh(list(variation), list(variation.values()), color=PALETTE[: len(variation)], height=0.55)
    right.bar_label(bars, [f"{value:.3f}" for value in variation.values()], padding=4, fontsize=9)
    right.set(xlabel="total variation from the posterior", xlim=(0, 1.25 * max(variation.values())))
    right.invert_yaxis()
    right.grid(visible=False)
    right.axvline(0, color=GREY, lw=0.8)
    right.set_title("... but its draws are not the posterior")
    return figure


if __name__ == "__main__":
    run("theorem_1", experiment)
