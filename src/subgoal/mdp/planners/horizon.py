"""How far a discount lets a subgoal be felt, and which discount suits a world of a given size.

At d steps from a goal that can be held, Q* of an action that gets a step nearer and of one that gets a step further
away differ by γ^d (1 + γ) for a reward of one, at most: (γ^d − γ^(d + 2)) / (1 − γ). Times α, that is how many nats
the likelihood tells the two apart by.
"""

from __future__ import annotations

from math import exp, log

from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError


def flat_distance(discount: float, confidence: float, *, nats: float = 0.01) -> float:
    """Steps beyond which no two actions differ by more than ``nats`` in the likelihood, so that it is flat.

    The smallest d ≥ 0 with α γ^d (1 + γ) ≤ nats, for the convention "continuing". Raises ``InputError`` for a discount
    outside (0, 1), and for numbers not above zero.
    """
    gamma, alpha, least = _inside(discount), positive("confidence", confidence), positive("nats", nats)
    return max(0.0, log(alpha * (1 + gamma) / least) / -log(gamma))


def discount_for(distance: float, confidence: float, *, nats: float = 1.0) -> float:
    """γ at which actions still differ by ``nats`` in the likelihood at ``distance`` steps from a goal.

    The solution of α γ^d (1 + γ) = nats. Raises ``InputError`` for numbers not above zero, and where α is too small for
    any discount.
    """
    d, alpha, wanted = positive("distance", distance), positive("confidence", confidence), positive("nats", nats)
    if not 2 * alpha > wanted:
        raise InputError("confidence", found=alpha, wanted=f"above nats/2 = {wanted / 2:g}")
    gamma = exp(-log(2 * alpha / wanted) / d)
    for _ in range(100):
        gamma = exp(-log(alpha * (1 + gamma) / wanted) / d)
    return gamma


def _inside(discount: float) -> float:
    gamma = positive("discount", discount)
    if not gamma < 1:
        raise InputError("discount", found=gamma, wanted="below 1")
    return gamma
