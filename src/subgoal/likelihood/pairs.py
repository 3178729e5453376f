"""Pairs of state and action, checked against the world that they are of."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.local_world import local_world
from subgoal.runtime.checks import Ints
from subgoal.runtime.errors import InputError


def check_demonstrations(demonstrations: Any) -> None:
    """Raise ``InputError`` for anything but ``Demonstrations``: these come first, then the world."""
    if not isinstance(demonstrations, Demonstrations):
        found = type(demonstrations).__name__
        raise InputError("demonstrations", found=found, wanted="Demonstrations, then the world")


def checked_pairs(demonstrations: Any, mdp: Any) -> tuple[Ints, Ints]:
    """States and actions, each of the world and legal; raises ``InputError`` naming the observation."""
    check_demonstrations(demonstrations)
    world = local_world(mdp)
    if not demonstrations.is_discrete or np.ndim(demonstrations.actions) != 1:
        hint = "to_cells makes cells of positions"
        raise InputError("demonstrations", found="real numbers", wanted="states and actions (N,) integers", hint=hint)
    states = world.check("demonstrations.states", demonstrations.states)
    actions = np.asarray(demonstrations.actions)
    here, row = np.unique(states, return_inverse=True)
    legal = (np.diff(world.rows(here).offset) > 0).reshape(here.size, world.n_actions)
    for bad, wanted in (
        ((actions < 0) | (actions >= world.n_actions), f"0 to {world.n_actions - 1}"),
        (~legal[row, np.clip(actions, 0, world.n_actions - 1)], "a legal action of state {state}"),
    ):
        if bad.any():
            i = int(np.argmax(bad))
            ended = "" if legal[row[i]].any() else ", where episodes are over"
            raise InputError("demonstrations.actions", where=f"observation {i}", found=int(actions[i]),
                             wanted=wanted.format(state=states[i]) + ended)  # fmt: skip
    return states, actions
