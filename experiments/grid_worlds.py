"""What figures 4-1 to 4-3 share: worlds of 20 × 20 cells, demonstrators, and how well their subgoals are recovered.

Cells are (x, y) from 1 to 20 with y upwards, as in the thesis; the library counts from 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.answers.predictions import predict_mixture
from subgoal.answers.scores import assignment_loss, identified, top_candidates, zero_one_loss
from subgoal.candidates import Candidates, every_state, visited, visited_and_successors
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.grids.layouts import random_walls
from subgoal.options.tabular import execute, goal_option
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats, Ints
from subgoal.samplers import alg4_corrected

Cell = tuple[int, int]
SIZE, DISCOUNT = 20, 0.99
CONFIDENCE, CONCENTRATION = 10.0, 1.0
SWEEPS = 100
"""Iterations that the thesis shows."""
KEPT_FREE: tuple[Cell, ...] = ((10, 12), (2, 17), (2, 2), (15, 1), (10, 1), (19, 9), (10, 17), (2, 9))
STEPS = 2_000
"""No leg takes longer."""


def world(layout: int) -> GridWorld:
    """Layout 0 has three walls with a gap each; 1, 2, ... are random ones, connected, with the subgoals' cells free."""
    if layout:
        keep = [(x - 1, y - 1) for x, y in KEPT_FREE]
        free = random_walls(SIZE, SIZE, layout, keep_free=keep)
    else:
        free = np.ones((SIZE, SIZE), bool)
        free[4:15, 5] = False  # x = 6, y = 5..15, gap at 10
        free[9, 5] = True
        free[13, 8:17] = False  # y = 14, x = 9..17, gap at 13
        free[13, 12] = True
        free[2:8, 13] = False  # x = 14, y = 3..8
    return GridWorld(free, discount=DISCOUNT, moves=8, stay=True, slip=THESIS_SLIP)


def state(grid: GridWorld, cell: Cell) -> int:
    """Number of a cell counted from one."""
    return int(grid.state(cell[0] - 1, cell[1] - 1))


def cell(grid: GridWorld, number: int) -> Cell:
    """The cell, counted from one, of a state."""
    x, y = grid.cells[number]
    return int(x) + 1, int(y) + 1


@dataclass(frozen=True, eq=False)
class Demonstrated:
    """Pairs, and the state of the subgoal that each truly served (N,)."""

    demonstrations: Demonstrations
    served: Ints


def demonstrate(
    grid: GridWorld, start: Cell, subgoals: Sequence[Cell], *, loops: int = 1, stays: str = "every", seed: int = 0
) -> Demonstrated:
    """Optimal actions towards each subgoal in turn, the next one after arrival; with a stay pair on arrival.

    ``stays`` is "every" subgoal, or "last" for the last of all only.
    """
    here, stay = state(grid, start), grid.action("stay")
    states: list[int] = []
    actions: list[int] = []
    served: list[int] = []
    legs = [state(grid, goal) for goal in subgoals] * loops
    for k, goal in enumerate(legs):
        if here != goal:
            leg = execute(goal_option(grid.mdp, goal), grid.mdp, start=here, steps=STEPS, seed=seed * 1_000 + k)
            states += leg.states.tolist()
            actions += leg.actions.tolist()
        if stays == "every" or k == len(legs) - 1:
            states.append(goal)
            actions.append(stay)
        served += [goal] * (len(states) - len(served))
        here = goal
    made = Demonstrations(
        np.array(states), np.array(actions), np.array([0, len(states)]), final_states=np.array([here]),
        names=("x", "y"), coordinates=grid.mdp.coordinates, time_unit="step",
    )  # fmt: skip
    return Demonstrated(made, np.array(served))


CANDIDATES: dict[str, Callable[[Demonstrations, GridWorld], Candidates]] = {
    "visited": lambda demos, grid: visited(demos),
    "visited and successors": lambda demos, grid: visited_and_successors(demos, grid.mdp),
    "all states": lambda demos, grid: every_state(grid.mdp),
}


def table(demos: Demonstrations, grid: GridWorld, candidates: Candidates) -> LogLikelihood:
    """The likelihood (4.2) with the confidence of these experiments."""
    return planned_actions(demos, candidates, grid.mdp, confidence=CONFIDENCE)


def posterior_of(likelihood: LogLikelihood, seed: int, **settings: Any) -> Posterior:
    """Default sampler; what has not converged says so in its status."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return sample(likelihood, concentration=CONCENTRATION, seed=seed, **settings)


def on_top(posterior: Posterior, goals: Sequence[int]) -> bool:
    """Whether the k candidates of largest expected share are exactly the k true states."""
    sets: Any = posterior.candidates.goal_sets
    found = [sets[g].tolist() for g in top_candidates(posterior, len(set(goals)))]
    return sorted(found) == [[goal] for goal in sorted(set(goals))]


def loss_by_sweep(likelihood: LogLikelihood, seed: int, sampler: Sampler = alg4_corrected) -> Floats:
    """(SWEEPS,) 0-1 policy loss of one chain from its first sweep on, as in the thesis's figures."""
    chain = posterior_of(likelihood, seed, sampler=sampler, chains=1, warmup=0, thin=1, draws=SWEEPS)
    draws: Any = chain.assignments
    return np.array([assignment_loss(likelihood, theta) for theta in draws[0]])


def sweeps_to_minimum(losses: Floats) -> int:
    """First sweep at which the mean loss over runs (R, T) is within a standard error of where it ends.

    Where it ends is the mean over the second half of the sweeps; the error is that of the mean over the runs.
    """
    mean = losses.mean(axis=0)
    half = losses.shape[1] // 2
    error = losses.std(axis=0, ddof=1)[half:].mean() / np.sqrt(len(losses)) if len(losses) > 1 else 0.5
    return int(np.argmax(mean <= mean[half:].mean() + error)) + 1


def share_of_labels_right(likelihood: LogLikelihood, posterior: Posterior, served: Ints) -> float:
    """Share of the pairs that can be told apart whose most probable subgoal is the true one."""
    sets: Any = posterior.candidates.goal_sets
    index = {int(members[0]): g for g, members in enumerate(sets)}
    true = np.array([index[int(s)] for s in served])
    likely = np.asarray(posterior.shares.argmax(axis=1)).ravel()
    told = identified(likelihood, true, likely)
    return float((true == likely)[told].mean())


def held_out_loss(posterior: Posterior, fresh: Demonstrations) -> float:
    """Mean 0-1 loss of the posterior predictive on pairs that were not learned from."""
    return zero_one_loss(predict_mixture(posterior, fresh.states), fresh.actions)
