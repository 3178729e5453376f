"""The primitive through which every sampler move, and every step of a walk, draws; and its form for a known total."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def at_target(weights, count, target):
    """First index at which the running sum is above ``target``, passing over weights of zero."""
    last = 0
    for k in range(count):
        if weights[k] > 0.0:
            target -= weights[k]
            last = k
            if target < 0.0:
                break
    return last


@njit(cache=True, nogil=True)
def choose(weights, count, generator):
    """Index k < count with probability proportional to weights[k]; never one of weight zero.

    The sum runs in four strands and the search from the front, so that large weights should stand there.
    """
    a = b = c = d = 0.0
    whole = count - count % 4
    for k in range(0, whole, 4):
        a += weights[k]
        b += weights[k + 1]
        c += weights[k + 2]
        d += weights[k + 3]
    for k in range(whole, count):
        a += weights[k]
    return at_target(weights, count, generator.random() * ((a + b) + (c + d)))


@njit(cache=True, nogil=True)
def choose_of(weights, count, total, generator):
    """The same for weights that sum to ``total`` (to rounding), which whoever wrote them has added up."""
    return at_target(weights, count, generator.random() * total)
