"""Files that are broken, hostile or not there: a typed error in two seconds and 200 MB, or the right answer."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from subgoal.demonstrations import read
from subgoal.demonstrations.readers import PAIRS, RECORDINGS
from subgoal.runtime.errors import InputError, ReadError, SubgoalError
from tests.demonstrations.valid_files import write_all

FORMATS = (
    "b.bag", "b.db3", "b.mcap", "csv.csv", "edinburgh.txt", "euroc.csv", "labyrinth.csv", "lasa.mat", "packed.npz",
    "pairs.npz", "plain.npz", "several.h5", "sheet.csv", "single.csv", "sleap.h5", "table.parquet", "tum.txt",
)  # fmt: skip
ENDINGS = (".csv", ".tsv", ".txt", ".parquet", ".npz", ".mat", ".h5", ".bag", ".db3", ".mcap", ".xyz", "")
MAGIC = (
    b"PK\x03\x04", b"PAR1", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0 MAT-file", b"scorer,", b"session,bout,step,node,",
    b"#ROSBAG V2.0\n", b"\x89MCAP0\r\n", b"SQLite format 3\0", b"#timestamp [ns], p_RS_R_x [m]",
)  # fmt: skip


def fuzzed(count: int, seed: int) -> dict[str, dict]:
    """What became of ``count`` broken files of each format, in a process that may crash."""
    command = [sys.executable, "-m", "tests.robustness.fuzz_readers", str(count), str(seed)]
    child = subprocess.run(command, capture_output=True, text=True, cwd=Path(__file__).parents[2], check=False)
    lines = [json.loads(line) for line in child.stdout.splitlines()]
    told = {line["format"]: line for line in lines if "format" in line}
    assert child.returncode == 0, f"crashed after {lines[-1:]}: {child.stderr[-2000:]}"
    return told


@pytest.fixture(scope="module")
def small_run():
    return fuzzed(300, 1)


@pytest.mark.parametrize("name", FORMATS)
def test_broken_files_are_read_or_refused(small_run, name):
    told = small_run[name]
    assert told["failures"] == []
    assert told["slowest"] < 2
    assert told["read"] + told["refused"] == (15 if name.endswith(".h5") else 300)
    assert told["refused"] > 0


@pytest.mark.t2
def test_ten_thousand_broken_files_are_read_or_refused():
    told = fuzzed(1000, 2)
    assert sorted(told) == sorted(FORMATS)
    assert {name: line["failures"] for name, line in told.items() if line["failures"]} == {}
    assert sum(line["read"] + line["refused"] for line in told.values()) > 10_000


@pytest.mark.parametrize("ending", ENDINGS)
def test_files_that_are_empty_or_noise_are_refused(tmp_path, ending):
    path = tmp_path / f"file{ending}"
    noise = np.random.default_rng(0).bytes(5000)
    for content in (b"", b"\0", b"\n", b"\0" * 5000, noise, noise.replace(b"\0", b"a"), b"a" * 10**6, b'"' * 1001):
        path.write_bytes(content)
        with pytest.raises(ReadError):
            read(path)


@pytest.mark.parametrize("magic", MAGIC)
def test_files_that_only_begin_well_are_refused(tmp_path, magic):
    for name, rest in (("file", b""), ("file.csv", b"\0" * 300), ("file.csv", np.random.default_rng(1).bytes(999))):
        (tmp_path / name).write_bytes(magic + rest)
        with pytest.raises(ReadError):
            read(tmp_path / name)


@pytest.mark.parametrize("format", [None, *RECORDINGS, *PAIRS])
def test_what_is_no_file_is_refused_by_every_reader(tmp_path, format):
    for path, message in (
        (tmp_path / "absent.csv", "no such file"),
        (tmp_path, "a folder"),
        (tmp_path / "absent" / "absent.npz", "no such file"),
        ("/dev/zero", "something special"),
        ("x" * 5000, "long|no such"),
    ):
        with pytest.raises(ReadError, match=message):
            read(path, format=format)
    for path in (None, 3, "a\0b", b"bytes"):
        with pytest.raises(InputError, match="wanted the name of a file"):
            read(path, format=format)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may read every file")
def test_a_file_that_may_not_be_read_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("x,y\n1,2\n2,3\n")
    path.chmod(0)
    with pytest.raises(ReadError, match="denied"):
        read(path)


@pytest.mark.parametrize("format", [*RECORDINGS, *PAIRS])
def test_a_file_of_one_format_read_as_another_is_refused_or_read(tmp_path, format):
    for path, options in write_all(tmp_path).values():
        try:
            read(path, format=format, **options)
        except SubgoalError as problem:
            assert len(str(problem)) > 20


def test_long_lines_of_brackets_take_linear_time(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("TRACK.R1=[[" + "[1 2 3];" * 200_000)
    begin = time.perf_counter()
    with pytest.raises(ReadError, match="torn"):
        read(path)
    path.write_text("TRACK.R1=" * 200_000)
    with pytest.raises(ReadError, match="torn"):
        read(path)
    assert time.perf_counter() - begin < 2


def test_reading_leaves_files_alone(tmp_path):
    files = write_all(tmp_path)
    before = {name: path.read_bytes() for name, (path, _) in files.items()}
    for path, options in files.values():
        read(path, **options)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
