"""What a planted bug is."""

from __future__ import annotations

from typing import NamedTuple


class Bug(NamedTuple):
    """``right`` in ``file`` (below src/subgoal) replaced by ``wrong`` must fail ``test`` (below tests)."""

    name: str
    file: str
    right: str
    wrong: str
    test: str
