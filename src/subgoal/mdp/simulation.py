"""Demonstrations out of a world: a policy, acted out."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal._kernels.draws import choose
from subgoal._kernels.walks import walk
from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.mdp.planners.policy import check_policy
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.runtime.checks import Floats, Ints, real_array, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

ROOM = 4096
"""Steps that are written at a time; what a walk draws does not depend on it."""


def simulate(
    mdp: TabularMDP, policy: Any, *, steps: int, trajectories: int = 1, start: Any = None, seed: int = 0
) -> Demonstrations:
    """Act out ``policy`` and record what was seen: N pairs of state and action, in ``trajectories`` trajectories.

    Parameters
    ----------
    policy:
        (S,) the action of each state, or (S, A) probabilities; nothing is asked of terminal states.
    steps:
        The most actions of a trajectory. It ends earlier on entering a terminal state; otherwise it is ``truncated``.
    start:
        A state for all, (trajectories,) a state for each, (S,) floats that are probabilities; not given: ``mdp.start``.
    seed:
        Trajectory k hangs on the seed and on k alone, never on how many trajectories there are.

    Raises
    ------
    InputError
        A policy that takes an action that is not available, a start in a terminal state: each naming the state.
    """
    check_world(mdp)
    steps, trajectories = whole("steps", steps), whole("trajectories", trajectories)
    table = check_policy(mdp, policy)
    first, chances = _starts(mdp, start, trajectories)
    walks = []
    for k in range(trajectories):
        generator = stream(seed, k)
        begin = int(choose(chances, chances.size, generator)) if chances.size else int(first[k])
        walks.append(_walked(mdp, table, begin, steps, generator))
    final = np.array([end for _, _, end in walks])
    return Demonstrations(
        states=np.concatenate([states for states, _, _ in walks]),
        actions=np.concatenate([actions for _, actions, _ in walks]),
        offset=np.cumsum([0, *(len(states) for states, _, _ in walks)]),
        final_states=final, truncated=~mdp.terminal[final], coordinates=mdp.coordinates,
        time_unit="step", source=Source("simulation"),
    )  # fmt: skip


def _walked(mdp: TabularMDP, table: Any, state: int, steps: int, generator: Any) -> tuple[Ints, Ints, int]:
    drawing = table.ndim == 2
    fixed, chances = (np.zeros(mdp.n_states, np.int64), table.ravel()) if drawing else (table, np.zeros(0))
    seen: list[Ints] = []
    acted: list[Ints] = []
    while steps and not mdp.terminal[state]:
        room = min(steps, ROOM)
        states, actions = np.empty(room, np.int64), np.empty(room, np.int64)
        count, state = walk(
            state, fixed, chances, mdp.n_actions, mdp.offset, mdp.successor, mdp.probability, mdp.terminal,
            generator, states, actions,
        )  # fmt: skip
        seen.append(states[:count])
        acted.append(actions[:count])
        steps -= count
    return np.concatenate(seen), np.concatenate(acted), int(state)


def _starts(mdp: TabularMDP, start: Any, trajectories: int) -> tuple[Ints, Floats]:
    """(trajectories,) the first states, or else (S,) their probabilities; the other of the two is empty."""
    start = mdp.start if start is None else start
    if start is None:
        raise InputError(
            "start", found="None, and the world has none either", wanted="a state, states or probabilities"
        )
    if np.asarray(start).dtype.kind == "f":
        return np.zeros(0, np.int64), _probabilities(mdp, start)
    states = check_states("start", start, mdp.n_states)
    if states.shape not in ((), (trajectories,)):
        raise InputError("start", found=f"shape {states.shape}", wanted=f"one state or {trajectories}")
    first = np.broadcast_to(states, trajectories)
    _check_alive(mdp, first)
    return first, np.zeros(0)


def _probabilities(mdp: TabularMDP, start: Any) -> Floats:
    chances = real_array("start", start, ndim=1)
    if chances.shape != (mdp.n_states,) or not ((chances >= 0).all() and abs(chances.sum() - 1) <= 1e-8):
        found = f"{chances.size} numbers that sum to {chances.sum():.12g}"
        raise InputError("start", found=found, wanted=f"{mdp.n_states} probabilities that sum to 1")
    _check_alive(mdp, np.flatnonzero(chances))
    return chances


def _check_alive(mdp: TabularMDP, states: Ints) -> None:
    over = mdp.terminal[states]
    if over.any():
        found = f"terminal state {states[np.argmax(over)]}"
        raise InputError("start", found=found, wanted="states in which an action can be taken")
