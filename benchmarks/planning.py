"""Planning for 80 subgoals at once against public solvers one goal at a time, all to the same accuracy.

The world is the thesis's: a grid with eight noisy directions and staying, γ = 0.99, rewards at one cell. Accuracy:
values within 1e-6 of the largest, 1/(1 − γ), checked against a plan a thousand times as exact. Public solvers are told
a tolerance that reaches it, and only their own solution time counts, not the making of their model. Others than ours
solve a few of the goals and are scaled up. A model of mdpsolver begins where its last solution ended, so each is new.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from benchmarks.common import Row, seconds
from subgoal.candidates import visited
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.iteration import value_iteration
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.sample import sample
from subgoal.runtime.checks import Floats, Ints
from subgoal.samplers import alg4_corrected

GOALS, DISCOUNT, ACCURACY = 80, 0.99, 1e-6
TOP = 1 / (1 - DISCOUNT)


def grid(side: int) -> GridWorld:
    """An open square with the slip of the thesis."""
    return GridWorld(np.ones((side, side), bool), discount=DISCOUNT, slip=THESIS_SLIP)


def goals_along_a_walk(world: GridWorld) -> Ints:
    """80 different cells that a demonstration visits: a walk between random cells, as Proposition 1 has it."""
    generator = np.random.default_rng(0)
    cells: dict[int, None] = {}
    here = generator.integers(world.free.shape[0], size=2)
    while len(cells) < GOALS:
        there = generator.integers(world.free.shape[0], size=2)
        while (here != there).any() and len(cells) < GOALS:
            here = here + np.sign(there - here)
            cells[world.state(int(here[0]), int(here[1]))] = None
    return np.array(list(cells))


def scattered_goals(world: GridWorld) -> Ints:
    """80 random cells, the hardest case: no two near each other."""
    return np.random.default_rng(1).choice(world.n_states, GOALS, replace=False)


def subgoals() -> list[Row]:
    """20 × 20 and 100 × 100, and what others take for the same."""
    rows = []
    small, large = grid(20), grid(100)
    fast = _timed(small, goals_along_a_walk(small))
    rows.append(Row("80 subgoals, 20 × 20 cells, error ≤ 1e-6", f"{fast * 1e3:.1f} ms", "< 10 ms", fast < 0.01))
    goals = goals_along_a_walk(large)
    ours, far = _timed(large, goals), _timed(large, scattered_goals(large))
    exact = plan_subgoals(large.mdp, goals, tolerance=1e-9 * TOP).value
    compiled, swept = plain(large.mdp, exact, goals)
    rows += [
        Row("80 subgoals, 100 × 100 cells, along a walk", f"{ours * 1e3:.0f} ms", "≥ 50×", compiled >= 50 * ours,
            "compiled value iteration, a goal at a time", compiled / ours),
        Row("  the same with its sweeps in place, both ways", f"{ours * 1e3:.0f} ms", "", True,
            "compiled Gauss-Seidel", swept / ours),
        Row("80 subgoals, 100 × 100 cells, scattered", f"{far * 1e3:.0f} ms", "≥ 50×", compiled >= 50 * far,
            "compiled value iteration, a goal at a time", compiled / far),
    ]  # fmt: skip
    for name, solve, target in (
        ("mdpsolver value iteration", by_mdpsolver, 8),
        ("quantecon modified policy iteration", by_quantecon, 8),
    ):
        theirs = per_goal(solve, large.mdp, exact, goals)
        for case, mine in (("along a walk", ours), ("scattered", far)):
            rows.append(Row(f"  {case}, against {name}", f"{theirs:.1f} s", f"≥ {target}×",
                            theirs >= target * mine, name, theirs / mine))  # fmt: skip
    return rows


def _timed(world: GridWorld, goals: Ints) -> float:
    return seconds(lambda: plan_subgoals(world.mdp, goals, tolerance=ACCURACY * TOP), repeats=5)


def _reward(mdp: TabularMDP, goal: int) -> Floats:
    reward = np.zeros(mdp.n_states)
    reward[goal] = 1.0
    return reward


def plain(mdp: TabularMDP, exact: Floats, goals: Ints, count: int = 2) -> tuple[float, float]:
    """Seconds that compiled value iteration takes for all goals, with whole sweeps and with sweeps in place."""
    times = []
    for in_place in (False, True):

        def solve(goal: int, in_place: bool = in_place) -> Floats:
            reward = _reward(mdp, goal)
            return value_iteration(mdp, reward, tolerance=ACCURACY * TOP, in_place=in_place).value

        solve(int(goals[0]))
        total = 0.0
        for k in range(count):
            total += _once(lambda k=k: solve(int(goals[k])))  # type: ignore[misc]
            _check(solve(int(goals[k])), exact[:, k])
        times.append(total * GOALS / count)
    return times[0], times[1]


def _check(value: Any, exact: Floats) -> None:
    gap = float(np.abs(np.asarray(value) - exact).max())
    if not gap <= ACCURACY * TOP:
        raise RuntimeError(f"a peer missed the accuracy that is compared: {gap}")


def by_mdpsolver(mdp: TabularMDP, goal: int) -> tuple[float, Any]:
    """Seconds and values of one goal by mdpsolver, in its sparse form, the faster of its serial and parallel ways."""
    from mdpsolver import model  # type: ignore[import-not-found,import-untyped,unused-ignore]

    edges = mdp.offset[:-1].reshape(mdp.n_states, mdp.n_actions)
    ends = mdp.offset[1:].reshape(mdp.n_states, mdp.n_actions)

    def nested(entries: Any) -> list[list[list[Any]]]:
        flat = entries.tolist()
        return [[flat[a:b] for a, b in zip(*row, strict=True)] for row in zip(edges, ends, strict=True)]

    times, value = [], None
    for parallel in (True, False):
        problem = model()
        problem.mdp(
            discount=mdp.discount,
            rewards=np.repeat(_reward(mdp, goal)[:, None], mdp.n_actions, axis=1).tolist(),
            tranMatProbs=nested(mdp.probability),
            tranMatColumns=nested(mdp.successor),
        )
        solve = partial(problem.solve, algorithm="vi", tolerance=ACCURACY * TOP, parallel=parallel)
        times.append(_once(solve))
        value = problem.getValueVector()
    return min(times), value


def by_quantecon(mdp: TabularMDP, goal: int) -> tuple[float, Any]:
    """Seconds and values of one goal by quantecon, which is compiled at its first goal."""
    from quantecon.markov import DiscreteDP  # type: ignore[import-not-found,import-untyped,unused-ignore]
    from scipy.sparse import csr_matrix

    shape = (mdp.n_states * mdp.n_actions, mdp.n_states)
    rows = csr_matrix((mdp.probability, mdp.successor, mdp.offset), shape=shape)
    states = np.repeat(np.arange(mdp.n_states), mdp.n_actions)
    actions = np.tile(np.arange(mdp.n_actions), mdp.n_states)
    problem = DiscreteDP(_reward(mdp, goal)[states], rows, mdp.discount, states, actions)
    answers: list[Any] = []
    took = _once(lambda: answers.append(problem.solve(method="modified_policy_iteration", epsilon=ACCURACY * TOP)))
    return took, answers[0].v


def _once(function: Callable[[], Any]) -> float:
    return seconds(function, repeats=1, warm=False)


def per_goal(
    solve: Callable[[TabularMDP, int], tuple[float, Any]], mdp: TabularMDP, exact: Floats, goals: Ints, count: int = 3
) -> float:
    """Seconds for all goals, from the median of a few."""
    solve(mdp, int(goals[0]))
    times = []
    for k in range(count):
        took, value = solve(mdp, int(goals[k]))
        _check(value, exact[:, k])
        times.append(took)
    return float(np.median(times)) * GOALS


def table_4_1() -> Row:
    """The thesis's example of table 4.1, 75 pairs in a world of 20 × 20: planning and 100 sweeps of one chain."""
    world = grid(20)
    reward = -np.abs(world.cells - (4, 14)).sum(axis=1) / 10.0
    plan = value_iteration(world.mdp, reward)
    ahead = (world.mdp.matrix @ plan.value).reshape(world.n_states, -1)
    demos = simulate(world.mdp, uniform_policy(greedy_actions(ahead, 1e-9)), steps=15, trajectories=5,
                     start=world.state(14, 0))  # fmt: skip

    def whole() -> None:
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sample(planned_actions(demos, visited(demos), world.mdp), sampler=alg4_corrected, chains=1, draws=100,
                   warmup=0, thin=1)  # fmt: skip

    took = seconds(whole)
    return Row("table 4.1, BNIRL: planning and 100 sweeps", f"{took * 1e3:.0f} ms", "< 500 ms", took < 0.5,
               "the thesis (17.4 s)", 17.4 / took)  # fmt: skip
