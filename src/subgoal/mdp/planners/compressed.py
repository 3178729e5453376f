"""A transition table as the first-passage loops want it."""

from __future__ import annotations

from typing import Any, NamedTuple

from subgoal.runtime.checks import Floats, Ints


class CompressedRows(NamedTuple):
    """Rows without self-transitions, and predecessors; see ``compress_rows`` and ``find_predecessors``."""

    state_edge: Ints
    row_edge: Ints
    to: Any
    weight: Floats
    gain: Floats
    edge: Ints
    before: Any
