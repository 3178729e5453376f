"""Break valid files in many ways and read them; run as a program, so that a crash costs nobody else.

    python -m tests.robustness.fuzz_readers COUNT SEED

prints {"begin": name} and {"format": name, "read": n, "refused": n, "slowest": s, "failures": [...]} for each format,
one JSON line each. HDF5 files, which take a process each, are a twentieth of COUNT.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations import read
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.errors import SubgoalError
from tests.demonstrations.valid_files import write_all

TOKENS = [
    b"1e400", b"-1e308", b"\0", b"\xff\xfe", b"9" * 30, b"9" * 400, b'"', b"'", b"nan", b"inf", b"\n", b"\r", b",,",
    b";", b"[[", b"]]", b"-", b"=", b"0", b"e", b"\xef\xbb\xbf", b"TRACK.R1=", b" ", b"#", b"\x80\x02cos\nsystem\n",
    b"PK\x03\x04", (2**31 - 1).to_bytes(4, "little"), (2**63 - 1).to_bytes(8, "little"), b"\xff" * 8, b"x" * 3000,
]  # fmt: skip


def broken(content: bytes, rng: np.random.Generator) -> bytes:
    """``content`` with one to three faults."""
    for _ in range(int(rng.integers(1, 4))):
        content = faulty(content, rng) or b"\n"
    return content


def faulty(content: bytes, rng: np.random.Generator) -> bytes:
    """``content`` with one fault: torn, something put in, over, taken out, doubled, zeroed, flipped, made noise."""
    at, end = (int(k) for k in np.sort(rng.integers(0, len(content) + 1, 2)))
    token = TOKENS[int(rng.integers(len(TOKENS)))]
    before, between, after = content[:at], content[at:end], content[end:]
    flips = np.frombuffer(content, np.uint8) ^ np.where(rng.random(len(content)) * len(content) < 5, 1 << 6, 0)
    return [
        before,
        before + token + between + after,
        before + token + content[at + len(token) :],
        before + after,
        before + between + between + after,
        before + bytes(end - at) + after,
        before + rng.bytes(1) + content[at + 1 :],
        before + rng.bytes(end - at) + after,
        flips.astype(np.uint8).tobytes(),
    ][int(rng.integers(9))]


CROWDED = 10
"""Times that a machine with other work may be slower."""


def peak() -> float:
    """Highest resident memory so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def processor_time() -> float:
    """Seconds that this process and its ended children have worked, however busy the machine is."""
    spent = os.times()
    return spent.user + spent.system + spent.children_user + spent.children_system


def outcome(path: Path, options: dict[str, Any]) -> str:
    """ "read", "refused" or what went wrong."""
    try:
        result = read(path, **options)
    except SubgoalError:
        return "refused"
    except BaseException as problem:
        return f"{type(problem).__name__}: {problem}"
    finite = np.isfinite(result.states).all() and np.isfinite(result.actions).all()
    return "read" if isinstance(result, Demonstrations) and finite else f"wrong result {result!r}"


def fuzz(name: str, source: Path, options: dict[str, Any], count: int, seed: int, folder: Path) -> dict[str, Any]:
    """Read ``count`` broken copies of one file."""
    content, base = source.read_bytes(), peak()
    told: dict[str, Any] = {"format": name, "read": 0, "refused": 0, "slowest": 0.0, "failures": []}
    for k in range(count):
        path = folder / f"broken{source.suffix}"
        path.write_bytes(broken(content, np.random.default_rng([seed, k])))
        begin, worked = time.perf_counter(), processor_time()
        result = outcome(path, options)
        took = max(processor_time() - worked, (time.perf_counter() - begin) / CROWDED)
        told["slowest"] = max(told["slowest"], took)
        if took > 2:
            result = f"took {took:.1f} s ({result})"
        if peak() - base > 200:
            result, base = f"took {peak() - base:.0f} MB ({result})", peak()
        if result in told:
            told[result] += 1
        else:
            told["failures"].append(f"case {k}: {result[:300]}")
    return told


def main(count: int, seed: int) -> None:
    """Fuzz every format, after each was read once as it is."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as valid, tempfile.TemporaryDirectory() as folder:
        files = write_all(Path(valid))
        for name, (path, options) in files.items():
            if outcome(path, options) != "read":
                raise SystemExit(f"{name} as it is: {outcome(path, options)}")
        for name, (path, options) in files.items():
            print(json.dumps({"begin": name}), flush=True)
            share = max(1, count // 20) if path.suffix == ".h5" else count  # a process for each file
            print(json.dumps(fuzz(name, path, options, share, seed, Path(folder))), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
