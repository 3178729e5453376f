"""The primitives through which every sampler move, and every step of a walk, draws."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def at_target(weights, count, target):
    """First index at which the running sum is above ``target``; if rounding lets none be, the last of weight > 0."""
    for k in range(count):
        target -= weights[k]
        if target < 0.0:
            return k
    for k in range(count - 1, 0, -1):
        if weights[k] > 0.0:
            return k
    return 0


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


@njit(cache=True, nogil=True)
def choose_listed(first, following, sizes, total, generator):
    """One of the list from ``first`` through ``following`` (−1 ends it) by its size; sizes sum to ``total``."""
    found = first
    target = generator.random() * total - sizes[found]
    while target >= 0.0 and following[found] >= 0:
        found = following[found]
        target -= sizes[found]
    return found


@njit(cache=True, nogil=True)
def opens(waited, restaurant, seated, mass, generator):
    """Whether a customer opens a table of the restaurant: with probability mass / (seated + mass).

    One random number u serves all customers until the next table: none of ``seated`` = n, n + 1, ..., m opens one with
    probability Π n/(n + mass), so that the first at which u Π (n + mass)/n passes one does. That product is kept in
    ``waited`` (restaurants,), which is written.
    """
    if seated > 0:
        waited[restaurant] *= 1.0 + mass / seated
        if waited[restaurant] <= 1.0:
            return False
    waited[restaurant] = 1.0 - generator.random()
    return True
