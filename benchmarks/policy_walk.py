"""PolicyWalk on Room World: low-rank updates against solving the world anew, by NumPy and by compiled backups.

The alternative walk makes the same proposals and draws with NumPy policy iteration, started from the last policy, so
that its acceptances and its values are those that the fast walk must have.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.common import Row
from subgoal.irl.reward_priors import Gaussian
from subgoal.irl.reward_walk import RewardChain, RewardLaw, Steps
from subgoal.irl.single_reward import shown
from subgoal.mdp.grids.rooms import room_world
from subgoal.mdp.planners.iteration import value_iteration
from subgoal.mdp.planners.policy import imperfect
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.mdp.simulation import simulate
from subgoal.runtime.checks import Bools, Floats

STEPS, RESOLVED = 10_000, 500
CONFIDENCE, STEP, PRIOR = 0.95, 1 / 3, Gaussian(22.4)
TOLERANCE, CLOSE = 1e-9, 1e-9
LEAST_STEPS, LEAST_RATIO = 3_000, 10


def law() -> RewardLaw:
    """5,000 pairs of an expert that errs in layout A, a reward for every cell (thesis 3.4)."""
    world = room_world("A")
    mdp = world.grid.mdp
    policy = imperfect(mdp, policy_iteration(mdp, world.reward).policy)
    demos = simulate(mdp, policy, steps=50, trajectories=100, start=world.start, seed=0)
    cells = np.eye(mdp.n_states)
    return RewardLaw(mdp, shown(demos, mdp), cells, PRIOR, CONFIDENCE, STEP, "product", np.ones(mdp.n_states))


def fast(problem: RewardLaw, steps: int) -> tuple[Steps, float]:
    """What the walk leaves, and its seconds, compiled code being warm."""
    RewardChain(problem, np.random.default_rng(1)).advance(np.ones(9), np.ones(9, bool))
    chain = RewardChain(problem, np.random.default_rng(0))
    begin = time.perf_counter()
    made = chain.advance(np.ones(steps), np.ones(steps, bool))
    return made, time.perf_counter() - begin


class Anew:
    """A walk that solves for every proposal, by ``solve(reward, policy, value)``, which returns both anew."""

    def __init__(self, problem: RewardLaw, solve: Any) -> None:
        self.problem, self.solve = problem, solve
        mdp, pairs = problem.mdp, problem.pairs
        self.transition = (mdp.discount * mdp.matrix).toarray().reshape(*mdp.available.shape, -1)
        self.states, where = np.unique(pairs.states, return_inverse=True)
        self.taken = np.zeros((self.states.size, mdp.n_actions))
        np.add.at(self.taken, (where, pairs.actions), 1.0)
        self.reward = np.zeros(mdp.n_states)
        self.policy, self.value = solve(self.reward, np.zeros(mdp.n_states, int), np.zeros(mdp.n_states))
        self.fit = self.log_likelihood(self.value)

    def log_likelihood(self, value: Floats) -> float:
        """Product over observations."""
        table = CONFIDENCE * (self.transition[self.states] @ value)
        peak = table.max(axis=1, keepdims=True)
        return float((self.taken * (table - peak - np.log(np.exp(table - peak).sum(axis=1, keepdims=True)))).sum())

    def walk(self, steps: int, generator: np.random.Generator) -> tuple[Bools, Floats, float]:
        """(steps,) accepted, (steps, S) values, and seconds."""
        accepted, values = np.zeros(steps, bool), np.empty((steps, self.reward.size))
        begin = time.perf_counter()
        for t in range(steps):
            f = int(generator.random() * self.reward.size)
            proposal = self.reward.copy()
            proposal[f] += STEP if generator.random() < 0.5 else -STEP
            policy, value = self.solve(proposal, self.policy, self.value)
            fit = self.log_likelihood(value)
            before, after = PRIOR.log_density(np.array([self.reward[f], proposal[f]]))
            accepted[t] = generator.random() < np.exp(min(0.0, fit - self.fit + float(after - before)))
            if accepted[t]:
                self.reward, self.policy, self.value, self.fit = proposal, policy, value, fit
            values[t] = self.value
        return accepted, values, time.perf_counter() - begin


def by_numpy(problem: RewardLaw) -> Any:
    """Policy iteration with dense solves."""
    mdp = problem.mdp
    transition = (mdp.discount * mdp.matrix).toarray().reshape(*mdp.available.shape, -1)
    rows = np.arange(mdp.n_states)

    def solve(reward: Floats, policy: Any, value: Floats) -> tuple[Any, Floats]:
        while True:
            value = np.linalg.solve(np.eye(rows.size) - transition[rows, policy], reward)
            ahead = transition @ value
            better = ahead.max(axis=1) > ahead[rows, policy] + 1e-12
            if not better.any():
                return policy, value
            policy = np.where(better, ahead.argmax(axis=1), policy)

    return solve


def by_backups(problem: RewardLaw) -> Any:
    """Compiled value iteration from the last values, front to back and back."""

    def solve(reward: Floats, policy: Any, value: Floats) -> tuple[Any, Floats]:
        plan = value_iteration(problem.mdp, reward, initial=value, tolerance=TOLERANCE, in_place=True)
        return plan.policy, plan.value

    return solve


def walk() -> list[Row]:
    """Room World, 193 cells, 5,000 pairs."""
    problem = law()
    made, took = fast(problem, STEPS)
    accepted, values, dense = Anew(problem, by_numpy(problem)).walk(STEPS, np.random.default_rng(0))
    _, _, backups = Anew(problem, by_backups(problem)).walk(RESOLVED, np.random.default_rng(0))
    begun = fast(problem, RESOLVED)[1]
    same = bool((made.accepted == accepted).all())
    off = float(np.abs(made.values - values).max())
    rate, slower = STEPS / took, backups / begun
    return [
        Row(f"PolicyWalk, {STEPS:,} steps in Room World", f"{rate:,.0f}/s", "> 3,000/s", rate >= LEAST_STEPS,
            "NumPy policy iteration, warm", dense / took),
        Row("the same against solving anew", f"{dense / took:.0f} x", "> 10 x", dense / took >= LEAST_RATIO),
        Row(f"its first {RESOLVED} steps", f"{RESOLVED / begun:,.0f}/s", "> 10 x", slower >= LEAST_RATIO,
            "compiled value iteration, warm", slower),
        Row(f"acceptances as solved anew, {STEPS:,} steps", "same" if same else "differ", "same", same),
        Row("largest difference of values from solving anew", f"{off:.1e}", "< 1e-9", off < CLOSE),
    ]  # fmt: skip


if __name__ == "__main__":
    for row in walk():
        print(row)
