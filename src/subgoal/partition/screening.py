"""Candidates that provably have weight zero in every maximum-likelihood mixture."""

from __future__ import annotations

import numpy as np

from subgoal.runtime.checks import Bools, Floats

ROUNDING = 1e-9
"""A bound must be below N by this share before it is believed."""


def proved_idle(gradient: Floats, squares: Floats, largest: Floats, n: int, gap: float) -> Bools:
    """(G,) True where no optimum of f(w) = Σ_i log(Lw)_i gives the candidate any weight.

    Let w be feasible with f(w*) − f(w) ≤ δ for every optimum w*, r = Lw, r* = Lw*, A_ig = L_ig / r_i and v = r/r*.

    * v > 0, and Σ_i v_i = Σ_g w_g D*_g ≤ N, since D*_g = Σ_i L_ig / r*_i ≤ N at an optimum, with D*_g = N wherever
      w*_g > 0. And Σ_i log v_i = f(w) − f(w*) ≥ −δ. Hence with h(v) = v − 1 − log v ≥ 0 and σ = N − Σ v_i ≥ 0,
      Σ_i h(v_i) ≤ δ − σ ≤ δ.
    * D*_g = Σ_i A_ig v_i. For every λ ≥ 0, with B_i = A_ig − λ, that is λ(N − σ) + Σ B_i v_i
      ≤ D_g + Σ_i B_i (v_i − 1).
    * sup_t (st − h(1 + t)) = −s − log(1 − s) for s < 1, at most s²/2 for s ≤ 0 and s²/(2(1 − s)) for 0 ≤ s < 1. With
      b ≥ max(0, max_i B_i), for every μ > b: Σ B_i (v_i − 1) ≤ μδ + Σ_i B_i² / (2(μ − b)). The best μ gives
      bδ + √(2δ Σ_i B_i²).
    * Σ B_i² is least at λ = D_g/N, where it is V_g = Σ_i A_ig² − D_g²/N.

    So D_g + √(2δ V_g) + δ·max(0, max_i A_ig − D_g/N) < N proves D*_g < N, and therefore w*_g = 0.

    Parameters
    ----------
    gradient, squares, largest:
        (G,) D_g, Σ_i A_ig² and max_i A_ig at w.
    n:
        N.
    gap:
        δ in nats, certified.
    """
    mean = gradient / n
    spread = np.maximum(squares - gradient * mean, 0.0)
    bound = gradient + np.sqrt(2 * gap * spread) + gap * np.maximum(largest - mean, 0.0)
    return np.asarray(bound < n * (1 - ROUNDING))
