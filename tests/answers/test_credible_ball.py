"""Credible balls against enumeration: every partition of five things, drawn as often as it is probable."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from math import log

import numpy as np
import pytest

import subgoal
from subgoal.answers.credible_ball import credible_ball, distances
from subgoal.answers.partition import point_partition
from subgoal.candidates import Candidates
from subgoal.runtime.errors import InputError
from tests.answers.test_partition import noisy_draws, posterior_of, vi_oracle
from tests.oracles.partitions import canonical, set_partitions

N = 5


def enumerated(seed: int, total: int = 300) -> tuple[dict[tuple, int], np.ndarray]:
    """How often each of the 52 partitions of five things is drawn, and the draws with labels at random."""
    generator = np.random.default_rng(seed)
    every = list(set_partitions(N))
    often = generator.multinomial(total, generator.dirichlet(np.full(len(every), 0.3)))
    rows = [labels for labels, count in zip(every, often, strict=True) for _ in range(count)]
    relabelled = [generator.permutation(6)[list(row)] for row in rows]
    return {tuple(k): int(c) for k, c in zip(every, often, strict=True) if c}, generator.permutation(relabelled)


def by_enumeration(counts: dict[tuple, int], centre: tuple, share: float):
    """Radius, held share, horizontal, upper and lower bounds as sets of partitions: the definitions, word for word."""
    far = {labels: round(vi_oracle(labels, centre), 9) for labels in counts}
    total = sum(counts.values())
    held = {r: sum(c for labels, c in counts.items() if far[labels] <= r) / total for r in set(far.values())}
    radius = min(r for r, mass in held.items() if mass >= share - 1e-12)
    ball = [labels for labels in counts if far[labels] <= radius]

    def farthest(some: list[tuple]) -> set[tuple]:
        most = max(far[labels] for labels in some)
        return {labels for labels in some if far[labels] == most}

    size = {labels: len(set(labels)) for labels in ball}
    few, many = min(size.values()), max(size.values())
    upper, lower = ([labels for labels in ball if size[labels] == k] for k in (few, many))
    return radius, held[radius], farthest(ball), farthest(upper), farthest(lower)


def as_set(rows: np.ndarray) -> set[tuple]:
    return {canonical(row.tolist()) for row in rows}


@pytest.mark.parametrize("share", [0.5, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_radius_and_bounds_are_those_of_the_enumeration(share: float, seed: int) -> None:
    counts, draws = enumerated(seed)
    posterior = posterior_of(draws)
    point = point_partition(posterior)
    ball = credible_ball(posterior, point, probability=share)
    radius, held, *bounds = by_enumeration(counts, canonical(point.labels.tolist()), share)
    assert ball.radius == pytest.approx(radius, abs=1e-8)
    assert ball.probability == pytest.approx(held, abs=1e-12)
    assert ball.probability >= share - 1e-12
    for found, wanted in zip((ball.horizontal, ball.upper, ball.lower), bounds, strict=True):
        assert as_set(found) == wanted
        assert len(found) == len(wanted)


def test_every_distance_is_the_variation_of_information() -> None:
    draws = noisy_draws(0, 12)
    centre = noisy_draws(1, 12)[0]
    wanted = [vi_oracle(row, centre) for row in draws]
    np.testing.assert_allclose(distances(centre, draws), wanted, atol=1e-12)
    np.testing.assert_allclose(credible_ball(posterior_of(draws), centre).distance, wanted, atol=1e-12)
    background = np.where(draws == 5, -1, draws)
    np.testing.assert_allclose(distances(centre, background), wanted, atol=1e-12)


def test_draws_that_are_all_the_centre_are_a_ball_of_no_radius() -> None:
    ball = credible_ball(posterior_of(np.array([[3, 3, 1], [1, 1, 0]])), np.array([7, 7, 2]))
    assert (ball.radius, ball.probability) == (0.0, 1.0)
    for bound in (ball.horizontal, ball.upper, ball.lower, ball.centre[None]):
        assert bound.tolist() == [[0, 0, 1]]
    assert repr(ball) == "CredibleBall(100.0% of the draws within 0 nats, 2 to 2 clusters)"


def test_the_largest_cluster_is_the_first() -> None:
    ball = credible_ball(posterior_of(np.array([[4, 2, 2, 2, 0, 0]] * 2)), np.zeros(6, int))
    assert ball.horizontal.tolist() == [[2, 0, 0, 0, 1, 1]]
    assert ball.radius == pytest.approx(vi_oracle([4, 2, 2, 2, 0, 0], [0] * 6))
    assert ball.radius < log(6)


def test_merged_subgoals_are_one() -> None:
    points = np.array([[0.0, 0], [0.1, 0], [9, 9]])
    draws = np.array([[0, 0, 2, 2], [1, 0, 2, 2], [0, 1, 2, 2], [1, 1, 2, 2]] * 5)
    made = replace(posterior_of(draws, 3), candidates=Candidates(points, radius=1.0))
    point = np.array([0, 0, 1, 1])
    found = replace(subgoal.subgoals(made), items=subgoal.subgoals(made).items[:2], group=np.array([0, 0, 1]))
    assert credible_ball(made, point, found).radius == 0
    assert credible_ball(made, point).radius > 0.1


def test_rare_draws_are_outside() -> None:
    """One draw in twenty is far off: it is outside of 95 %, and inside of a little more."""
    draws = np.array([[0, 0, 1, 1]] * 19 + [[0, 1, 2, 3]])
    counts = Counter(map(tuple, draws))
    assert max(counts.values()) == 19
    near, far = (credible_ball(posterior_of(draws), np.array([0, 0, 1, 1]), probability=p) for p in (0.95, 0.951))
    assert (near.radius, near.probability) == (0.0, 0.95)
    assert (far.radius, far.probability) == (pytest.approx(log(2)), 1.0)
    assert far.lower.tolist() == [[0, 1, 2, 3]]
    assert far.upper.tolist() == [[0, 0, 1, 1]]


@pytest.mark.parametrize("probability", [0.0, 1.5, float("nan")])
def test_what_is_no_probability(probability: float) -> None:
    with pytest.raises(InputError, match="probability"):
        credible_ball(posterior_of(noisy_draws(0, 4)), np.zeros(4, int), probability=probability)


def test_what_does_not_fit() -> None:
    posterior = posterior_of(noisy_draws(0, 4))
    for labels in (np.zeros(3, int), np.zeros(4), np.zeros((2, 4), int)):
        with pytest.raises(InputError, match="point"):
            credible_ball(posterior, labels)
    with pytest.raises(InputError, match="assignments"):
        credible_ball(replace(posterior, assignments=None), np.zeros(4, int))
