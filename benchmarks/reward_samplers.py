"""PolicyWalk against Hamiltonian Monte Carlo on the reward of every cell of Room World: effective draws per second.

The gradient is exact where the greedy policy is unique: dV/dR = (I − γP_π)⁻¹. Trajectories of ``LEAPS`` steps are
accepted by Metropolis; the length of a step is set in the warm-up for 80 % acceptance. Both have the same likelihood
and the same Gaussian prior; Hamiltonian draws are of continuous rewards, PolicyWalk's lie on its lattice. One chain
each; the worth of a run is the bulk effective sample size of the log joint, and its median over the cells that were
visited, over the seconds after the first half.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from benchmarks.common import Row
from benchmarks.policy_walk import CONFIDENCE, law
from subgoal.irl.reward_priors import Gaussian
from subgoal.irl.reward_walk import RewardChain, RewardLaw
from subgoal.posterior.diagnostics import diagnose
from subgoal.runtime.checks import Floats, Ints

SECONDS, LEAPS, WANTED = 60.0, 10, 0.8
DEVIATION, STEP = 3.0, 1.0
KEPT_EVERY = 193
"""Steps of PolicyWalk between draws that are kept: one for each cell."""


class Gradient:
    """log joint of a reward and its gradient, by policy iteration from the last policy."""

    def __init__(self, problem: RewardLaw) -> None:
        mdp, pairs = problem.mdp, problem.pairs
        self.transition = (mdp.discount * mdp.matrix).toarray().reshape(*mdp.available.shape, -1)
        self.rows = np.arange(mdp.n_states)
        self.policy = np.zeros(mdp.n_states, int)
        self.states, where = np.unique(pairs.states, return_inverse=True)
        self.taken = np.zeros((self.states.size, mdp.n_actions))
        np.add.at(self.taken, (where, pairs.actions), 1.0)

    def __call__(self, reward: Floats) -> tuple[float, Floats]:
        """Value and (S,) gradient."""
        while True:
            factor = lu_factor(np.eye(self.rows.size) - self.transition[self.rows, self.policy])
            value = lu_solve(factor, reward)
            ahead = self.transition @ value
            better = ahead.max(axis=1) > ahead[self.rows, self.policy] + 1e-11
            if not better.any():
                break
            self.policy = np.where(better, ahead.argmax(axis=1), self.policy)
        table = CONFIDENCE * ahead[self.states]
        peak = table.max(axis=1, keepdims=True)
        total = np.log(np.exp(table - peak).sum(axis=1, keepdims=True)) + peak
        fit = float((self.taken * (table - total)).sum())
        slope = self.taken - self.taken.sum(axis=1, keepdims=True) * np.exp(table - total)
        pulled = CONFIDENCE * np.einsum("ua,uas->s", slope, self.transition[self.states])
        gradient = lu_solve(factor, pulled, trans=1) - reward / DEVIATION**2
        return fit - 0.5 * float((reward / DEVIATION) @ (reward / DEVIATION)), gradient


def hamiltonian(problem: RewardLaw, budget: float) -> tuple[Floats, Floats, float]:
    """(K, S) draws and (K,) log joints of the second half of the time, and its seconds."""
    target, generator = Gradient(problem), np.random.default_rng(0)
    reward: Floats = np.zeros(problem.mdp.n_states)
    step = 0.01
    height, slope = target(reward)
    draws: list[Floats] = []
    joints: list[Any] = []
    begin = time.perf_counter()
    while time.perf_counter() - begin < budget:
        momentum = generator.standard_normal(reward.size)
        place, pull, high = reward, slope, height
        energy = height - 0.5 * float(momentum @ momentum)
        for _ in range(LEAPS):
            momentum = momentum + 0.5 * step * pull
            place = place + step * momentum
            high, pull = target(place)
            momentum = momentum + 0.5 * step * pull
        chance = float(np.exp(min(0.0, high - 0.5 * float(momentum @ momentum) - energy)))
        if generator.random() < chance:
            reward, height, slope = place, high, pull
        if time.perf_counter() - begin < budget / 2:
            step *= float(np.exp(0.1 * (chance - WANTED)))
        else:
            draws.append(reward)
            joints.append(height)
    return np.array(draws), np.array(joints), budget / 2


def walked(problem: RewardLaw, budget: float) -> tuple[Floats, Floats, float]:
    """The same of PolicyWalk, one draw for so many steps."""
    chain = RewardChain(problem, np.random.default_rng(0))
    keep = np.arange(1, 20 * KEPT_EVERY + 1) % KEPT_EVERY == 0
    draws: list[Floats] = []
    joints: list[Any] = []
    begin = time.perf_counter()
    while time.perf_counter() - begin < budget:
        made = chain.advance(np.ones(keep.size), keep)
        if time.perf_counter() - begin >= budget / 2:
            draws.append(made.points * STEP)
            joints.append(made.log_joint[keep])
    return np.concatenate(draws), np.concatenate(joints), budget / 2


def worth(draws: Floats, joints: Floats, seconds: float, visited: Ints) -> tuple[float, float]:
    """Effective draws per second of the log joint, and in the median over the cells visited."""

    def halves(values: Floats) -> Floats:
        return values[: values.size // 2 * 2].reshape(2, -1)

    cells = [diagnose(halves(draws[:, s])).ess_bulk for s in visited]
    return diagnose(halves(joints)).ess_bulk / seconds, float(np.median(cells)) / seconds


def compared(budget: float = SECONDS) -> list[Row]:
    """Both samplers for the same time."""
    base = law()
    problem = RewardLaw(
        base.mdp, base.pairs, base.features, Gaussian(DEVIATION), CONFIDENCE, STEP, base.reading, base.relevance
    )
    visited = np.unique(base.pairs.states)
    walk = worth(*walked(problem, budget), visited)
    smooth = worth(*hamiltonian(problem, budget), visited)
    return [
        Row(f"PolicyWalk, effective draws of {what}", f"{ours:.2f}/s", "measured", True, "Hamiltonian", ours / other)
        for what, ours, other in zip(("the log joint", "a cell's reward"), walk, smooth, strict=True)
    ]


if __name__ == "__main__":
    for row in compared():
        print(row)
