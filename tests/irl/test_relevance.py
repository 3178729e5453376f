"""State relevance: against sums written out, its limits of narrow and wide, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl import relevance as module
from subgoal.irl.relevance import constant, exponential, relevance, squared_exponential
from subgoal.mdp.grids.rooms import room_world
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError

LINE = np.array([[0.0], [1.0], [2.0], [5.0]])
DEMOS = Demonstrations.from_arrays(np.array([1, 1, 1, 2]), np.zeros(4, int))


def written_out(similarity, counts) -> list[float]:
    sums = [sum(n * similarity(abs(x - y)) for y, n in counts.items()) for x in (0.0, 1.0, 2.0, 5.0)]
    return [total / max(sums) for total in sums]


@pytest.mark.parametrize("width", [0.3, 1.0, 4.0])
def test_it_is_the_sum_over_visited_states_by_its_maximum(width: float) -> None:
    for made, similarity in (
        (squared_exponential(width), lambda d: math.exp(-(d**2) / (2 * width**2))),
        (exponential(width), lambda d: math.exp(-d / (2 * width**2))),
    ):
        once = relevance(DEMOS, LINE, made)
        np.testing.assert_allclose(once, written_out(similarity, {1.0: 1, 2.0: 1}), rtol=1e-12)
        often = relevance(DEMOS, LINE, made, multiplicity=True)
        np.testing.assert_allclose(often, written_out(similarity, {1.0: 3, 2.0: 1}), rtol=1e-12)


@pytest.mark.parametrize("multiplicity", [False, True])
def test_a_constant_covariance_makes_all_states_alike(multiplicity: bool) -> None:
    np.testing.assert_array_equal(relevance(DEMOS, LINE, constant(), multiplicity=multiplicity), np.ones(4))


def test_a_narrow_one_leaves_the_visited_states_alone() -> None:
    np.testing.assert_allclose(relevance(DEMOS, LINE, squared_exponential(0.1)), [0, 1, 1, 0], atol=1e-20)


def test_a_wide_one_falls_off_around_them() -> None:
    told = relevance(DEMOS, LINE, squared_exponential(1.0))
    assert told.max() == 1 and 0.4 < told[0] < 0.7 and 0 < told[3] < 0.01


def test_states_that_mirror_each_other_are_alike() -> None:
    places = np.array([[-2.0, 1.0], [2.0, 1.0], [-1.0, 0.0], [1.0, 0.0], [0.0, 3.0]])
    demos = Demonstrations.from_arrays(np.array([2, 3, 3, 4]), np.zeros(4, int))
    told = relevance(demos, places, squared_exponential(0.8))
    assert told[0] == pytest.approx(told[1]) and told[2] == pytest.approx(told[3])
    for made in (squared_exponential(0.8), exponential(0.8), constant()):
        np.testing.assert_array_equal(made(places, places), made(places, places).T)


def test_a_world_brings_its_coordinates_and_its_states_are_those_of_the_cells() -> None:
    world = room_world("A")
    demos = Demonstrations.from_arrays(np.array([world.start]), np.array([0]))
    told = relevance(demos, world.grid.mdp, squared_exponential(1.0))
    far = np.linalg.norm(world.grid.cells - world.grid.cells[world.start], axis=1)
    np.testing.assert_allclose(told, np.exp(-(far**2) / 2), rtol=1e-12)
    assert not told.flags.writeable


def test_blocks_do_not_change_it(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = relevance(DEMOS, LINE, squared_exponential(1.3))
    monkeypatch.setattr(module, "BLOCK", 1)
    np.testing.assert_array_equal(relevance(DEMOS, LINE, squared_exponential(1.3)), whole)


BARE = TabularMDP.from_dense(np.ones((4, 1, 4)) / 4, 0.9)


@pytest.mark.parametrize(
    ("world", "covariance", "match"),
    [
        (BARE, constant(), "world: found a world without coordinates"),
        (LINE[:2], constant(), r"demonstrations.states at"),
        (LINE.ravel(), constant(), "coordinates"),
        (LINE * np.nan, constant(), "coordinates at index"),
        (LINE, lambda here, there: np.ones((1, 1)), r"covariance: found shape \(1, 1\), wanted shape \(4, 2\)"),
        (LINE, lambda here, there: here @ there.T - 3, "covariance: found -3.0, wanted numbers of at least 0"),
        (LINE, lambda here, there: np.full((4, 2), np.nan), "covariance at index"),
        (LINE, lambda here, there: np.zeros((4, 2)), "covariance: found 0 everywhere"),
    ],
)
def test_what_is_refused(world, covariance, match: str) -> None:
    with pytest.raises(InputError, match=match):
        relevance(DEMOS, world, covariance)


@pytest.mark.parametrize("make", [squared_exponential, exponential])
@pytest.mark.parametrize("width", [0, -1, float("nan")])
def test_widths_are_above_zero(make, width: float) -> None:
    with pytest.raises(InputError, match="width"):
        make(width)
