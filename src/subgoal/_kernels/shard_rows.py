"""Loops over sharded observations: every θ_i given the weights of each chain, of which only the counts are kept.

A tile (B, G) holds each observation's likelihood in shares of its largest: the share itself, or its logarithm, below
zero, where it is too small to be a normal number of the tile's type. Nothing is lost, and a sum needs no exponential.
Arrays named in the docstrings are written.
"""

from __future__ import annotations

from math import exp, log, sqrt

import numpy as np
from numba import njit

CHUNK = 32
"""Candidates whose sum is kept, so that a search skips them together."""
TILE = 2**13
"""Entries of a tile that stay in the cache while all chains draw from it."""
SMALL = 1e-30
REACH = 0.125
"""Where the series of exp(−a) up to a^10 is right to the last digit; larger a are halved until they are there."""
LEAST_EXPONENT = -700.0
"""exp of less is no longer a normal number."""
C2, C3, C4, C5, C6 = 1 / 2, -1 / 6, 1 / 24, -1 / 120, 1 / 720
C7, C8, C9, C10 = -1 / 5040, 1 / 40320, -1 / 362880, 1 / 3628800


@njit(cache=True, nogil=True)
def encode(tile, lowest, shares, peaks):
    """Write ``shares`` (B, G) as above, of log densities ``tile`` (B, G), and their largest, ``peaks`` (B,).

    Differences below ``lowest`` are held as logarithms. A row without a finite largest value has peak −inf or NaN.
    """
    for r in range(tile.shape[0]):
        peak = -np.inf
        for g in range(tile.shape[1]):
            peak = tile[r, g] if np.isnan(tile[r, g]) else max(peak, tile[r, g])
            if np.isnan(peak):
                break
        peaks[r] = peak
        for g in range(tile.shape[1]):
            below = tile[r, g] - peak
            shares[r, g] = exp(below) if below >= lowest else below


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def draw_rows(tile, log_weights, weights, uniforms, least, partial, work, counts, fits, left):
    """Draw θ_i ∝ w_g L_ig for the rows of ``tile`` (B, G) and each of C chains, by one uniform number for each.

    ``log_weights`` and ``weights`` (C, G), ``uniforms`` (C, B); adds to ``counts`` (C, G) and to ``fits`` (C,), sums
    of log shares. Sums below ``least`` (C,) may have lost terms: such a row is drawn from sums of logs; or, where
    ``left`` (C, B) is not empty, marked there and left to somebody else. ``partial`` (G,) and ``work`` (G,) are room.
    A row that no weight allows makes the fit NaN.
    """
    b_count, g_count = tile.shape
    chunks = (g_count + CHUNK - 1) // CHUNK
    step = max(1, TILE // g_count)
    for start in range(0, b_count, step):
        stop = min(b_count, start + step)
        for c in range(weights.shape[0]):
            product = 1.0
            total = 0.0
            for r in range(start, stop):
                mass = 0.0
                for k in range(chunks):
                    part = 0.0
                    for g in range(k * CHUNK, min(g_count, k * CHUNK + CHUNK)):
                        share = tile[r, g]
                        part += weights[c, g] * (share if share > 0 else 0)
                    partial[k] = part
                    mass += part
                found = -1
                if mass > least[c]:
                    target = uniforms[c, r] * mass
                    k = 0
                    while k < chunks - 1 and target >= partial[k]:
                        target -= partial[k]
                        k += 1
                    for g in range(k * CHUNK, min(g_count, k * CHUNK + CHUNK)):
                        share = tile[r, g]
                        target -= weights[c, g] * (share if share > 0 else 0)
                        if target < 0.0:
                            found = g
                            break
                    if found < 0:
                        for g in range(g_count):
                            if weights[c, g] > 0.0 and tile[r, g] > 0:
                                found = g
                elif left.size > 0:
                    left[c, r] = True
                    continue
                else:
                    peak = -np.inf
                    for g in range(g_count):
                        share = float(tile[r, g])
                        work[g] = log_weights[c, g] + (log(share) if share > 0.0 else share)
                        peak = max(peak, work[g])
                    mass = 0.0
                    if peak == -np.inf:
                        total = np.nan
                        continue
                    for g in range(g_count):
                        work[g] = exp(work[g] - peak)
                        mass += work[g]
                    target = uniforms[c, r] * mass
                    for g in range(g_count):
                        target -= work[g]
                        if work[g] > 0.0:
                            found = g
                            if target < 0.0:
                                break
                counts[c, found] += 1
                share = float(tile[r, found])
                if share > SMALL:
                    product *= share
                    if product < SMALL:
                        total += log(product)
                        product = 1.0
                else:
                    total += log(share) if share > 0.0 else share
            fits[c] += total + log(product)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"}, error_model="numpy")
def direction_shares(units, states, goals, near, confidence, uniform, shares):
    """Write ``shares`` (B, G), as above: exp(−α‖u − û_g‖), or ``uniform`` within ``near`` of the candidate.

    ``units`` (B, 2), of length 0 where nothing is said of a goal, ``states`` (B, 2) and ``goals`` (2, G).
    """
    g_count = goals.shape[1]
    halvings = 0
    scale = confidence
    while 2.0 * scale > REACH:
        scale *= 0.5
        halvings += 1
    limit = near * near
    for r in range(units.shape[0]):
        along, across, x, y = units[r, 0], units[r, 1], states[r, 0], states[r, 1]
        if along == 0.0 and across == 0.0:
            for g in range(g_count):
                shares[r, g] = uniform
            continue
        for g in range(g_count):
            dx = goals[0, g] - x
            dy = goals[1, g] - y
            inverse = 1.0 / np.sqrt(dx * dx + dy * dy)
            a, b = along - dx * inverse, across - dy * inverse
            t = scale * sqrt(a * a + b * b)
            tail = C5 + t * (C6 + t * (C7 + t * (C8 + t * (C9 + t * C10))))
            shares[r, g] = 1.0 - t * (1.0 - t * (C2 + t * (C3 + t * (C4 + t * tail))))
        for _ in range(halvings):
            for g in range(g_count):
                shares[r, g] *= shares[r, g]
        for g in range(g_count):
            dx = goals[0, g] - x
            dy = goals[1, g] - y
            shares[r, g] = uniform if dx * dx + dy * dy <= limit else shares[r, g]
        if 2.0 * confidence > -LEAST_EXPONENT:
            for g in range(g_count):
                dx = goals[0, g] - x
                dy = goals[1, g] - y
                if dx * dx + dy * dy > limit:
                    inverse = 1.0 / sqrt(dx * dx + dy * dy)
                    below = -confidence * sqrt((along - dx * inverse) ** 2 + (across - dy * inverse) ** 2)
                    shares[r, g] = exp(below) if below >= LEAST_EXPONENT else below


@njit(cache=True, nogil=True)
def draw_directions(units, states, goals, near, confidence, uniform, log_weights, weights, uniforms, least, partial,
                    work, counts, fits, left):  # fmt: skip
    """``draw_rows`` of ``direction_shares``, a tile at a time, of which nothing is held."""
    step = max(1, TILE // goals.shape[1])
    shares = np.empty((min(step, units.shape[0]), goals.shape[1]))
    for start in range(0, units.shape[0], step):
        stop = min(units.shape[0], start + step)
        tile = shares[: stop - start]
        direction_shares(units[start:stop], states[start:stop], goals, near, confidence, uniform, tile)
        draw_rows(tile, log_weights, weights, uniforms[:, start:stop], least, partial, work, counts, fits,
                  left[:, start:stop])  # fmt: skip
