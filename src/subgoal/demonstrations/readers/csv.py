"""CSV, TSV and spreadsheet exports."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from subgoal.demonstrations.readers.columns import Treatment, assemble, choose
from subgoal.demonstrations.readers.files import guarded, plain_file, source_of
from subgoal.demonstrations.readers.layout import Layout, find_layout
from subgoal.demonstrations.records import Recording


def read_csv(
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
    separator: str | None = None,
    decimal: str | None = None,
) -> Recording:
    """Read positions over time from a table of text.

    Parameters
    ----------
    path:
        The file. Comma, semicolon, tab, bar and blanks are found out, and so are a decimal comma, byte order
        marks, lines that begin with "#", and a missing header line (then columns are called "0", "1", ...).
    position:
        Columns of the place, in order. Default: x, y and, if there is one, z.
    time:
        Column of the time, numbers or ISO 8601 timestamps (seconds since the earliest). Default: t, time or
        timestamp if there is one; otherwise rows are numbered, and divided by ``rate`` if that is given.
    trajectory:
        Column whose value tells trajectories apart; their rows may be interleaved.
    action:
        Columns of recorded actions; without it velocities are computed later.
    group:
        Column that says which group (animal, driver, day) a row's trajectory belongs to: ``subgoal.models.Grouped``
        then gives each group weights of its own. All rows of a trajectory must have the same value.
    likelihood, min_likelihood:
        Column of a tracker's confidence; rows below the minimum are dropped.
    scale, units:
        Multiplier of the positions (metres per pixel) and the unit they are in afterwards.
    time_scale:
        Seconds per unit of the time column (0.001 for milliseconds).
    clock:
        Where times go back within a trajectory: "refuse", "sort", "split" or "drop".
    separator, decimal:
        Set these where they are found out wrongly.

    Returns
    -------
    Recording. Rows with an empty position, time, action or trajectory are dropped and counted in ``source.notes``.

    Raises
    ------
    ReadError
        The file is missing, is no such table, lacks a column, a cell is no finite number, or a trajectory has no
        group or two; names file and row.
    InputError
        An option is not what it should be.
    """
    how = Treatment(scale, units, time_scale, clock, min_likelihood, rate)
    path = plain_file(path)
    layout = find_layout(path, separator, decimal)
    choice = choose(path, layout.names, position, time, trajectory, action, likelihood, group)
    text = [name for name in (choice.trajectory, choice.group) if name is not None]
    columns = table(path, layout, choice.all, text)
    source = source_of(path).noting(file_was_not_UTF8_and_was_read_as_Latin1=int(layout.latin))
    return assemble(path, columns, choice, how, source)


def table(path: Path, layout: Layout, wanted: Sequence[str], text: Sequence[str] = ()) -> dict[str, Any]:
    """The ``wanted`` columns of a text table, each (M,); those in ``text`` are left as they are written."""
    import pandas as pd

    numbered = {layout.names.index(name): name for name in wanted}
    with guarded(path, "a table with as many cells in each row as in the first"), warnings.catch_warnings():
        warnings.simplefilter("error", pd.errors.ParserWarning)
        frame = pd.read_csv(
            path,
            sep=r"\s+" if layout.separator == " " else layout.separator,
            decimal=layout.decimal,
            encoding=layout.encoding,
            header=None,
            names=list(range(len(layout.names))),
            index_col=False,
            skiprows=layout.skip,
            dtype={k: str for k, name in numbered.items() if name in text},
            compression=None,
            low_memory=False,
        )
    return {name: frame[k].to_numpy() for k, name in numbered.items()}
