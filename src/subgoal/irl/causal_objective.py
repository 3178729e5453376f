"""Objectives of maximum causal entropy: how likely a soft planner is to act as shown, and how its visits match."""

from __future__ import annotations

import numpy as np

from subgoal.irl.single_reward import Shown, observed
from subgoal.mdp.planners.flow import Flow
from subgoal.mdp.planners.soft import SoftPlan, soft_value_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats


class CausalObjective:
    """J(w) = f·R + h·V − l2 |w|²/2, with R = Φw and V the soft value of R at temperature 1.

    As dV/dR = (I − γP_π)⁻¹, the gradient is Φᵀ(f + (I − γP_πᵀ)⁻¹ h) − l2 w: one transposed solve, whatever F is.

    Attributes
    ----------
    on_reward, on_value:
        (S,) f and h.
    size:
        Observations that J is a sum over, which is what gradients are held against.
    plan:
        The soft plan of the last weights, from which the next one starts.
    """

    def __init__(self, mdp: TabularMDP, features: Floats, on_reward: Floats, on_value: Floats, l2: float) -> None:
        self.mdp, self.features, self.l2 = mdp, features, l2
        self.on_reward, self.on_value = on_reward, on_value
        self.size = float(on_reward.sum())
        self.plan: SoftPlan | None = None

    @classmethod
    def likelihood(cls, pairs: Shown, mdp: TabularMDP, features: Floats, l2: float) -> CausalObjective:
        """Σ_i log π(a_i | s_i), each term being R(s) + γ Σ P(s' | s, a) V(s') − V(s) (Ziebart 2010)."""
        counts = observed((mdp.n_states, mdp.n_actions), pairs)
        here = counts.sum(axis=1)
        ahead = mdp.discount * (mdp.matrix.T @ counts.ravel())
        return cls(mdp, features, here, ahead - here, l2)

    @classmethod
    def feature_matching(cls, pairs: Shown, mdp: TabularMDP, features: Floats, l2: float) -> CausalObjective:
        """w·μ_E − Σ V(s_0) over the trajectories; its gradient is μ_E − μ_π, both discounted by γ^t.

        μ_E counts γ^t φ(s_t) over what was shown and, from the L-th step on, what the model does next: the term
        γ^L Σ P(s' | s, a) V(s') of the last pair. Without it, μ_E would lack what the demonstrator went on to do.
        """
        length = np.diff(pairs.offset)
        time = np.arange(pairs.states.size) - np.repeat(pairs.offset[:-1], length)
        shown = np.zeros(mdp.n_states)
        np.add.at(shown, pairs.states, mdp.discount ** time.astype(float))
        last = pairs.offset[1:] - 1
        rows = pairs.states[last] * mdp.n_actions + pairs.actions[last]
        cut = np.bincount(rows, mdp.discount ** length.astype(float), minlength=mdp.available.size)
        begun = np.bincount(pairs.starts, minlength=mdp.n_states).astype(float)
        return cls(mdp, features, shown, mdp.matrix.T @ cut - begun, l2)

    def __call__(self, weights: Floats) -> tuple[float, Floats]:
        """J and its gradient (F,); the plan is made as exact as rounding allows."""
        reward = self.features @ weights
        initial = None if self.plan is None else self.plan.value
        self.plan = plan = soft_value_iteration(
            self.mdp, reward, tolerance=0.0, initial=initial, allow_unconverged=True
        )
        flow = Flow(self.mdp, plan.policy).forwards(self.on_value)
        value = float(self.on_reward @ reward + self.on_value @ plan.value) - self.l2 * float(weights @ weights) / 2
        return value, self.features.T @ (self.on_reward + flow) - self.l2 * weights
