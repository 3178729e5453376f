"""Parquet tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from subgoal.demonstrations.readers.columns import Treatment, assemble, choose
from subgoal.demonstrations.readers.files import check_unpacked, guarded, plain_file, source_of
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import ReadError


def read_parquet(
    path: Any,
    *,
    position: Sequence[str] | None = None,
    time: str | None = None,
    trajectory: str | None = None,
    action: Sequence[str] | None = None,
    group: str | None = None,
    likelihood: str | None = None,
    min_likelihood: float = 0.6,
    scale: float = 1.0,
    units: str = "",
    time_scale: float = 1.0,
    clock: str = "refuse",
    rate: float | None = None,
) -> Recording:
    """Read positions over time from a Parquet file; the options, result and errors are those of ``read_csv``."""
    how = Treatment(scale, units, time_scale, clock, min_likelihood, rate)
    path = plain_file(path)
    with guarded(path, "a Parquet table"):
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            choice = choose(path, file.schema_arrow.names, position, time, trajectory, action, likelihood, group)
            check_unpacked(path, "all rows", 8 * file.metadata.num_rows * len(choice.all), path.stat().st_size)
            columns = {name: _column(path, file, name) for name in choice.all}
    return assemble(path, columns, choice, how, source_of(path))


def _column(path: Path, file: Any, name: str) -> Any:
    """One column as a NumPy array. Raises ``ReadError`` if its cells are no single values."""
    import pyarrow.types as kinds

    kind = file.schema_arrow.field(name).type
    if kinds.is_nested(kind) or kinds.is_binary(kind):
        raise ReadError(str(path), where=f"column {name!r}", found=f"type {kind}", wanted="numbers or text")
    column = file.read(columns=[name]).column(0)
    if len(column) != file.metadata.num_rows:
        raise ReadError(str(path), where=f"column {name!r}", found=f"{len(column)} cells", wanted="one in each row")
    return column.to_pandas().to_numpy()
