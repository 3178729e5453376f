"""The primitives through which samplers draw, and the seats drawn with them, against their laws.

A generator that gives the midpoints of 2^14 equal parts of [0, 1) one by one stands for all random numbers, so that
shares are exact to one part.
"""

from __future__ import annotations

import numpy as np
import pytest

from subgoal._kernels import draws
from subgoal._kernels.seating import clear, seat_rows, seating_for
from tests.exact.replay import plain

PARTS = 2**14


class Given:
    """A generator that gives one number for ever."""

    def __init__(self, value: float) -> None:
        self.value = value

    def random(self) -> float:
        return self.value


def everywhere():
    return (Given((k + 0.5) / PARTS) for k in range(PARTS))


@pytest.mark.parametrize("mass", [0.05, 1.0, 7.5])
def test_a_table_is_opened_with_the_chance_of_the_restaurant(mass: float) -> None:
    """After the first: none of n = 1, ..., m opens one with probability Π n/(n + mass)."""
    opens, seats = plain(draws.opens), 12
    first = np.zeros(seats + 1)
    for generator in everywhere():
        waited = np.zeros(1)
        assert opens(waited, 0, 0, mass, generator)
        opened = (n for n in range(1, seats) if opens(waited, 0, n, mass, generator))
        first[next(opened, seats)] += 1
    survive = np.cumprod([1.0, *(n / (n + mass) for n in range(1, seats))])
    wanted = np.append(survive[:-1] - survive[1:], survive[-1])
    assert np.abs(first[1:] / PARTS - wanted).max() <= 1.5 / PARTS


def test_a_listed_table_is_chosen_by_its_size() -> None:
    following, sizes = np.array([-1, 0, 9, 1]), np.array([5, 2, 100, 4])
    seen = np.zeros(4)
    for generator in everywhere():
        seen[plain(draws.choose_listed)(3, following, sizes, 11, generator)] += 1
    assert np.abs(seen / PARTS - np.array([5, 2, 0, 4]) / 11).max() <= 1.5 / PARTS


@pytest.mark.parametrize("count", [1, 3, 4, 11])
def test_an_index_is_chosen_by_its_weight(count: int) -> None:
    weights = np.random.default_rng(count).uniform(size=count + 2) * (np.arange(count + 2) % 3 != 1)
    total, seen, of_total = weights[:count].sum(), np.zeros(count), np.zeros(count)
    for generator in everywhere():
        seen[plain(draws.choose)(weights, count, generator)] += 1
        of_total[plain(draws.choose_of)(weights, count, total, generator)] += 1
    for found in (seen, of_total):
        assert np.abs(found / PARTS - weights[:count] / total).max() <= 1.5 / PARTS


def test_nothing_without_weight_is_drawn() -> None:
    """Even where rounding lets the running sum end below its target."""
    assert draws.at_target(np.array([0.5, 0.25, 0.0, 0.0]), 4, 0.76) == 1
    assert draws.at_target(np.array([0.0, 0.5, 0.0]), 3, 0.0) == 1


def test_rows_are_added_to_the_sums_of_their_tables() -> None:
    generator, n, restaurants = np.random.default_rng(4), 200, 3
    tile, restaurant = generator.normal(size=(n, 5)), generator.integers(restaurants, size=n)
    seating, sums = seating_for(n, restaurants), np.full((n, 5), 7.0)
    for _ in range(2):
        clear(seating)
        count = seat_rows(0, tile[:90], restaurant, np.array([0.1, 2.0, 9.0]), seating, sums, 0, generator)
        count = seat_rows(90, tile[90:], restaurant, np.array([0.1, 2.0, 9.0]), seating, sums, count, generator)
        for table in range(count):
            members = seating.table_of == table
            assert len(set(restaurant[members])) == 1
            assert seating.sizes[table] == members.sum() > 0
            np.testing.assert_allclose(sums[table], tile[members].sum(axis=0), atol=1e-12)
    assert (seating.seated == np.bincount(restaurant)).all()


def test_numbers_of_tables_have_the_mean_of_the_restaurant() -> None:
    """Compiled, over 4,000 seatings: E[tables] = Σ mass/(mass + n); six standard errors."""
    generator, n, mass = np.random.default_rng(8), 30, 1.7
    seating, rows, restaurant = seating_for(n, 1), np.empty((n, 0)), np.zeros(n, np.int64)
    found = np.empty(4000)
    for k in range(found.size):
        clear(seating)
        found[k] = seat_rows(0, rows, restaurant, np.array([mass]), seating, rows, 0, generator)
    chance = mass / (mass + np.arange(n))
    spread = np.sqrt((chance * (1 - chance)).sum() / found.size)
    assert abs(found.mean() - chance.sum()) <= 6 * spread
