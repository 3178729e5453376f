"""Checkpoints: a run that was killed goes on where it was and gives the draws of an unbroken one."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from subgoal.posterior.posterior import Settings
from subgoal.runtime.errors import InputError, StorageError
from subgoal.storage.archive import previous, read_archive, write_archive

KIND = "checkpoint"
EVERY = 5.0
"""Seconds between checkpoints, at least."""
LARGEST_COST = 0.02
"""Share of the run time that writing checkpoints may take."""


class Resumable(Protocol):
    """A chain that can be put into arrays and its generator, and taken out again."""

    generator: np.random.Generator

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Everything but the generator."""

    def restore(self, held: Mapping[str, NDArray[Any]]) -> None:
        """Take the place of the chain whose ``arrays`` these are."""


class Checkpoint:
    """Writes the chains to one file now and then; the cost stays below 2 % of the run."""

    def __init__(self, path: Path, settings: Settings) -> None:
        if not path.parent.is_dir():
            raise InputError("checkpoint", found=f"{path} in no folder", wanted="a path in a folder that exists")
        self._path, self._settings = path, settings
        self._due = time.monotonic() + EVERY

    def write_if_due(self, records: Sequence[Resumable]) -> None:
        """Write when the last one is old enough."""
        if time.monotonic() >= self._due:
            begin = time.monotonic()
            try:
                self.write(records)
            except StorageError as problem:
                warnings.warn(f"no checkpoint was written: {problem}", stacklevel=2)
            end = time.monotonic()
            self._due = end + max(EVERY, (end - begin) / LARGEST_COST)

    def write(self, records: Sequence[Resumable]) -> None:
        """Write now."""
        arrays = {f"{k}/{name}": array for k, record in enumerate(records) for name, array in record.arrays().items()}
        generators = [record.generator.bit_generator.state for record in records]
        header = {"settings": asdict(self._settings), "generators": generators}
        write_archive(self._path, KIND, header, arrays, keep_previous=True)

    def restore(self, records: Sequence[Resumable]) -> str | None:
        """Bring the chains to where the newest whole checkpoint left them; a word on a torn one that was passed over.

        Raises ``StorageError`` when no whole checkpoint is there, or it belongs to other settings or data.
        """
        torn = None
        try:
            header, arrays = read_archive(self._path, KIND)
        except StorageError as problem:
            if not previous(self._path).exists():
                raise
            torn = f"{problem} The checkpoint before it was used"
            header, arrays = read_archive(previous(self._path), KIND)
        self._refuse_others(header["settings"])
        for k, record in enumerate(records):
            mark = f"{k}/"
            record.restore({name[len(mark) :]: array for name, array in arrays.items() if name.startswith(mark)})
            generator = np.random.PCG64()
            generator.state = header["generators"][k]
            record.generator = np.random.Generator(generator)
        return torn

    def remove(self) -> None:
        """Take the files away: the run is complete."""
        self._path.unlink(missing_ok=True)
        previous(self._path).unlink(missing_ok=True)

    def _refuse_others(self, found: dict[str, object]) -> None:
        for name, wanted in asdict(self._settings).items():
            if found.get(name) != wanted:
                raise StorageError(
                    f"checkpoint setting {name!r}", where=str(self._path), found=repr(found.get(name)),
                    wanted=repr(wanted), hint="resume with the settings and the data of the first run, or start anew",
                )  # fmt: skip
