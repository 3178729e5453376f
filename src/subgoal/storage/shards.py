"""Observations in many Parquet files and a JSON manifest: written as a stream, read a group of rows at a time."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import parquet

from subgoal.runtime.checks import whole
from subgoal.runtime.errors import InputError, StorageError

FORMAT = 1
KIND = "shards"
MANIFEST = "manifest.json"
BLOCK = 2**16
"""Rows to which one stream of random numbers belongs; every shard but the last holds whole blocks."""
ROWS = 2**22
GROUP_BYTES = 2**23
READ_BYTES = 2**22
WANTED = "a whole folder written by subgoal"
Columns = Mapping[str, tuple[str, int]]
"""Name of each column, its NumPy type, and how many numbers of it a row has."""


@dataclass(frozen=True)
class ShardFile:
    """One file: its name, rows, bytes and SHA-256."""

    name: str
    rows: int
    bytes: int
    sha256: str


@dataclass(frozen=True, eq=False, repr=False)
class ShardFiles:
    """A folder of shards as its manifest has it; ``head`` is what the writer had to say of them, ``content`` the
    SHA-256 of all numbers in order, which does not depend on how they are divided into files."""

    folder: Path
    columns: Columns
    head: Mapping[str, Any]
    files: tuple[ShardFile, ...]
    content: str

    @property
    def rows(self) -> int:
        """Rows of all files."""
        return sum(each.rows for each in self.files)

    @property
    def group(self) -> int:
        """Rows that are read at a time."""
        return group_rows(self.columns)


def group_rows(columns: Columns) -> int:
    """Rows of a group: a power of two, so that blocks are made of whole groups."""
    width = sum(np.dtype(kind).itemsize * count for kind, count in columns.values())
    return int(min(BLOCK, 2 ** int(np.log2(max(1, GROUP_BYTES // width)))))


class ShardWriter:
    """Writes rows as they come; the manifest is written last, so that an unfinished folder is none.

    Use it in a ``with`` statement. Raises ``InputError`` for a folder that holds shards already.
    """

    def __init__(self, folder: str | Path, columns: Columns, rows: int = ROWS) -> None:
        self.folder, self.columns, self.rows = Path(folder), columns, whole("rows", rows)
        if self.rows % BLOCK:
            raise InputError("rows", found=rows, wanted=f"a multiple of {BLOCK:,}, the rows of a block")
        self.folder.mkdir(parents=True, exist_ok=True)
        if (self.folder / MANIFEST).exists():
            raise InputError("folder", found=f"shards in {self.folder}", wanted="an empty folder", hint="another name")
        self.head: dict[str, Any] = {}
        self._group = group_rows(columns)
        self._waiting: list[dict[str, NDArray[Any]]] = []
        self._held = self._in_file = 0
        self._files: list[ShardFile] = []
        self._content = hashlib.sha256()
        self._sink: Any = None
        self._aside: Path | None = None

    def __enter__(self) -> ShardWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, _: TracebackType | None
    ) -> None:
        if kind is None:
            self._finish()
        elif self._aside is not None:
            self._sink.close()
            with contextlib.suppress(OSError):
                self._aside.unlink()

    @property
    def written(self) -> int:
        """Rows taken so far."""
        return sum(each.rows for each in self._files) + self._in_file + self._held

    def append(self, **arrays: NDArray[Any]) -> None:
        """Take rows: for each column an array (B,) or (B, width)."""
        part = {name: np.ascontiguousarray(arrays[name], dtype=kind) for name, (kind, _) in self.columns.items()}
        self._waiting.append(part)
        self._held += len(next(iter(part.values())))
        if self._held < self._group:
            return
        joined = {name: np.concatenate([each[name] for each in self._waiting]) for name in self.columns}
        whole_groups = self._held - self._held % self._group
        for start in range(0, whole_groups, self._group):
            self._write({name: values[start : start + self._group] for name, values in joined.items()})
        self._waiting = [{name: values[whole_groups:].copy() for name, values in joined.items()}]
        self._held -= whole_groups

    def _write(self, part: Mapping[str, NDArray[Any]]) -> None:
        for name in self.columns:
            self._content.update(part[name].data)
        schema = _schema(self.columns)
        if self._sink is None:
            self._aside = self.folder / f".shard.{secrets.token_hex(4)}"
            self._sink = parquet.ParquetWriter(
                self._aside,
                schema,
                compression="none",
                use_dictionary=False,
                write_statistics=False,
                write_page_checksum=True,
            )
        arrays = [_packed(part[name], schema.field(name).type) for name in self.columns]
        self._sink.write_table(pa.Table.from_arrays(arrays, schema=schema), row_group_size=self._group)
        self._in_file += len(arrays[0])
        if self._in_file >= self.rows:
            self._close_file()

    def _close_file(self) -> None:
        if self._sink is None or self._aside is None:
            return
        self._sink.close()
        name = f"shard-{len(self._files):05d}.parquet"
        self._files.append(ShardFile(name, self._in_file, self._aside.stat().st_size, file_digest(self._aside)))
        self._aside.replace(self.folder / name)
        self._sink, self._aside, self._in_file = None, None, 0

    def _finish(self) -> None:
        if self._held:
            self._write({name: np.concatenate([each[name] for each in self._waiting]) for name in self.columns})
            self._waiting, self._held = [], 0
        self._close_file()
        if not self._files:
            raise InputError("shards", found="no rows", wanted="at least one observation")
        said = {
            "kind": KIND, "format": FORMAT, "columns": {k: list(v) for k, v in self.columns.items()},
            "head": self.head, "files": [asdict(each) for each in self._files], "content": self._content.hexdigest(),
        }  # fmt: skip
        text = json.dumps(said | {"seal": _seal(said)}, indent=1)
        aside = self.folder / f".{MANIFEST}.{secrets.token_hex(4)}"
        aside.write_text(text, encoding="utf-8")
        os.replace(aside, self.folder / MANIFEST)


def open_files(folder: str | Path, *, verify: bool = True) -> ShardFiles:
    """The shards of a folder. ``verify`` reads every file to compare its checksum; sizes are compared always.

    Raises ``StorageError`` for a missing, torn or changed file and for a manifest of another kind or version.
    """
    folder = Path(folder)
    path = folder / MANIFEST
    try:
        said = json.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise _torn(path, "no manifest" if isinstance(problem, FileNotFoundError) else str(problem)) from None
    except (ValueError, RecursionError) as problem:
        raise _torn(path, f"a torn manifest ({problem})") from None
    if not isinstance(said, dict) or said.get("kind") != KIND or said.get("format") != FORMAT:
        kind, version = (said.get("kind"), said.get("format")) if isinstance(said, dict) else (None, None)
        raise StorageError("shards", where=str(path), found=f"kind {kind!r}, format {version!r}",
                           wanted=f"kind {KIND!r}, format {FORMAT}")  # fmt: skip
    if said.pop("seal", None) != _seal(said):
        raise _torn(path, "a manifest that was changed")
    files = tuple(ShardFile(**each) for each in said["files"])
    for each in files:
        _check(folder / each.name, each, verify)
    columns = {name: (kind, count) for name, (kind, count) in said["columns"].items()}
    return ShardFiles(folder, columns, said["head"], files, said["content"])


def read_groups(
    path: Path, columns: Columns, wanted: tuple[str, ...], groups: range
) -> Iterator[dict[str, NDArray[Any]]]:
    """Arrays (B,) or (B, width) of the ``wanted`` columns, a group of rows at a time.

    Raises ``StorageError`` for a file that cannot be read as what its manifest says.
    """
    try:
        with parquet.ParquetFile(path, page_checksum_verification=True) as file:
            for k in groups:
                table = file.read_row_group(k, columns=list(wanted), use_threads=False)
                yield {name: _unpacked(table.column(name), *columns[name]) for name in wanted}
    except (OSError, pa.ArrowException, KeyError, IndexError, ValueError) as problem:
        raise _torn(path, f"a torn or changed file ({type(problem).__name__}: {problem})") from None


def file_digest(path: Path) -> str:
    """SHA-256 of a file, read in parts."""
    seal = hashlib.sha256()
    with path.open("rb") as stream:
        while part := stream.read(READ_BYTES):
            seal.update(part)
    return seal.hexdigest()


def _check(path: Path, told: ShardFile, verify: bool) -> None:
    if not path.is_file():
        raise _torn(path, "no such file", f"the file of {told.rows:,} rows that the manifest names")
    if path.stat().st_size != told.bytes:
        raise _torn(path, f"{path.stat().st_size:,} bytes", f"{told.bytes:,} bytes")
    if verify and file_digest(path) != told.sha256:
        raise _torn(path, "a wrong checksum", "the one it was written with")


def _torn(path: Path, found: str, wanted: str = WANTED) -> StorageError:
    return StorageError("shards", where=str(path), found=found, wanted=wanted, hint="write the shards again")


def _seal(said: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()


def _schema(columns: Columns) -> Any:
    def kind(dtype: str, count: int) -> Any:
        return pa.from_numpy_dtype(dtype) if count == 1 else pa.binary(np.dtype(dtype).itemsize * count)

    return pa.schema([pa.field(name, kind(*told), nullable=False) for name, told in columns.items()])


def _packed(values: NDArray[Any], kind: Any) -> Any:
    if values.ndim == 1:
        return pa.array(values, type=kind)
    return pa.FixedSizeBinaryArray.from_buffers(kind, len(values), [None, pa.py_buffer(np.ascontiguousarray(values))])


def _unpacked(column: Any, dtype: str, count: int) -> NDArray[Any]:
    array = column.combine_chunks()
    array = array.chunk(0) if isinstance(array, pa.ChunkedArray) else array
    if count == 1:
        return np.asarray(array.to_numpy(zero_copy_only=False), dtype)
    flat = np.frombuffer(array.buffers()[1], dtype, offset=array.offset * array.type.byte_width)
    return flat[: len(array) * count].reshape(len(array), count)
