"""Maximum entropy against public packages, where both compute the same thing and where they do not.

``python -m benchmarks.max_entropy_peers`` prints one table; a package that is not installed is skipped with the reason.
Policies and likelihoods are compared, never weights. A grid of 5 × 5 cells with four noisy moves, γ = 0.9 and three
features; a soft planner shows 200 trajectories. Rows with a target hold two computations of one quantity against each
other; the others measure how far apart two objectives are on the same demonstrations.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np
from scipy.optimize import root

from benchmarks.common import Row, seconds
from subgoal._kernels.paths import log_sums
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.ascent import climb
from subgoal.irl.max_entropy import max_causal_entropy
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.planners.soft import soft_value_iteration
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats

SIDE, DISCOUNT, STEPS, TRAJECTORIES = 5, 0.9, 30, 200
WEIGHTS = np.array([-2.0, -1.5, 1.0])
SAME_POLICY, SAME_NATS, CLOSE = 1e-3, 1e-4, 1e-6


def grid(*, ends: bool) -> TabularMDP:
    """Noisy moves; with ``ends`` the far corner is terminal."""
    terminal = np.array([[SIDE - 1, SIDE - 1]]) if ends else np.empty((0, 2), int)
    free = np.ones((SIDE, SIDE), bool)
    return GridWorld(free, discount=DISCOUNT, moves=4, stay=False, slip=(0.8, 0.1, 0.0, 0.1), terminal=terminal).mdp


def features() -> Floats:
    """(25, 3) the way to the far corner, one half more than it is except there; a bad row; a good corner."""
    y, x = np.divmod(np.arange(SIDE * SIDE), SIDE)
    way = (2 * (SIDE - 1) - x - y) / SIDE
    far = way + 0.5 * (way > 0)
    return np.column_stack([far, (y == 2) & (x < 3), (x == SIDE - 1) & (y == 0)]).astype(float)


def shown(mdp: TabularMDP, steps: int) -> Demonstrations:
    """What a soft planner does from random cells."""
    start = np.where(mdp.terminal, 0.0, 1.0)
    policy = soft_value_iteration(mdp, features() @ WEIGHTS).policy
    return simulate(mdp, policy, steps=steps, trajectories=TRAJECTORIES, start=start / start.sum(), seed=1)


def dense(mdp: TabularMDP) -> Floats:
    """(S, A, S), terminal states staying where they are."""
    table = mdp.matrix.toarray().reshape(mdp.n_states, mdp.n_actions, mdp.n_states)
    table[mdp.terminal, :, np.flatnonzero(mdp.terminal)] = 1.0
    return np.asarray(table)


def nats(policy: Floats, demonstrations: Demonstrations) -> float:
    """Mean log probability of the actions shown."""
    return float(np.log(policy[demonstrations.states, demonstrations.actions]).mean())


def apart(what: str, ours: Floats, theirs: Floats, demonstrations: Demonstrations, *, same: bool) -> Row:
    """Largest difference of the policies where actions are taken, and how much better ours tells what was shown."""
    seen = np.unique(demonstrations.states)
    policy = float(np.abs(ours[seen] - theirs[seen]).max())
    better = nats(ours, demonstrations) - nats(theirs, demonstrations)
    target = f"{SAME_POLICY:g}, {SAME_NATS:g}" if same else "another aim"
    met = not same or (policy <= SAME_POLICY and abs(better) <= SAME_NATS)
    return Row(what, f"{policy:.1e}", target, met, f"nats a pair better: {better:+.5f}", None)


def by_econirl() -> list[Row]:
    """Likelihood over pairs, infinite horizon: what its L-BFGS path maximises."""
    jnp: Any = import_module("jax.numpy")
    types, estimation = import_module("econirl.core.types"), import_module("econirl.estimation.mce_irl")
    reward = import_module("econirl.preferences.reward")
    mdp = grid(ends=False)
    told, phi = shown(mdp, STEPS), features()
    after = np.append(told.states[1:], 0)
    after[told.offset[1:] - 1] = told.final_states
    panel = types.Panel.from_numpy(told.states, told.actions, after, told.trajectory)
    problem = types.DDCProblem(num_states=mdp.n_states, num_actions=mdp.n_actions, discount_factor=DISCOUNT)
    aim = reward.LinearReward(jnp.array(phi), ["far", "row", "corner"], n_actions=mdp.n_actions)
    estimator = estimation.MCEIRLEstimator(compute_se=False, inner_tol=1e-10)
    table = jnp.array(dense(mdp).transpose(1, 0, 2))
    theirs = estimator.estimate(panel, aim, problem, table)
    found = max_causal_entropy(told, mdp, phi)
    row = apart("econirl, likelihood over pairs", found.policy, np.asarray(theirs.policy), told, same=True)
    mine = seconds(lambda: max_causal_entropy(told, mdp, phi))
    yours = seconds(lambda: estimator.estimate(panel, aim, problem, table), repeats=1, warm=False)
    return [row, Row("  time of the same", f"{mine * 1e3:.0f} ms", "", True, "econirl", yours / mine)]


def by_irl_maxent() -> list[Row]:
    """Its soft planner is ours; its learners need an ending, and discount plans but not visits.

    Its policies are taken as they are; the root of its gradient (undiscounted visits, which it sums up until they
    change little, solved for exactly) is found by SciPy, as its own ascent takes minutes.
    """
    if not hasattr(np, "float"):
        setattr(np, "float", float)  # noqa: B010
    theirs: Any = import_module("irl_maxent.maxent")
    open_world, ended, phi = grid(ends=False), grid(ends=True), features()
    told, to_end = shown(open_world, STEPS), shown(ended, 1000)
    plan = soft_value_iteration(open_world, phi @ WEIGHTS).policy
    soft = theirs.local_causal_action_probabilities(dense(open_world).transpose(0, 2, 1), [], phi @ WEIGHTS, DISCOUNT)
    table, ends = dense(ended).transpose(0, 2, 1), np.flatnonzero(ended.terminal).tolist()
    start = np.bincount(to_end.states[to_end.offset[:-1]], minlength=len(phi)) / to_end.n_trajectories
    counted = np.bincount(np.append(to_end.states, to_end.final_states), minlength=len(phi)) / to_end.n_trajectories

    def causal(reward: Floats) -> Any:
        return theirs.local_causal_action_probabilities(table, ends, reward, DISCOUNT, CLOSE)

    def gradient(weights: Floats) -> Floats:
        flow = np.einsum("sta,sa->ts", table, causal(phi @ weights)) * ~ended.terminal
        return np.asarray(phi.T @ (counted - np.linalg.solve(np.eye(len(phi)) - flow, start)))

    found = root(gradient, WEIGHTS, options={"factor": 0.1})
    if not np.abs(found.fun).max() < CLOSE:
        raise RuntimeError("no root of the gradient of irl-maxent was found")

    ours = max_causal_entropy(to_end, ended, phi, objective="feature_matching")
    everywhere = list(range(open_world.n_states))
    plain = theirs.local_action_probabilities(dense(open_world).transpose(0, 2, 1), everywhere, phi @ WEIGHTS)
    return [
        apart("irl-maxent, its soft planner", plan, soft, told, same=True),
        apart("irl-maxent, its backward pass over trajectories", first_of(open_world, 2 * len(phi)), plain, told,
              same=True),
        apart("irl-maxent, causal, with an ending", ours.policy, causal(phi @ found.x), to_end, same=False),
    ]  # fmt: skip


def first_of(mdp: TabularMDP, steps: int) -> Floats:
    """(S, A) first actions of trajectories of so many steps whose last state is not paid, as there."""
    fade, sums = np.append(np.ones(steps), 0.0), np.empty((steps + 1, mdp.n_states))
    log_sums(mdp.offset, mdp.successor, np.log(mdp.probability), mdp.n_actions, features() @ WEIGHTS, fade, sums)
    ahead = dense(mdp) @ np.exp(sums[1] - sums[1].max())
    return np.asarray(ahead / ahead.sum(axis=1, keepdims=True))


def by_finite_horizon() -> list[Row]:
    """The formulas of ``imitation``'s tabular learner: backups and visits over the horizon, by default undiscounted."""
    mdp = grid(ends=False)
    told, phi, table = shown(mdp, STEPS), features(), dense(mdp)
    ours = max_causal_entropy(told, mdp, phi, objective="feature_matching").policy
    return [
        apart(f"finite horizon of {STEPS} steps, γ = {gamma:g}", ours,
              first_policy(table, phi, told, gamma), told, same=False)
        for gamma in (1.0, DISCOUNT)
    ]  # fmt: skip


def first_policy(table: Floats, phi: Floats, told: Demonstrations, gamma: float) -> Floats:
    """(S, A) at the first step of the finite-horizon policy that matches the visits shown."""
    begun = np.bincount(told.states[told.offset[:-1]], minlength=len(phi)) / told.n_trajectories
    time = np.arange(told.n_observations) % STEPS
    matched = (gamma ** time.astype(float)) @ phi[told.states] / told.n_trajectories

    def policies(weights: Floats) -> tuple[Floats, list[Floats]]:
        value, every = np.zeros(len(phi)), []
        for _ in range(STEPS):
            q = (phi @ weights)[:, None] + gamma * (table @ value)
            value = np.logaddexp.reduce(q, axis=1)
            every.append(np.exp(q - value[:, None]))
        return value, every[::-1]

    def objective(weights: Floats) -> tuple[float, Floats]:
        value, every = policies(weights)
        here, visits = begun, np.zeros(len(phi))
        for t, policy in enumerate(every):
            visits = visits + gamma**t * here
            here = np.einsum("s,sa,sat->t", here, policy, table)
        return float(weights @ matched - begun @ value), phi.T @ -visits + matched

    found = climb(objective, np.zeros(phi.shape[1]), size=1.0, tolerance=1e-6, most_iterations=500)
    return policies(found.weights)[1][0]


def main() -> int:
    """Each row as it is done; 1 if two computations of one quantity differ."""
    rows: list[Row] = []
    cases: tuple[Callable[[], list[Row]], ...] = (by_econirl, by_irl_maxent, by_finite_horizon)
    for case in cases:
        try:
            made = case()
        except ImportError as missing:
            print(f"skip  {case.__name__}: {missing}", flush=True)
            continue
        for row in made:
            print(f"{row}{'' if row.ratio is not None else row.alternative}", flush=True)
        rows += made
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
