"""HDF5 files, opened only when h5py is there, and read only as far as their size is believable."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from subgoal.demonstrations.readers.files import check_unpacked, guarded
from subgoal.runtime.errors import MissingExtraError, ReadError

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"


@contextmanager
def hdf5(path: Path, wanted: str) -> Iterator[Any]:
    """The open file. Raises ``MissingExtraError`` without h5py, ``ReadError`` for whatever goes wrong inside."""
    try:
        import h5py
    except ImportError:
        raise MissingExtraError("h5py", "sleap") from None
    with guarded(path, wanted), h5py.File(path, "r", locking=False) as file:
        yield file


def dataset(path: Path, file: Any, name: str, ndim: int) -> Any:
    """A dataset of ``ndim`` dimensions of believable size. Raises ``ReadError`` if there is none such."""
    import h5py

    found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        listed = ", ".join(repr(key) for key in list(file)[:30])
        raise ReadError(str(path), where=f"dataset {name!r}", found=f"only {listed}", wanted="one of that name")
    if found.ndim != ndim:
        raise ReadError(str(path), where=f"dataset {name!r}", found=f"shape {found.shape}", wanted=f"{ndim} axes")
    check_unpacked(path, f"dataset {name!r}", int(found.nbytes), path.stat().st_size)
    return found


def holds_dataset(path: Path, name: str) -> bool:
    """Whether the file has something called ``name`` at its top."""
    with hdf5(path, "an HDF5 file") as file:
        return name in file
