"""Objective of the original maximum entropy method: the probability of whole trajectories of a given length."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import paths as loops
from subgoal.irl.single_reward import Shown, chances
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import BudgetError

LARGEST_TABLE = 2**32
"""Bytes that the sums of one length may take."""


class TrajectoryObjective:
    """Σ_d log P(ζ_d) − l2 |w|²/2 with P(ζ) = Π P(s_{t+1} | s_t, a_t) exp(Σ_t γ^t R(s_t)) / Z (Ziebart 2008, (4)).

    Z sums over all trajectories from the same first state with the same number of steps, so that neither start nor
    length is modelled. R is paid in all L + 1 states, the last one included. Where that one was not recorded, or the
    last action cannot lead to it, it is summed over.

    Attributes
    ----------
    recorded:
        (D,) whether the last state is known.
    size:
        Pairs shown.
    """

    def __init__(self, pairs: Shown, mdp: TabularMDP, features: Floats, discount: float, l2: float) -> None:
        self.mdp, self.features, self.discount, self.l2 = mdp, features, discount, l2
        self.size = float(pairs.states.size)
        with np.errstate(divide="ignore"):
            self._log_chance = np.log(mdp.probability)
        length = np.diff(pairs.offset)
        _refuse_long(int(length.max()), mdp.n_states)
        last = pairs.offset[1:] - 1
        self.recorded = chances(mdp, pairs.states[last], pairs.actions[last], pairs.final) > 0
        self._shown, self._constant = self._counted(pairs, length)
        rows = pairs.states[last] * mdp.n_actions + pairs.actions[last]
        self._open = list(zip(rows[~self.recorded], length[~self.recorded], strict=True))
        self._starts = [
            (int(n), np.bincount(pairs.starts[length == n], minlength=mdp.n_states).astype(float))
            for n in np.unique(length)
        ]

    def __call__(self, weights: Floats) -> tuple[float, Floats]:
        """The objective and its gradient (F,)."""
        reward = self.features @ weights
        shown = self._shown.copy()
        value = self._constant + float(shown @ reward)
        for row, steps in self._open:
            entries = slice(self.mdp.offset[row], self.mdp.offset[row + 1])
            to, fade = self.mdp.successor[entries], self.discount**steps
            log_weight = self._log_chance[entries] + fade * reward[to]
            peak = log_weight.max()
            total = np.exp(log_weight - peak).sum()
            value += float(peak + np.log(total))
            np.add.at(shown, to, fade * np.exp(log_weight - peak) / total)
        log_total, visits, _ = self.expected(reward)
        value -= log_total + self.l2 * float(weights @ weights) / 2
        return value, self.features.T @ (shown - visits) - self.l2 * weights

    def expected(self, reward: Floats) -> tuple[float, Floats, Floats]:
        """Σ_d log Z, (S,) expected visits that count γ^t, and (S, A) expected pairs, of trajectories like those shown.

        By one sum backwards and one pass forwards in time for each length.
        """
        log_total, visits, pairs = 0.0, np.zeros(self.mdp.n_states), np.zeros(self.mdp.available.shape)
        world = (self.mdp.offset, self.mdp.successor, self._log_chance, self.mdp.n_actions)
        for steps, start in self._starts:
            fade = self.discount ** np.arange(steps + 1.0)
            sums = np.empty((steps + 1, self.mdp.n_states))
            loops.log_sums(*world, reward, fade, sums)
            begun = start > 0
            log_total += float(start[begun] @ sums[0, begun])
            loops.add_visits(*world, reward, fade, sums, start, visits, pairs)
        return log_total, visits, pairs

    def _counted(self, pairs: Shown, length: Ints) -> tuple[Floats, float]:
        """(S,) γ^t over the states shown, known last ones included, and Σ log P of the transitions."""
        time = np.arange(pairs.states.size) - np.repeat(pairs.offset[:-1], length)
        shown = np.zeros(self.mdp.n_states)
        np.add.at(shown, pairs.states, self.discount ** time.astype(float))
        final = pairs.final[self.recorded]
        fade = self.discount ** length[self.recorded].astype(float)
        np.add.at(shown, final, fade)
        after = np.append(pairs.states[1:], -1)
        after[pairs.offset[1:] - 1] = np.where(self.recorded, pairs.final, -1)
        seen = after >= 0
        return shown, float(np.log(chances(self.mdp, pairs.states[seen], pairs.actions[seen], after[seen])).sum())


def _refuse_long(steps: int, states: int) -> None:
    needed = 8.0 * (steps + 1) * states
    if needed > LARGEST_TABLE:
        hint = "shorter trajectories, or subgoal's max_causal_entropy, which needs no table over time"
        raise BudgetError("sums over trajectories", needed=needed, budget=LARGEST_TABLE, hint=hint)
