"""Rows of numbers with room for more."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

FIRST_ROOM = 256


class Growing:
    """An array (n, ...) that takes one row more in constant time on average; it changes."""

    def __init__(self, *width: int, dtype: DTypeLike = float) -> None:
        self._room: NDArray[Any] = np.zeros((FIRST_ROOM, *width), dtype)
        self._size = 0

    def __len__(self) -> int:
        return self._size

    @property
    def rows(self) -> NDArray[Any]:
        """(n, ...) what is there, a view that may be written."""
        return self._room[: self._size]

    def extend(self, rows: Any) -> None:
        """Take (m, ...) rows more."""
        stop = self._size + len(rows)
        self._room = with_room(self._room, stop)
        self._room[self._size : stop] = rows
        self._size = stop


def with_room(array: NDArray[Any], *shape: int) -> NDArray[Any]:
    """``array``, or one twice as long in the leading axes that are shorter than ``shape``, zeros in what is new."""
    short = [size > have for size, have in zip(shape, array.shape, strict=False)]
    if not any(short):
        return array
    sizes = [
        max(size, 2 * have) if lacks else have for size, have, lacks in zip(shape, array.shape, short, strict=False)
    ]
    larger = np.zeros((*sizes, *array.shape[len(sizes) :]), array.dtype)
    larger[tuple(slice(size) for size in array.shape)] = array
    return larger
