"""Stored posteriors: everything comes back, and no broken or hostile file does worse than a typed error."""

from __future__ import annotations

import io
import json
import pickle
import tracemalloc
import zipfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import StorageError
from subgoal.storage.archive import read_archive, write_archive
from tests.posterior.worlds import assert_same_posterior, corner_likelihood, quiet_sample, table

SHORT = {"chains": 2, "draws": 5, "warmup": 2, "thin": 1}


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return quiet_sample(corner_likelihood(), **SHORT)


@pytest.fixture
def saved(posterior: Posterior, tmp_path: Path) -> Path:
    return subgoal.save(posterior, tmp_path / "posterior.npz")


def assert_refused(path: Path) -> StorageError:
    with pytest.raises(StorageError) as caught:
        subgoal.load(path)
    assert str(path) in str(caught.value)
    return caught.value


def assert_same_record(one, two) -> None:
    for field in fields(one):
        left, right = getattr(one, field.name), getattr(two, field.name)
        if isinstance(left, np.ndarray):
            np.testing.assert_array_equal(left, right, err_msg=field.name)
            assert left.dtype == right.dtype
        elif isinstance(left, Metric):
            assert_same_record(left, right)
        else:
            assert left == right, field.name


def test_everything_comes_back(posterior: Posterior, saved: Path) -> None:
    back = subgoal.load(saved)
    assert_same_posterior(posterior, back)
    assert_same_record(posterior.demonstrations, back.demonstrations)
    assert_same_record(posterior.candidates, back.candidates)
    assert back.seconds == posterior.seconds
    assert back.likelihood is not None and posterior.likelihood is not None
    np.testing.assert_array_equal(back.likelihood.dense, posterior.likelihood.dense)


def test_names_units_priors_angles_and_notes_come_back(tmp_path: Path) -> None:
    generator = np.random.default_rng(4)
    demos = Demonstrations.from_arrays(
        generator.normal(size=(12, 2)), generator.normal(size=(12, 2)), [0, 5, 12], times=np.arange(12.0),
        final_states=generator.normal(size=(2, 2)), truncated=[True, False], names=("é", "θ"), units="m",
        trajectory_names=("один", "2"), time_unit="frame", source=Source("a.csv", "abc", {"rows dropped": 3}),
    )  # fmt: skip
    candidates = Candidates(
        generator.normal(size=(7, 2)), generator.normal(size=7), tuple("abcdefg"), 0.3,
        Metric(np.array([1.0, 2.0]), np.array([np.inf, 2 * np.pi])),
    )  # fmt: skip
    posterior = quiet_sample(subgoal.action_comparison(demos, candidates), **SHORT)
    posterior = replace(posterior, assignments=None, parameters={"confidence": generator.normal(size=(2, 5))})
    back = subgoal.load(subgoal.save(posterior, tmp_path / "p"))
    assert_same_posterior(posterior, back)
    assert_same_record(demos, back.demonstrations)
    assert_same_record(candidates, back.candidates)
    np.testing.assert_array_equal(back.parameters["confidence"], posterior.parameters["confidence"])


def test_prior_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    for seed in range(20):
        prior = np.random.default_rng(seed).normal(size=9)
        first = Candidates(np.arange(9.0), prior)
        np.testing.assert_array_equal(Candidates(np.arange(9.0), first.log_prior).log_prior, first.log_prior)


def test_table_of_given_numbers_loads_without_its_likelihood(tmp_path: Path) -> None:
    posterior = quiet_sample(table(), **SHORT)
    back = subgoal.load(subgoal.save(posterior, tmp_path / "p.npz"))
    assert_same_posterior(posterior, back)
    assert back.likelihood is None


def test_discrete_states_come_back(tmp_path: Path) -> None:
    demos = Demonstrations.from_arrays(np.arange(4), np.array([0, 1, 0, 2]))
    posterior = quiet_sample(LogLikelihood.from_table(np.zeros((4, 3)), demonstrations=demos), **SHORT)
    assert_same_record(demos, subgoal.load(subgoal.save(posterior, tmp_path / "p.npz")).demonstrations)
    assert demos.states.dtype == np.int64


def test_saving_twice_replaces_and_leaves_nothing_else(posterior: Posterior, saved: Path) -> None:
    subgoal.save(posterior, saved)
    assert [each.name for each in saved.parent.iterdir()] == [saved.name]
    assert saved.read_bytes()[:2] == b"PK"


def test_truncated_files(saved: Path, tmp_path: Path) -> None:
    whole = saved.read_bytes()
    torn = tmp_path / "torn.npz"
    for length in [*range(0, 200, 7), *range(200, len(whole), 997), len(whole) // 2, len(whole) - 1]:
        torn.write_bytes(whole[:length])
        assert_refused(torn)


def test_flipped_bits_are_noticed_or_harmless(posterior: Posterior, saved: Path, tmp_path: Path) -> None:
    """Harmless: a bit of the zip's own book-keeping (a date, a system number) that changes nothing that is read."""
    whole = bytearray(saved.read_bytes())
    torn = tmp_path / "torn.npz"
    noticed = 0
    places = range(0, len(whole), 97)
    for k, place in enumerate(places):
        flipped = bytearray(whole)
        flipped[place] ^= 1 << (k % 8)
        torn.write_bytes(flipped)
        try:
            assert_same_posterior(posterior, subgoal.load(torn))
        except StorageError:
            noticed += 1
    assert noticed >= 0.8 * len(places)


def test_every_bit_of_the_headers_may_flip(saved: Path, tmp_path: Path) -> None:
    """The first member's headers and the end of the directory, where zip and npy keep what they trust."""
    whole = bytearray(saved.read_bytes())
    torn = tmp_path / "torn.npz"
    noticed = 0
    for place in [*range(190), *range(len(whole) - 90, len(whole))]:
        flipped = bytearray(whole)
        flipped[place] ^= 1 << (place % 8)
        torn.write_bytes(flipped)
        try:
            subgoal.load(torn)
        except StorageError:
            noticed += 1
    assert noticed >= 100


@pytest.mark.parametrize("name", ["actions", "offset", "header"])
def test_arrays_changed_behind_the_checksum(name: str, saved: Path) -> None:
    """A file that is a whole zip of whole arrays, one of which is no longer the one that was saved."""
    with np.load(saved) as archive:
        members = dict(archive)
    if name == "header":
        members[name] = np.frombuffer(members[name].tobytes().replace(b"NOT_CONVERGED", b"CONVERGED"), np.uint8)
        members[name] = np.frombuffer(members[name].tobytes().replace(b"FEW_CHAINS", b"CONVERGED"), np.uint8)
    else:
        members[name] = members[name][::-1]
    np.savez(saved, **members)
    assert "a wrong checksum" in str(assert_refused(saved))


def test_missing_file_directory_and_other_files(tmp_path: Path) -> None:
    assert "no such file" in str(assert_refused(tmp_path / "none.npz"))
    assert_refused(tmp_path)
    for name, content in {
        "text": b"x,y\n1,2\n",
        "empty": b"",
        "pickle": pickle.dumps([1]),
        "zip": b"PK\x05\x06",
    }.items():
        (tmp_path / name).write_bytes(content)
        assert_refused(tmp_path / name)
    np.save(tmp_path / "a.npy", np.arange(3))
    assert_refused(tmp_path / "a.npy")


def test_wrong_kind_and_format(saved: Path, tmp_path: Path) -> None:
    header, arrays = read_archive(saved, "posterior")
    del header["kind"], header["format"]
    write_archive(tmp_path / "c", "checkpoint", header, arrays, keep_previous=False)
    assert "kind 'checkpoint'" in str(assert_refused(tmp_path / "c"))
    write_archive(tmp_path / "f", "posterior", {**header, "format": 99}, arrays, keep_previous=False)
    assert "format 99" in str(assert_refused(tmp_path / "f"))


def test_missing_or_wrong_fields(saved: Path, tmp_path: Path) -> None:
    """Whole, sealed files whose content is not a posterior's."""
    header, arrays = read_archive(saved, "posterior")
    path = tmp_path / "p"
    for name in arrays:
        if name.startswith(("trace_", "parameter_", "noise_", "times", "assignments")):
            continue
        write_archive(path, "posterior", header, {k: v for k, v in arrays.items() if k != name}, keep_previous=False)
        assert_refused(path)
    for key in ("settings", "status", "diagnostics", "names", "candidate_names", "radius", "source"):
        for bad in (None, [1], {"a": 1}, "x"):
            write_archive(path, "posterior", {**header, key: bad}, arrays, keep_previous=False)
            assert_refused(path)


def test_pickles_inside_are_not_opened(saved: Path, tmp_path: Path) -> None:
    header, arrays = read_archive(saved, "posterior")
    trap = tmp_path / "trap"

    class Trap:
        def __reduce__(self):
            return Path.touch, (trap,)

    members = {
        **arrays,
        "states": np.array([Trap()], object),
        "header": np.frombuffer(json.dumps(header).encode(), "u1"),
    }
    np.savez(tmp_path / "p.npz", **members, seal=np.zeros(32, np.uint8))
    assert_refused(tmp_path / "p.npz")
    assert not trap.exists()


def packed(path: Path, members: dict[str, bytes], method: int) -> Path:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def array_bytes(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


@pytest.mark.parametrize("method", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packed_bombs_are_refused_unopened(method: int, tmp_path: Path) -> None:
    """A small file that would unpack to 40 MB: refused with less than 20 MB more memory than before."""
    start = array_bytes(np.zeros(0, np.uint8)).replace(b"(0,)", b"(41943040,)")
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", method) as archive, archive.open("states.npy", "w") as stream:
        stream.write(start)
        for _ in range(40):
            stream.write(bytes(2**20))
    assert path.stat().st_size < 2**20
    tracemalloc.start()
    assert_refused(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20 * 2**20


@pytest.mark.parametrize("shape", [b"(1099511627776,)", b"(9223372036854775807, 9223372036854775807)", b"(-5,)"])
def test_arrays_that_claim_more_than_they_hold(shape: bytes, tmp_path: Path) -> None:
    content = array_bytes(np.zeros(0, np.uint8)).replace(b"(0,)", shape)
    assert_refused(packed(tmp_path / "p.npz", {"header.npy": content}, zipfile.ZIP_STORED))


@pytest.mark.parametrize("name", ["../states.npy", "/etc/states.npy", "a/../../b.npy", "\\states.npy"])
def test_members_that_point_elsewhere(name: str, saved: Path, tmp_path: Path) -> None:
    content = array_bytes(np.zeros(3))
    error = assert_refused(packed(tmp_path / "p.npz", {name: content}, zipfile.ZIP_STORED))
    assert "a member named" in str(error)


def test_headers_that_are_not_objects(tmp_path: Path) -> None:
    for text in (b"[1, 2]", b"7", b"null", b"{", b"\xff\xfe", b"[" * 100_000):
        header = array_bytes(np.frombuffer(text, np.uint8))
        members = {"header.npy": header, "seal.npy": array_bytes(np.zeros(32, np.uint8)), "text.txt": b"hello"}
        for left_out in (None, "seal.npy", "text.txt"):
            kept = {name: content for name, content in members.items() if name != left_out}
            assert_refused(packed(tmp_path / "p.npz", kept, zipfile.ZIP_STORED))
