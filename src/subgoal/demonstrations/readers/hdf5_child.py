"""Reads an HDF5 file in a process of its own: ``python -m subgoal.demonstrations.readers.hdf5_child PATH``.

The HDF5 library can crash, run for ever or take all memory on a damaged file. Here it may: this process sets itself
limits of time and memory, and writes what it found to the standard output as a NumPy archive, ready or not at all.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

SECONDS, BYTES_PER_SECOND = 1.2, 2e7
"""Wall time allowed, and what is added for each byte of the file."""
MEMORY, MEMORY_PER_BYTE = 2**27, 20
"""Bytes of memory allowed beyond the start, and what is added for each byte of the file."""
UNPACKED_PER_BYTE = 1000
"""A dataset larger than this many times its file, and than 1 MiB, is refused."""
SLEAP = ("tracks", "point_scores", "node_names", "track_names")
PANDAS = ("index", "values_block_0")


def limit(size: int) -> None:
    """Set the limits for a file of ``size`` bytes, as far as the system knows them."""
    try:
        import resource
        import signal

        with open("/proc/self/statm") as stream:
            now = int(stream.read().split()[0]) * resource.getpagesize()
        most = now + MEMORY + MEMORY_PER_BYTE * size
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_REAL, SECONDS + size / BYTES_PER_SECOND)
    except (ImportError, OSError, ValueError):
        return  # the caller's own limit of time still holds


def content(path: str) -> Iterator[tuple[str, Any]]:
    """Names and arrays: the datasets of SLEAP, or the first table that pandas wrote."""
    import h5py

    size = os.path.getsize(path)
    with h5py.File(path, "r", locking=False) as file:
        if "tracks" in file:
            for name in SLEAP:
                if isinstance(file.get(name), h5py.Dataset):
                    yield name, whole(file[name], size)
            return
        group = next((file[name] for name in file if isinstance(file[name], h5py.Group)), file)
        rows = whole(group["table"], size)
        yield "fields", np.array(rows.dtype.names, dtype=np.str_)
        for field in PANDAS:
            yield field, rows[field]
        yield "labels", np.frombuffer(bytes(group["table"].attrs["values_block_0_kind"]), np.uint8)


def whole(found: Any, size: int) -> Any:
    """A dataset as an array without objects."""
    if found.nbytes > max(2**20, UNPACKED_PER_BYTE * size):
        raise ValueError(f"{found.name} of {found.nbytes:,} bytes in a file of {size:,}")
    array = found[()]
    if array.dtype.hasobject:
        return np.array([n.decode("utf-8", "replace") if isinstance(n, bytes) else str(n) for n in array.ravel()])
    return array


def main(path: str) -> None:
    """Write the archive; a problem becomes its only array, "error"."""
    import h5py  # noqa: F401  (imported before the limits, which would count it)

    limit(os.path.getsize(path))
    out = io.BytesIO()
    try:
        np.savez(out, **dict(content(path)))
    except Exception as problem:
        out = io.BytesIO()
        np.savez(out, error=np.array(f"{type(problem).__name__}: {problem}"[:300]))
    sys.stdout.buffer.write(out.getvalue())
    sys.stdout.buffer.flush()
    os._exit(0)  # closing a damaged file may crash once more


if __name__ == "__main__":
    main(sys.argv[1])
