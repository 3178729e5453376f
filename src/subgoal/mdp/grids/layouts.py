"""Random walls that leave the free cells connected."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy import ndimage

from subgoal.runtime.checks import Bools, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

TRIES = 1_000


def random_walls(
    width: int,
    height: int,
    seed: int,
    *,
    segments: tuple[int, int] = (2, 4),
    keep_free: Iterable[tuple[int, int]] = (),
) -> Bools:
    """(height, width) booleans, True where free: a few straight walls, each with a gap, all free cells connected.

    Parameters
    ----------
    width, height:
        Cells, at least 4 each way.
    seed:
        The same seed gives the same walls.
    segments:
        Fewest and most walls.
    keep_free:
        Cells (x, y) that no wall may cover.

    Raises ``InputError`` for cells outside, and if no such layout is found in a thousand tries.
    """
    width, height = whole("width", width, least=4), whole("height", height, least=4)
    fewest, most = _pair("segments", segments)
    fewest, most = whole("segments", fewest, least=0), whole("segments", most, least=0)
    if not fewest <= most:
        raise InputError("segments", found=f"{segments}", wanted="the fewest, then the most")
    kept = np.zeros((height, width), bool)
    for cell in keep_free if isinstance(keep_free, Iterable) else [keep_free]:
        x, y = (whole("keep_free", number, least=0) for number in _pair("keep_free", cell))
        if not (x < width and y < height):
            raise InputError("keep_free", found=f"({x}, {y})", wanted=f"a cell of {width} × {height}")
        kept[y, x] = True
    generator = stream(seed, width, height)
    for _ in range(TRIES):
        free = np.ones((height, width), bool)
        for _ in range(int(generator.integers(fewest, most + 1))):
            _build(free, generator)
        if free[kept].all() and ndimage.label(free)[1] == 1:
            return free
    raise InputError("keep_free", found=f"no layout in {TRIES} tries", wanted="room for walls", hint="fewer segments")


def _pair(what: str, value: Any) -> tuple[Any, Any]:
    try:
        first, second = value
    except (TypeError, ValueError):
        raise InputError(what, found=repr(value), wanted="two whole numbers") from None
    return first, second


def _build(free: Bools, generator: np.random.Generator) -> None:
    """One wall of a third to three quarters of a side, upright or level, with a gap of one cell."""
    upright = bool(generator.integers(2))
    plane = free.T if upright else free
    rows, length = plane.shape
    row = int(generator.integers(1, rows - 1))
    size = int(generator.integers(-(-length // 3), 3 * length // 4 + 1))
    begin = int(generator.integers(0, length - size + 1))
    gap = begin + int(generator.integers(size))
    plane[row, begin : begin + size] = False
    plane[row, gap] = True
