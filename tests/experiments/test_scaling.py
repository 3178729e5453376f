"""The model of a cluster, where the answer is known, and simulated shards."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments import scaling
from experiments.cluster_model import Cluster, mean_sweep, plans, table
from subgoal.sharded import open_shards

STEADY = Cluster(spread=0.0, slow=0.0, lost_per_hour=0.0, latency=0.0, columns=100)


def test_without_chance_the_work_is_pairs_over_cores_and_nobody_waits() -> None:
    cost = mean_sweep(STEADY, sweeps=2)
    assert cost.work == pytest.approx(1e10 * 100 * 4 / 5e8 / 1000)
    assert cost.waiting == pytest.approx(0, abs=1e-9)
    assert cost.lost == 0
    assert cost.scheduler == pytest.approx(2.0)
    assert cost.total == pytest.approx(cost.work + cost.weights + cost.sums + cost.scheduler)


def test_weights_pass_the_scheduler_twice_with_every_job_or_go_down_a_tree() -> None:
    size = 8 * 100_000 * 4 / 1.25e9
    assert mean_sweep(STEADY, sweeps=1).weights == pytest.approx(2 * 2000 * size)
    assert mean_sweep(replace(STEADY, tree=True), sweeps=1).weights == pytest.approx(3 * 16 * size)


def test_the_last_of_many_jobs_is_waited_for_and_smaller_parts_even_out() -> None:
    uneven = replace(STEADY, slow=0.001)
    few, many = mean_sweep(uneven), mean_sweep(replace(uneven, parts=16))
    assert few.waiting > 2 * many.waiting > 0


def test_reading_is_waited_for_where_it_takes_longer_than_the_work() -> None:
    slow = replace(STEADY, disk=1e6)
    assert mean_sweep(slow, sweeps=1).work == pytest.approx(1e10 * 32 / 1e6 / 1000)


def test_a_lost_worker_costs_its_notice_and_its_job_by_the_chance_of_one() -> None:
    cost = mean_sweep(replace(STEADY, lost_per_hour=1.0), sweeps=1)
    assert 0 < cost.lost < 30 + cost.work
    assert mean_sweep(replace(STEADY, lost_per_hour=1e9), sweeps=1).lost == pytest.approx(30 + cost.work / 2)


def test_the_table_has_a_row_for_each_plan() -> None:
    assert table(plans()).count("\n") == len(plans()) + 1


@pytest.mark.parametrize("kind", ["directions", "stored"])
def test_simulated_shards_have_the_rows_that_were_asked_for(kind: str, tmp_path: Path) -> None:
    scaling.simulate(tmp_path / "s", 3000, kind, 0)
    shards = open_shards(tmp_path / "s")
    assert (shards.n_observations, shards.kind) == (3000, kind)
    assert [each.name for each in tmp_path.iterdir()] == ["s"]


def test_walkers_head_for_the_first_places() -> None:
    places = scaling.places_of(0).points
    states, units = scaling.walkers(places, 500, np.random.default_rng(0))
    way = places[None, :6] - states[:, None]
    along = (way * units[:, None]).sum(axis=2) / np.linalg.norm(way, axis=2)
    assert (along.max(axis=1) > np.cos(3 * scaling.NOISE)).mean() > 0.99
