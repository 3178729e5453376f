"""Maximum margin planning: a reward by which the demonstrator beats every other policy by as much as it differs."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.expectations import Demonstrator, Tail, optimal_policy
from subgoal.irl.margin_qp import margin_qp
from subgoal.irl.single_reward import SingleReward
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, frozen, positive, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

REFERENCE = "Ratliff, Bagnell and Zinkevich, Maximum margin planning, ICML 2006"


def max_margin_planning(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    variant: Literal["cutting_plane", "subgradient"] = "cutting_plane",
    regulariser: float = 0.1,
    step: float | None = None,
    tail: Tail = "held",
    gap: float = 1e-4,
    most_iterations: int = 500,
    progress: Progress | None = None,
) -> SingleReward:
    """Minimise f(w) = ½λ‖w‖² + max_π [w·μ_π + ℓ·ρ_π] − w·μ_E, to a certified ``gap``.

    ρ are discounted visits per step, (1 − γ) E Σ_t γ^t 1[s_t = s] from the states that the demonstrations start in, and
    μ = Φᵀρ with features scaled to a range of one; R = Φw is R(s) now. The loss ℓ(s) is 1 in states that no
    demonstration visits and 0 elsewhere (thesis 4.7.2): with demonstrations that visit every state there is nothing to
    lose, the least f is that of w = 0, and a note says so. One optimal policy for R + ℓ, which is the maximum, gives a
    subgradient and a bound from below that holds for all w. All demonstrations are in one world, where one policy is
    the best against each: their slacks add up to that of their mean.

    Parameters
    ----------
    demonstrations, features, tail:
        As in ``apprenticeship``.
    variant:
        "cutting_plane": w minimises the largest of all bounds so far, by a quadratic program (needs the extra
        ``margin``); this gets as close as is asked for. "subgradient": w ← w − r/√t (λw − μ_E + μ_π), as in the thesis;
        of all w, the one of least f is returned.
    regulariser:
        λ.
    step:
        r, of the subgradient variant only; at most 1/λ. Not given: 0.3/λ.
    gap:
        How far f may be above the least there is. For "subgradient" the bound is the dual of its own steps: a mixture
        of all policies so far with weights r_t Π_{k>t} (1 − λ r_k).
    most_iterations:
        Policies to solve for at most; the outcome says if they did not suffice.
    progress:
        Told the iterations and the gap.

    Returns
    -------
    The optimal policy for R = Φw, without ℓ; ``weights`` of the features as given, R up to a constant; ``trace`` (T, S)
    R at each iteration.

    Raises
    ------
    InputError
        What ``shown`` refuses; unordered pairs; NaN in the features; discount 1; a step above 1/λ.
    MissingExtraError
        Clarabel is not installed, for "cutting_plane".
    """
    if variant not in ("cutting_plane", "subgradient"):
        raise InputError("variant", found=repr(variant), wanted="'cutting_plane' or 'subgradient'")
    wanted, most = positive("gap", gap), whole("most_iterations", most_iterations)
    strength = positive("regulariser", regulariser)
    first = positive("step", 0.3 / strength if step is None else step)
    if variant == "subgradient" and first * strength > 1:
        raise InputError("step", found=first, wanted=f"at most 1/regulariser, {1 / strength:g}")
    rule = _CuttingPlanes(strength) if variant == "cutting_plane" else _Subgradients(strength, first)
    search = _Search(Demonstrator.of(demonstrations, mdp, features, tail), strength, rule)
    with Interrupt() as interrupt, progress or Silent() as display:
        outcome = search.run(wanted, most, interrupt, display)
    return search.answer(outcome)


class _CuttingPlanes:
    """All policies so far, d_j = μ_E − μ_j and ℓ_j = ℓ·ρ_j: f(w) ≥ ½λ‖w‖² + max_j (ℓ_j − w·d_j)."""

    name, monotone = "cutting planes", True

    def __init__(self, strength: float) -> None:
        self.strength = strength
        self.differences: list[Floats] = []
        self.losses: list[float] = []

    def step(self, weights: Floats, difference: Floats, loss: float) -> tuple[Floats, float]:
        """Another policy; the w (F,) of the least bound, and that bound."""
        self.differences.append(difference)
        self.losses.append(loss)
        found = margin_qp(np.stack(self.differences), self.losses, regulariser=self.strength)
        return found.weights, found.dual_objective


class _Subgradients:
    """Steps of length r/√t. From w = 0 they keep w = Σ_j c_j d_j with c_j ≥ 0, so that c/Σc is feasible in the dual."""

    name, monotone = "subgradients", False

    def __init__(self, strength: float, first: float) -> None:
        self.strength, self.first = strength, first
        self.count, self.mass, self.loss = 0, 0.0, 0.0

    def step(self, weights: Floats, difference: Floats, loss: float) -> tuple[Floats, float]:
        """The next w (F,), and the bound Σ_j α_j ℓ_j − ‖Σ_j α_j d_j‖²/(2λ) of α = c/Σc."""
        self.count += 1
        rate = self.first / np.sqrt(self.count)
        kept = 1 - rate * self.strength
        self.mass, self.loss = kept * self.mass + rate, kept * self.loss + rate * loss
        after = kept * weights + rate * difference
        mixed = after / self.mass
        return after, self.loss / self.mass - float(mixed @ mixed) / (2 * self.strength)


class _Search:
    """The weights, those of the least objective f so far, and a bound from below."""

    def __init__(self, demonstrator: Demonstrator, strength: float, rule: _CuttingPlanes | _Subgradients) -> None:
        self.demonstrator, self.strength, self.rule = demonstrator, strength, rule
        self.loss = np.ones(demonstrator.mdp.n_states)
        self.loss[np.concatenate([demonstrator.pairs.states, demonstrator.pairs.final])] = 0.0
        self.weights = self.best = np.zeros(demonstrator.features.shape[1])
        self.objective, self.bound = np.inf, -np.inf
        self.trace: list[Floats] = []

    @property
    def gap(self) -> float:
        """How far f may be above its least; not below zero, where rounding would put it."""
        return max(0.0, self.objective - self.bound)

    def run(self, gap: float, most: int, interrupt: Interrupt, display: Progress) -> Outcome:
        """Iterations until f is within ``gap`` of the bound."""
        for done in range(1, most + 1):
            before = (self.objective, self.bound)
            self._iterate()
            display.update(done, most, f"gap {self.gap:.1e}")
            if self.gap <= gap:
                return Outcome.CONVERGED
            if interrupt.requested:
                return Outcome.INTERRUPTED
            if self.rule.monotone and before == (self.objective, self.bound):
                return Outcome.STALLED
        return Outcome.OUT_OF_ITERATIONS

    def _iterate(self) -> None:
        """The policy that is best against the demonstrator at w; f(w); the next w."""
        made, w = self.demonstrator, self.weights
        reward = made.reward(w)
        self.trace.append(reward)
        visits = made.policy_visits(optimal_policy(made.mdp, reward + self.loss))
        difference, loss = made.difference(visits), float(visits @ self.loss)
        value = self.strength / 2 * float(w @ w) + loss - float(w @ difference)
        if value < self.objective:
            self.objective, self.best = value, w
        self.weights, bound = self.rule.step(w, difference, loss)
        self.bound = max(self.bound, bound)

    def answer(self, outcome: Outcome) -> SingleReward:
        """The frozen record."""
        made = self.demonstrator
        reward = made.reward(self.best)
        reached = f"the objective is {self.objective:.6g}, at most {self.gap:.1e} above the least there is"
        blind = () if self.loss.any() else ("every state was visited: there is no loss, and w = 0 is best",)
        return SingleReward(
            method=f"maximum margin planning, {self.rule.name}", reference=REFERENCE,
            policy=frozen(optimal_policy(made.mdp, reward)), reward=frozen(reward), weights=made.given(self.best),
            outcome=outcome, iterations=len(self.trace), solutions=len(self.trace) + 1,
            trace=frozen(np.stack(self.trace)), undetermined=made.undetermined, notes=(*made.notes, *blind, reached),
        )  # fmt: skip
