"""Values equal those of independent public solvers; where one is not installed, its test is skipped."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.planners.iteration import modified_policy_iteration, policy_iteration, value_iteration
from tests.mdp.random_worlds import World, random_world

SEEDS = range(25)
DISCOUNTS = (0.5, 0.9, 0.99)


def everywhere(world: World) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P (S, A, S), r (S, A) and whether an action is available (S, A), as solvers that know no endings want them.

    Terminal states repeat for ever, paid 1 − γ of what they are worth; other actions that are not available are copies
    of one that is.
    """
    table, gains, legal = world.table.copy(), np.array(world.gains), world.table.any(axis=2)
    for state in range(len(table)):
        if legal[state].any():
            first = legal[state].argmax()
            table[state, ~legal[state]], gains[state, ~legal[state]] = table[state, first], gains[state, first]
        else:
            table[state, :, state], gains[state] = 1, (1 - world.discount) * world.ending[state]
    return table, gains, legal | ~legal.any(axis=1, keepdims=True)


def check_values(world: World, values, share: float = 1e-8) -> None:
    """Within ``share`` of the largest value there can be."""
    most = abs(world.reward).max() / (1 - world.discount)
    for planner in (value_iteration, modified_policy_iteration, policy_iteration):
        plan = planner(world.mdp, world.reward, tolerance=1e-10 * most)
        assert abs(plan.value - np.asarray(values)).max() <= share * most


def worlds():
    return [random_world(seed, discount=DISCOUNTS[seed % 3]) for seed in SEEDS]


@pytest.mark.parametrize("method", ["policy_iteration", "modified_policy_iteration", "linear_programming"])
def test_quantecon(method: str) -> None:
    markov = pytest.importorskip("quantecon.markov")
    for world in worlds():
        table, gains, legal = everywhere(world)
        problem = markov.DiscreteDP(np.where(legal, gains, -np.inf), table, world.discount)
        size = abs(world.reward).max()
        check_values(world, problem.solve(method=method, epsilon=1e-10 * size).v)


def test_pymdptoolbox() -> None:
    solvers = pytest.importorskip("mdptoolbox.mdp")
    for world in worlds():
        table, gains, _ = everywhere(world)
        solver = solvers.PolicyIteration(table.transpose(1, 0, 2), gains, world.discount)
        solver.run()
        check_values(world, solver.V)


def test_mdpsolver(capfd: pytest.CaptureFixture[str]) -> None:
    """Asked for a little more than is compared."""
    package = pytest.importorskip("mdpsolver")
    for world in worlds():
        table, gains, _ = everywhere(world)
        size = abs(world.reward).max()
        solver = package.model()
        solver.mdp(discount=world.discount, rewards=gains.tolist(), tranMatWithZeros=table.tolist())
        solver.solve(algorithm="mpi", tolerance=1e-10 * size * (1 - world.discount), parallel=False)
        check_values(world, solver.getValueVector())
