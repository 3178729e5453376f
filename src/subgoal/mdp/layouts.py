"""Random walls that leave the free cells connected."""

from __future__ import annotations

from collections.abc import Iterable

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
    fewest, most = whole("segments", segments[0], least=0), whole("segments", segments[1], least=0)
    if not fewest <= most:
        raise InputError("segments", found=f"{segments}", wanted="the fewest, then the most")
    kept = np.zeros((height, width), bool)
    for x, y in keep_free:
        if not (0 <= x < width and 0 <= y < height):
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
