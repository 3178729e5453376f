"""Slow and obvious: every partition, every seating with dishes, and their probabilities by the chain rule.

Imports nothing from the package under test.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product


def set_partitions(n: int) -> Iterator[tuple[int, ...]]:
    """Every partition of n things as labels (restricted growth strings), Bell(n) of them, in lexicographic order.

    The first label is 0 and each later one is at most one above the largest so far.
    """
    if n == 0:
        yield ()
        return
    for shorter in set_partitions(n - 1):
        for label in range(max(shorter, default=-1) + 2):
            yield (*shorter, label)


def table_states(n: int, n_candidates: int) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Every pair of a partition's labels (n,) and its tables' dishes (number of tables,)."""
    for labels in set_partitions(n):
        for dishes in product(range(n_candidates), repeat=max(labels, default=-1) + 1):
            yield labels, dishes


def crp_probability(labels: Sequence[int], eta: float) -> float:
    """Probability of a seating, customer after customer: thesis (2.8). Any label names will do."""
    probability = 1.0
    for i, label in enumerate(labels):
        seated = sum(1 for earlier in labels[:i] if earlier == label)
        probability *= (seated if seated else eta) / (i + eta)
    return probability


def canonical(labels: Sequence[int]) -> tuple[int, ...]:
    """The same partition with its tables renamed 0, 1, ... in order of first appearance."""
    names: dict[int, int] = {}
    return tuple(names.setdefault(label, len(names)) for label in labels)


def blocks(labels: Sequence[int]) -> list[list[int]]:
    """The members of each table, in order of the table's first appearance."""
    seated: dict[int, list[int]] = {}
    for member, label in enumerate(labels):
        seated.setdefault(label, []).append(member)
    return list(seated.values())


def block_sizes(labels: Sequence[int]) -> list[int]:
    """How many sit at each table, in order of the table's first appearance."""
    return [len(members) for members in blocks(labels)]


def urn_probability(dishes: Sequence[int], eta: float, prior: Sequence[float]) -> float:
    """Probability of a sequence of dishes, draw after draw from Blackwell and MacQueen's urn."""
    probability = 1.0
    for i, dish in enumerate(dishes):
        seen = sum(1 for earlier in dishes[:i] if earlier == dish)
        probability *= (seen + eta * prior[dish]) / (i + eta)
    return probability
