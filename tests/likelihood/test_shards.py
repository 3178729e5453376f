"""Shards hold what the table holds, however they are divided; what is wrong with them is told by name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal._kernels.shard_rows import direction_shares
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.sharded_blocked import UNIT
from subgoal.runtime.errors import InputError, StorageError
from subgoal.sharded import DirectionWriter, open_shards, write_shards
from subgoal.storage.shards import BLOCK, MANIFEST, read_groups


def walkers(n: int = 1500, slow: int = 40) -> tuple[Demonstrations, Candidates]:
    generator = np.random.default_rng(3)
    states, angle = generator.uniform(0, 10, (n, 2)), generator.uniform(0, 2 * np.pi, n)
    speed = np.where(np.arange(n) < slow, 1e-6, generator.uniform(0.5, 2, n))
    actions = np.stack([np.cos(angle), np.sin(angle)], axis=1) * speed[:, None]
    metric = subgoal.Metric.of(2, weights=[1.0, 0.5])
    places = Candidates(generator.uniform(0, 10, (7, 2)), generator.normal(size=7), radius=1.0, metric=metric)
    return Demonstrations.from_arrays(states, actions), places


def columns_of(shards, *names: str) -> list[np.ndarray]:
    """Whole columns, read back."""
    files, parts = shards.files, []
    for each in files.files:
        groups = range(-(-each.rows // files.group))
        parts += list(read_groups(files.folder / each.name, files.columns, names, groups))
    return [np.concatenate([part[name] for part in parts]) for name in names]


def test_a_stored_table_is_the_table(tmp_path: Path) -> None:
    """To the last digit of float32, impossible entries and all; every sum of peaks to the unit of each."""
    values = np.random.default_rng(0).normal(scale=30, size=(500, 6))
    values[np.random.default_rng(1).random(values.shape) < 0.3] = -np.inf
    values[:, 2] = 1.5
    shards = write_shards(LogLikelihood.from_table(values), tmp_path / "s")
    shares, peak = columns_of(shards, "shares", "peak")
    with np.errstate(divide="ignore"):
        found = np.where(shares > 0, np.log(np.abs(shares), dtype=float), shares)
    np.testing.assert_array_equal(np.isneginf(found), np.isneginf(values))
    np.testing.assert_allclose(found, values - peak[:, None], rtol=2e-7, atol=2e-7)
    np.testing.assert_array_equal(peak, values.max(axis=1))
    assert abs(shards.peaks * UNIT - peak.sum()) <= 500 * UNIT


def test_directions_give_the_density_of_the_library(tmp_path: Path) -> None:
    demos, places = walkers()
    likelihood = subgoal.action_comparison(demos, places, confidence=3.0)
    shards = write_shards(likelihood, tmp_path / "s", kind="directions")
    along, across, x, y = columns_of(shards, "along", "across", "x", "y")
    law, shares = shards.compass, np.empty((1500, 7))
    direction_shares(np.stack([along, across], axis=1), np.stack([x, y], axis=1), law.goals, law.near, law.confidence,
                     law.uniform, shares)  # fmt: skip
    np.testing.assert_allclose(np.log(shares) - law.log_normaliser, likelihood.rows(0, 1500), rtol=1e-11, atol=1e-12)
    assert abs(shards.peaks * UNIT + 1500 * law.log_normaliser) < 1e-6


def test_a_stream_of_positions_and_actions_is_the_same_shards(tmp_path: Path) -> None:
    demos, places = walkers()
    likelihood = subgoal.action_comparison(demos, places, confidence=3.0)
    whole = write_shards(likelihood, tmp_path / "whole", kind="directions")
    speed = np.linalg.norm(demos.actions * places.metric.weights, axis=1)
    with DirectionWriter(tmp_path / "stream", places, confidence=3.0, slow=0.01 * float(np.median(speed))) as writer:
        for start in range(0, 1500, 400):
            writer.append(demos.states[start : start + 400], demos.actions[start : start + 400])
    one, two = columns_of(whole, "along", "x"), columns_of(open_shards(tmp_path / "stream"), "along", "x")
    np.testing.assert_allclose(two[0], one[0], rtol=1e-15)
    np.testing.assert_array_equal(two[1], one[1])
    assert (two[0][:40] == 0).all()


def test_the_checksum_hangs_on_numbers_and_candidates_and_not_on_files(tmp_path: Path) -> None:
    generator = np.random.default_rng(0)
    states, actions = generator.normal(size=(3 * BLOCK + 5, 2)), generator.normal(size=(3 * BLOCK + 5, 2))
    found = []
    for name, rows, places, moved in (("a", BLOCK, 3, 0.0), ("b", 4 * BLOCK, 3, 0.0), ("c", BLOCK, 4, 0.0),
                                      ("d", BLOCK, 3, 1e-9)):  # fmt: skip
        candidates = Candidates(np.arange(2.0 * places).reshape(places, 2))
        with DirectionWriter(tmp_path / name, candidates, rows=rows) as writer:
            writer.append(states + moved * (np.arange(len(states)) == 7)[:, None], actions)
        found.append(open_shards(tmp_path / name))
    assert [len(each.files.files) for each in found] == [4, 1, 4, 4]
    sums = [each.checksum for each in found]
    assert sums[0] == sums[1]
    assert len(set(sums)) == 3


def test_rows_no_candidate_allows_are_refused_with_their_number(tmp_path: Path) -> None:
    values = np.zeros((30, 3))
    values[21] = -np.inf
    with pytest.raises(InputError, match="observation 21"):
        write_shards(LogLikelihood.from_table(values), tmp_path / "s")
    with pytest.raises(StorageError, match="no manifest"):
        open_shards(tmp_path / "s")
    assert not list((tmp_path / "s").iterdir())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    demos, places = walkers(600)
    write_shards(subgoal.action_comparison(demos, places), tmp_path / "s")
    return tmp_path / "s"


def refused(folder: Path) -> str:
    with pytest.raises(StorageError) as told:
        open_shards(folder)
    return str(told.value)


def test_a_missing_file_is_named(folder: Path) -> None:
    (folder / "shard-00000.parquet").unlink()
    assert "shard-00000.parquet: found no such file, wanted the file of 600 rows" in refused(folder)


def test_a_torn_file_is_named(folder: Path) -> None:
    path = folder / "shard-00000.parquet"
    path.write_bytes(path.read_bytes()[:-20])
    assert "shard-00000.parquet: found" in refused(folder)
    assert "bytes, wanted" in refused(folder)


def test_a_changed_file_is_named(folder: Path) -> None:
    path = folder / "shard-00000.parquet"
    held = bytearray(path.read_bytes())
    held[2000] ^= 1
    path.write_bytes(held)
    assert "shard-00000.parquet: found a wrong checksum" in refused(folder)
    assert open_shards(folder, verify=False).n_observations == 600


def test_a_file_torn_after_it_was_opened_is_named(folder: Path) -> None:
    shards = open_shards(folder)
    path = folder / "shard-00000.parquet"
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(StorageError, match=r"shard-00000\.parquet: found a torn or changed file"):
        columns_of(shards, "shares")


def test_numbers_changed_after_the_file_was_opened_are_told(folder: Path) -> None:
    shards = open_shards(folder)
    path = folder / "shard-00000.parquet"
    held = bytearray(path.read_bytes())
    held[2000] ^= 1
    path.write_bytes(held)
    with pytest.raises(StorageError, match=r"shard-00000\.parquet: found a torn or changed file"):
        columns_of(shards, "shares")


@pytest.mark.parametrize(("field", "value", "words"), [
    ("format", 99, "format 99, wanted kind 'shards', format 1"), ("kind", "posterior", "kind 'posterior'"),
    ("content", "00", "a manifest that was changed"),
])  # fmt: skip
def test_another_version_and_a_changed_manifest_are_told(folder: Path, field: str, value: object, words: str) -> None:
    path = folder / MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | {field: value}))
    assert words in refused(folder)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '"shards"', "[" * 100_000])
def test_a_torn_manifest_is_told(folder: Path, text: str) -> None:
    (folder / MANIFEST).write_text(text)
    assert MANIFEST in refused(folder)


def test_an_unfinished_folder_is_none(tmp_path: Path) -> None:
    _, places = walkers(10)
    with pytest.raises(ZeroDivisionError), DirectionWriter(tmp_path / "s", places) as writer:
        writer.append(np.zeros((3, 2)), np.ones((3, 2)))
        raise ZeroDivisionError
    assert not list((tmp_path / "s").iterdir())
    assert "no manifest" in refused(tmp_path / "s")


def test_what_cannot_be_written_is_refused(tmp_path: Path, folder: Path) -> None:
    demos, places = walkers(60)
    likelihood = subgoal.action_comparison(demos, places)
    with pytest.raises(InputError, match="empty folder"):
        write_shards(likelihood, folder)
    with pytest.raises(InputError, match="multiple of 65,536"):
        write_shards(likelihood, tmp_path / "a", rows=1000)
    with pytest.raises(InputError, match="no rows"), DirectionWriter(tmp_path / "b", places):
        pass
    with pytest.raises(InputError, match="kind='stored'"):
        write_shards(likelihood.with_background(0.1), tmp_path / "c", kind="directions")
    with pytest.raises(InputError, match="'stored' or 'directions'"):
        write_shards(likelihood, tmp_path / "d", kind="table")
    with pytest.raises(InputError, match="in the plane"):
        DirectionWriter(tmp_path / "e", Candidates(np.zeros((1, 3))))
    with pytest.raises(InputError, match="positions"), DirectionWriter(tmp_path / "f", places) as writer:
        writer.append([[np.nan, 0.0]], [[1.0, 0.0]])
    with pytest.raises(InputError, match="actions"), DirectionWriter(tmp_path / "g", places) as writer:
        writer.append(np.zeros((2, 2)), np.zeros((3, 2)))
