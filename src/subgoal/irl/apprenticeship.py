"""Apprenticeship learning: policies that collect what the demonstrator collected (Abbeel and Ng 2004)."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.expectations import Demonstrator, Tail, optimal_policy
from subgoal.irl.margin_qp import margin_qp
from subgoal.irl.single_reward import SingleReward
from subgoal.mdp.planners.policy import uniform_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, frozen, positive, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

REFERENCE = "Abbeel and Ng, Apprenticeship learning via inverse reinforcement learning, ICML 2004"
SEEN = 1e-15
"""Share of discounted time below which no policy of a mixture is held to visit a state."""


def apprenticeship(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    features: Any = None,
    *,
    variant: Literal["max_margin", "projection"] = "max_margin",
    policy: Literal["mixture", "greedy"] = "mixture",
    tail: Tail = "held",
    margin: float = 1e-3,
    most_iterations: int = 100,
    progress: Progress | None = None,
) -> SingleReward:
    """Find a mixture of policies whose feature expectations μ are those of the demonstrator, to within ``margin``.

    Starting from the uniform policy: the weights w, ‖w‖ = 1, by which the demonstrator collects most more than every
    policy found so far; the optimal policy for R = Φw; repeat. Reward is R(s) now: μ = (1 − γ) E Σ_t γ^t φ(s_t), from
    the states that the demonstrations start in, with features scaled to a range of one. Where policies are compared in
    finite samples no mixture may come within ``margin``: then the search ends at the nearest there is, to within
    ``margin``, and a note says how near that is.

    Parameters
    ----------
    demonstrations:
        D trajectories of states and actions, of any lengths.
    features:
        (S, F) Φ; None: one for each state.
    variant:
        "max_margin": w by a quadratic program over all policies found (needs the extra ``margin``). "projection": by
        a step to the newest policy only, without a solver and in more iterations.
    policy:
        What is returned. "mixture": the stationary policy with the visits of the mixture, π(a | s) ∝ Σ_j λ_j ρ_j(s)
        π_j(a | s), which is what the method promises something of; where it never comes, the greedy policy. "greedy":
        the optimal policy of the last R, as thesis 4.7 scores it; as the margin closes, w makes the policies of the
        mixture equally good, and being optimal for it says little.
    tail:
        What a demonstration that breaks off before a terminal state is taken to do afterwards: "held" stays in its last
        state, "none" collects nothing, as the paper has it, which is harmless only where γ^length is small: otherwise
        every feature looks shunned, and the answer depends on where features have their zero.
    margin:
        Distance ‖μ_E − μ‖ to stop at.
    most_iterations:
        Policies to solve for at most; the outcome says if they did not suffice.
    progress:
        Told the iterations and the distance.

    Returns
    -------
    ``weights`` of the features as given, of R = Φw up to a constant; ``trace`` (T, S) the rewards of all iterations.

    Raises
    ------
    InputError
        What ``shown`` refuses; unordered pairs; NaN in the features; discount 1.
    MissingExtraError
        Clarabel is not installed, for "max_margin".
    """
    for what, value, allowed in (
        ("variant", variant, ("max_margin", "projection")), ("policy", policy, ("mixture", "greedy")),
    ):  # fmt: skip
        if value not in allowed:
            raise InputError(what, found=repr(value), wanted=" or ".join(map(repr, allowed)))
    wanted, most = positive("margin", margin), whole("most_iterations", most_iterations)
    search = _Search(Demonstrator.of(demonstrations, mdp, features, tail), variant)
    with Interrupt() as interrupt, progress or Silent() as display:
        outcome = search.run(wanted, most, interrupt, display)
    return search.answer(outcome, mixed=policy == "mixture")


class _Search:
    """The policies so far, how each differs from the demonstrator, and the mixture nearest to them."""

    def __init__(self, demonstrator: Demonstrator, variant: str) -> None:
        self.demonstrator, self.variant = demonstrator, variant
        self.policies: list[Floats] = []
        self.visits: list[Floats] = []
        self.differences: list[Floats] = []
        self.shares, self.apart = np.empty(0), np.empty(0)
        self.trace: list[Floats] = []
        self.newest = uniform_policy(demonstrator.mdp.available)
        self.weights, self.nearest = np.empty(0), 0.0

    def run(self, margin: float, most: int, interrupt: Interrupt, display: Progress) -> Outcome:
        """Iterations until the distance, or what could still be taken off it, is at most ``margin``."""
        before = np.inf
        for done in range(1, most + 1):
            self._add(self.newest)
            distance = float(np.linalg.norm(self.apart))
            self.weights = self.apart / distance if distance > 0 else self.apart
            reward = self.demonstrator.reward(self.weights)
            self.trace.append(reward)
            self.newest = optimal_policy(self.demonstrator.mdp, reward)
            best = self.demonstrator.difference(self.demonstrator.policy_visits(self.newest))
            self.nearest = max(0.0, float(best @ self.weights))
            display.update(done, most, f"distance {distance:.1e}")
            if distance - self.nearest <= margin or distance <= margin:
                return Outcome.CONVERGED
            if interrupt.requested:
                return Outcome.INTERRUPTED
            if not distance < before:
                return Outcome.STALLED
            before = distance
        return Outcome.OUT_OF_ITERATIONS

    def _add(self, policy: Floats) -> None:
        """``policy`` joins; the shares (m,) of the mixture and its difference (F,) are found anew."""
        visits = self.demonstrator.policy_visits(policy)
        difference = self.demonstrator.difference(visits)
        self.policies.append(policy)
        self.visits.append(visits)
        self.differences.append(difference)
        if self.variant == "max_margin":
            found = margin_qp(np.stack(self.differences))
            self.shares, self.apart = found.multipliers, found.weights
        elif not self.apart.size:
            self.shares, self.apart = np.ones(1), difference
        else:
            way = self.apart - difference
            square = float(way @ way)
            step = min(max(float(self.apart @ way) / square, 0.0), 1.0) if square > 0 else 0.0
            self.shares, self.apart = np.append((1 - step) * self.shares, step), self.apart - step * way

    def answer(self, outcome: Outcome, *, mixed: bool) -> SingleReward:
        """The frozen record."""
        distance = float(np.linalg.norm(self.apart))
        near = f"the mixture is {distance:.2g} from the demonstrator, in scaled features per step"
        bound = f"{near}, and no mixture gets nearer than {self.nearest:.2g}"
        made = self.demonstrator
        return SingleReward(
            method=f"apprenticeship, {self.variant.replace('_', ' ')}", reference=REFERENCE,
            policy=frozen(self._mixture() if mixed else self.newest), reward=frozen(self.trace[-1]),
            weights=made.given(self.weights), outcome=outcome, iterations=len(self.trace), solutions=len(self.trace),
            trace=frozen(np.stack(self.trace)), undetermined=made.undetermined, notes=(*made.notes, bound),
        )  # fmt: skip

    def _mixture(self) -> Floats:
        """(S, A) the stationary policy with the visits of the mixture; the newest policy where it never comes."""
        shares = self.shares[:, None] * np.stack(self.visits)
        taken = np.einsum("js,jsa->sa", shares, np.stack(self.policies))
        total = shares.sum(axis=0)[:, None]
        seen = (total > SEEN) & self.demonstrator.mdp.available.any(axis=1)[:, None]
        return np.where(seen, taken / np.where(seen, taken.sum(axis=1, keepdims=True), 1.0), self.newest)
