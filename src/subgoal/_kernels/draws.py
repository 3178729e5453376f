"""The one primitive through which every sampler move draws."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def choose(cumulative, count, generator):
    """Index k < count with probability proportional to cumulative[k] − cumulative[k−1]; never one of weight zero."""
    target = generator.random() * cumulative[count - 1]
    low, high = 0, count - 1
    while low < high:
        middle = (low + high) // 2
        if cumulative[middle] > target:
            high = middle
        else:
            low = middle + 1
    while low > 0 and not cumulative[low] > cumulative[low - 1]:
        low -= 1
    return low
