"""Forward filters of many draws of a law at once, over a block of observations. Arrays named as written are state.

``relative`` (B, G) is L_ig / Σ_g p_g L_ig, ``first`` (B,) marks the first rows of trajectories, and ``entering``
(S, G) is the law of the row before the block under each of S draws. Each writes ``out`` (S, B, G), p(θ_i | actions up
to i), and ``log_total`` (S, B), log p(a_i | before), relative to the same as the rows.
"""

from __future__ import annotations

from math import log

from numba import njit

from subgoal._kernels.persistence import filter_rows, total_of
from subgoal._kernels.sticky_hmm import FLOOR


@njit(cache=True, nogil=True)
def filter_persistent(
    relative, first, there_from, there, weights, keep, keep_there, entering, out, log_total
):  # fmt: skip
    """Subgoals that persist: ``weights`` (S, G), ``keep`` and ``keep_there`` (S,); see ``persistence.filter_rows``."""
    for s in range(weights.shape[0]):
        filter_rows(
            0, relative, first, there_from, there, weights[s], keep[s], keep_there[s], entering[s], out[s],
            log_total[s],
        )  # fmt: skip


@njit(cache=True, nogil=True)
def filter_transitions(relative, first, begin, row_from, column, above, entering, out, log_total):
    """A law of the next subgoal after each: ``begin`` (S, G) that of first steps.

    What row j of draw s has above ``FLOOR`` is ``above[row_from[s, j]:row_from[s, j + 1]]``, in those of ``column``.
    """
    g_count = begin.shape[1]
    for s in range(begin.shape[0]):
        for r in range(relative.shape[0]):
            law = out[s, r]
            if first[r]:
                law[:] = begin[s]
            else:
                before = entering[s] if r == 0 else out[s, r - 1]
                law[:] = FLOOR
                for j in range(g_count):
                    if before[j] > 0.0:
                        for e in range(row_from[s, j], row_from[s, j + 1]):
                            law[column[e]] += before[j] * above[e]
            for g in range(g_count):
                law[g] *= relative[r, g]
            total = total_of(law)
            log_total[s, r] = log(total)
            for g in range(g_count):
                law[g] /= total


@njit(cache=True, nogil=True)
def add_weighted(filtered, weight, probability):
    """Add to ``probability`` (B, P) the first P columns of ``filtered`` (S, B, G), each draw by ``weight`` (S, B)."""
    for s in range(filtered.shape[0]):
        for r in range(filtered.shape[1]):
            for g in range(probability.shape[1]):
                probability[r, g] += weight[s, r] * filtered[s, r, g]
