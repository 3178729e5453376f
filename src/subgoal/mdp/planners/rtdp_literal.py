"""Real-time dynamic programming as the thesis prints it (5.1.1): a lower bound, without knowing how low.

States outside the envelope are worth nothing, so that greedy behaviour has no reason to leave it but for slips, and a
shorter way outside may never be seen. Here for comparison and for figure 5-1; ``rtdp_subgoals`` is what to use.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from subgoal._kernels import first_passage as loops
from subgoal.mdp.local_world import local_world
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.rtdp import MOST_STATES
from subgoal.runtime.checks import Floats, Ints, frozen, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

CHANGE = 1e-10
"""Largest change of a last sweep."""
MOST_SWEEPS = 10_000
HORIZON = 10
"""A simulation is given up after so many times 1/(1 − γ) steps."""


@dataclass(frozen=True, eq=False)
class Stage:
    """An envelope as it was: (S,) states and (S,) values of the goal, lower bounds of E[γ^T]."""

    states: Ints
    value: Floats


@dataclass(frozen=True, eq=False)
class LiteralRun:
    """What came of it.

    Attributes
    ----------
    action_values:
        (U, A) of E[γ^T] at the states asked for, −inf for illegal actions: multiply by V*(g), 1/(1 − γ) where the goal
        can be held, for the values of (4.1).
    stages:
        One for each time that value iteration was run.
    simulations:
        How many greedy simulations there were.
    ended:
        Whether the rule of stopping was met, and not the largest number of states.
    """

    action_values: Floats
    stages: tuple[Stage, ...]
    simulations: int
    ended: bool


def rtdp_literal(
    world: Any,
    goal: int,
    *,
    states: Any,
    stop: Literal["one", "all"] = "one",
    most_states: int = MOST_STATES,
    seed: int = 0,
) -> LiteralRun:
    """The envelope of one goal around demonstrated ``states`` (U,), grown by greedy simulations.

    It begins with the states and all that one action may lead to. After value iteration on it, with nothing outside, a
    greedy simulation is run from a demonstrated state drawn at random; the states met, and what one action may lead to
    from them, are added. ``stop`` "one" is the thesis's rule, to end when a simulation adds nothing; "all" ends when a
    simulation from each demonstrated state in turn has added nothing. Equally good actions are drawn at random.

    Raises ``InputError`` for states that do not exist and an unknown ``stop``.
    """
    seen = local_world(world)
    kept = np.unique(np.atleast_1d(seen.check("states", states)))
    target = int(seen.check("goal", goal))
    if stop not in ("one", "all"):
        raise InputError("stop", found=repr(stop), wanted="'one' or 'all'")
    growing = _Growing(Envelope(seen), kept, target, stream(seed))
    most, quiet, enough = whole("most_states", most_states), 0, 1 if stop == "one" else kept.size
    growing.plan()
    while quiet < enough and growing.envelope.n_inside < most:
        begin = kept[quiet] if stop == "all" else growing.generator.choice(kept)
        if growing.simulate(int(begin)):
            growing.plan()
            quiet = 0
        else:
            quiet += 1
    return growing.answer(quiet >= enough)


class _Growing:
    """The envelope, its values, and the stages so far."""

    def __init__(self, envelope: Envelope, states: Ints, goal: int, generator: np.random.Generator) -> None:
        self.envelope, self.states, self.generator = envelope, states, generator
        self.goal = int(envelope.meet(np.array([goal]))[0])
        self._add(envelope.meet(states))
        self.stages: list[Stage] = []
        self.value = np.zeros(0)
        self.simulations = 0

    def plan(self) -> None:
        """Value iteration on the envelope, as a first passage to the goal."""
        envelope = self.envelope
        table = envelope.table()
        value = np.zeros((envelope.n_met, 1))
        value[: self.value.size, 0] = self.value
        value[self.goal] = 1.0
        mark = np.full(envelope.n_met, -1)
        mark[self.goal] = 0
        order = envelope.order(table, np.array([self.goal]))
        loops.settle(order, CHANGE, False, MOST_SWEEPS, *table, mark, np.ones((1, 1), bool), True, value)
        self.value = value[:, 0]
        inside = envelope.inside
        self.stages.append(Stage(frozen(envelope.states[inside]), frozen(self.value[inside])))

    def simulate(self, begin: int) -> bool:
        """Behave greedily from ``begin`` until the goal, the edge or the horizon; whether that added any state."""
        envelope, discount = self.envelope, self.envelope.world.discount
        self.simulations += 1
        at, met = int(envelope.places(np.array([begin]))[0]), []
        for _ in range(int(HORIZON / (1 - min(discount, 1 - 1e-6)))):
            met.append(at)
            if at == self.goal or not envelope.inside[at]:
                break
            rows = envelope.action_rows(envelope.states[[at]].copy())
            worth = self._worth(rows)[0]
            best = np.flatnonzero(worth >= worth.max() - 1e-12 * abs(worth.max()))
            if not np.isfinite(worth.max()):
                break
            entries = slice(*rows.offset[(chosen := int(self.generator.choice(best))) : chosen + 2])
            chances = rows.probability[entries]
            at = int(self.generator.choice(rows.successor[entries], p=chances / chances.sum()))
        return self._add(np.unique(met))

    def answer(self, ended: bool) -> LiteralRun:
        """The frozen record."""
        rows = self._worth(self.envelope.action_rows(self.states))
        return LiteralRun(frozen(rows), tuple(self.stages), self.simulations, ended)

    def _add(self, places: Ints) -> bool:
        """Take in states and all that one action may lead to from them; whether there were any new ones."""
        envelope, before = self.envelope, self.envelope.n_inside
        envelope.expand(places[~envelope.inside[places]])
        around = np.unique(envelope.action_rows(envelope.states[places].copy()).successor)
        envelope.expand(around[~envelope.inside[around]])
        return envelope.n_inside > before

    def _worth(self, rows: Any) -> Floats:
        """(M, A) γ Σ P(s' | s, a) h(s'), −inf for illegal actions."""
        each = np.concatenate([[0.0], np.cumsum(rows.probability * self.value[rows.successor])])
        ahead = self.envelope.world.discount * np.diff(each[rows.offset])
        ahead[np.diff(rows.offset) == 0] = -np.inf
        return np.asarray(ahead.reshape(-1, self.envelope.world.n_actions))
