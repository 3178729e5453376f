"""Co-clustering and the point partition against brute force over every partition."""

from __future__ import annotations

import warnings
from collections import Counter
from dataclasses import replace
from math import log

import numpy as np
import pytest

from subgoal._kernels import partitions as kernels
from subgoal.answers.partition import co_clustering, point_partition, variation_of_information
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import sample
from subgoal.runtime.errors import BudgetError, InputError
from tests.oracles.partitions import canonical, set_partitions


def entropy(labels) -> float:
    return -sum(c / len(labels) * log(c / len(labels)) for c in Counter(labels).values())


def vi_oracle(first, second) -> float:
    """H(first | second) + H(second | first)."""
    first, second = list(first), list(second)
    return 2 * entropy(list(zip(first, second, strict=True))) - entropy(first) - entropy(second)


def posterior_of(draws: np.ndarray, candidates: int = 6, *, chains: int = 2) -> Posterior:
    """A posterior whose assignments are ``draws`` (T, N)."""
    draws = np.asarray(draws, np.int32)
    table = np.zeros((draws.shape[1], candidates))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = sample(LogLikelihood.from_table(table), chains=2, draws=2, warmup=0, thin=1)
    return replace(made, assignments=draws.reshape(chains, -1, draws.shape[1]))


def noisy_draws(seed: int, n: int, count: int = 40, flips: float = 0.3) -> np.ndarray:
    generator = np.random.default_rng(seed)
    truth = generator.integers(0, 3, n)
    flipped = generator.random((count, n)) < flips
    return np.where(flipped, generator.integers(0, 6, (count, n)), truth)


def test_co_clustering_is_the_share_of_draws_together() -> None:
    draws = noisy_draws(0, 7)
    got = co_clustering(posterior_of(draws))
    wanted = [[np.mean([row[i] == row[j] for row in draws]) for j in range(7)] for i in range(7)]
    np.testing.assert_allclose(got, wanted, atol=1e-15)


def test_co_clustering_beyond_one_block_is_symmetric_with_ones() -> None:
    got = co_clustering(posterior_of(noisy_draws(1, 150, 10)))
    np.testing.assert_array_equal(got, got.T)
    np.testing.assert_array_equal(np.diag(got), 1)


def test_merged_subgoals_are_one_and_unmerged_candidates_stand_for_themselves() -> None:
    draws = np.array([[0, 1, 2, 3, 3], [1, 0, 2, 2, 3]])
    group = np.array([0, 0, -1, -1, -1, -1])
    made = posterior_of(draws)
    found = Subgoals(subgoals(made).items[:1], group, 0.0, np.ones((1, 2), int))
    got = co_clustering(made, found)
    assert got[0, 1] == 1
    assert got[2, 3] == 0.5
    assert got[3, 4] == 0.5
    assert got[0, 2] == 0


def test_background_is_a_cluster_of_its_own() -> None:
    made = posterior_of(np.array([[-1, -1, 5, 0]] * 2))
    found = Subgoals(subgoals(made).items[:1], np.array([0, 0, -1, -1, -1, -1]), 0.0, np.ones((1, 2), int))
    for merged in (None, found):
        np.testing.assert_array_equal(co_clustering(made, merged)[0], [1, 1, 0, 0])


def test_refuses_without_assignments_and_above_the_budget() -> None:
    made = posterior_of(noisy_draws(2, 6))
    with pytest.raises(InputError, match="not kept"):
        co_clustering(replace(made, assignments=None))
    with pytest.raises(BudgetError, match="co-clustering"):
        co_clustering(made, memory_budget=100)
    with pytest.raises(BudgetError, match="co-clustering"):
        point_partition(made, memory_budget=100)


@pytest.mark.parametrize("n", [1, 2, 4, 6])
@pytest.mark.parametrize("flips", [0.0, 0.3, 0.6, 1.0])
def test_point_partition_is_the_best_of_all_partitions(n: int, flips: float) -> None:
    for seed in range(2):
        draws = noisy_draws(10 * n + seed, n, flips=flips)
        got = point_partition(posterior_of(draws))
        costs = {labels: np.mean([vi_oracle(labels, row) for row in draws]) for labels in set_partitions(n)}
        assert got.expected_vi == pytest.approx(min(costs.values()), abs=1e-9)
        assert costs[canonical(got.labels.tolist())] == pytest.approx(got.expected_vi, abs=1e-9)


@pytest.mark.parametrize("moves", ["singles", "merger"])
def test_moves_improve_where_no_visited_draw_is_good(moves: str) -> None:
    """From a bad start the descent alone must reach the best partition."""
    from subgoal.answers import partition

    truth = np.repeat([0, 1], 3)
    draws = np.array([np.where(np.arange(6) == k, 2, truth) for k in range(6)] * 4)
    bad = np.array([0, 0, 1, 2, 2, 2]) if moves == "merger" else np.array([0, 0, 1, 1, 1, 1])
    problem = partition._Problem.of(partition._compact(draws))
    assert canonical(problem.improve(bad).tolist()) == canonical(truth.tolist())


def test_mergers_leave_a_local_minimum_of_single_moves() -> None:
    """Two halves of a pair of clusters: no single move helps as much as the merger, and the merger is found."""
    from subgoal.answers import partition

    truth = np.zeros(12, int)
    problem = partition._Problem.of(truth[None])
    sizes, labels = np.array([6, 6]), np.repeat([0, 1], 6)
    cross = kernels.cross_counts(labels, truth[None], 2, 1)
    change, first, second = kernels.best_merger(sizes, cross, problem.weight)
    assert (first, second) == (0, 1)
    assert change / 12 == pytest.approx(vi_oracle(truth, truth) - vi_oracle(labels, truth))


def test_move_reports_what_it_gains() -> None:
    from subgoal.answers import partition

    draws = partition._compact(noisy_draws(3, 30))
    problem = partition._Problem.of(draws)
    labels = partition._compact(noisy_draws(4, 30))[0]
    before = problem.expected_vi(labels)
    sizes = np.bincount(labels, minlength=10)
    cross = kernels.cross_counts(labels, draws, 10, problem.widest)
    fall = kernels.move_singles(labels, sizes, cross, draws, problem.weight)
    assert fall > 0
    assert before - problem.expected_vi(labels) == pytest.approx(fall / 30)
    np.testing.assert_array_equal(sizes, np.bincount(labels, minlength=10))
    np.testing.assert_array_equal(cross, kernels.cross_counts(labels, draws, 10, problem.widest))


def test_labels_are_ordered_by_size() -> None:
    got = point_partition(posterior_of(np.array([[0, 1, 1, 1, 2, 2]] * 4)))
    np.testing.assert_array_equal(got.labels, [2, 0, 0, 0, 1, 1])
    assert got.expected_vi == pytest.approx(0, abs=1e-12)
    assert got.n_clusters == 3


def test_variation_of_information_is_a_metric() -> None:
    every = [np.array(labels) for labels in set_partitions(4)]
    cost = np.array([[variation_of_information(a, b) for b in every] for a in every])
    wanted = np.array([[vi_oracle(a.tolist(), b.tolist()) for b in every] for a in every])
    np.testing.assert_allclose(cost, wanted, atol=1e-12)
    np.testing.assert_allclose(cost, cost.T, atol=1e-12)
    assert (cost[~np.eye(len(every), dtype=bool)] > 1e-6).all()
    assert (cost[:, None, :] <= cost[:, :, None] + cost[None] + 1e-12).all()
    assert cost.max() == pytest.approx(log(4))


@pytest.mark.parametrize("name", ["count_together", "cross_counts", "mutual_sum", "move_singles", "best_merger"])
def test_compiled_is_its_python_form(name: str) -> None:
    from subgoal.answers import partition

    draws = partition._compact(noisy_draws(5, 9, 6))
    weight = partition._Problem.of(draws).weight
    results = []
    for function in (getattr(kernels, name), getattr(kernels, name).py_func):
        labels, together = draws[0].copy(), np.zeros((9, 9))
        sizes, widest = np.bincount(labels, minlength=8), int(draws.max()) + 1
        cross = kernels.cross_counts(labels, draws, 8, widest)
        arguments = {
            "count_together": (np.ascontiguousarray(draws.T), 2, 7, together),
            "cross_counts": (labels, draws, 8, widest),
            "mutual_sum": (labels, draws, 8, widest, weight),
            "move_singles": (labels, sizes, cross, draws, weight),
            "best_merger": (sizes, cross, weight),
        }[name]
        answer = function(*arguments)
        results.append([np.asarray(part, float) for part in (answer if answer is not None else 0.0, labels, sizes,
                                                             cross, together)])  # fmt: skip
    for compiled, plain in zip(*results, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=1e-13)


def test_real_subgoals_are_used_when_given() -> None:
    """Near-duplicates count as one place: with the merger the draws agree, without it they do not."""
    points = np.array([[0.0, 0], [0.1, 0], [9, 9]])
    draws = np.array([[0, 0, 2, 2], [1, 0, 2, 2], [0, 1, 2, 2], [1, 1, 2, 2]] * 5)
    made = replace(posterior_of(draws, 3), candidates=Candidates(points, radius=1.0))
    found = Subgoals(subgoals(made).items[:2], np.array([0, 0, 1]), 5.0, np.ones((2, 10), int))
    assert point_partition(made, found).expected_vi == pytest.approx(0, abs=1e-12)
    assert point_partition(made).expected_vi > 0.1
