"""Where one can be in a plane: square cells, free or not, out of maps in text, pictures or recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.files import guarded, plain_file
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.maps import TextMap
from subgoal.mdp.grids.samples import planar
from subgoal.runtime.checks import Bools, Floats, Ints, copied, frozen, positive, real_array
from subgoal.runtime.errors import BudgetError, InputError, ReadError

MOST_CELLS = 10_000_000
FINEST = 1e-9
"""A cell is at least this share of the largest coordinate, so that positions can tell cells apart."""
LEVELS = 2**16 - 1
"""Steps of brightness: levels of pictures of 1, 2, 4, 8 and 16 bits are whole numbers of them: thresholds are exact."""
FAR = 2.0**62
"""Cells further away are given as this one."""


@dataclass(frozen=True, eq=False, repr=False)
class Occupancy:
    """Square cells of a plane, free or not.

    Attributes
    ----------
    free:
        (height, width) booleans, ``free[y, x]``: where one can be.
    resolution:
        Length of a side of a cell, in the units of the positions.
    origin:
        (2,) the corner of cell (0, 0) that has the least x and y. Cell (x, y) is what lies from origin + (x, y) ·
        resolution up to, but not including, origin + (x + 1, y + 1) · resolution.
    y_down:
        Whether y grows downwards, as in the pixels of a picture. It only decides which direction is called N.

    Raises
    ------
    InputError
        Nothing free, a resolution that is not above 0 or too fine for the numbers of the positions.
    """

    free: Bools
    resolution: float = 1.0
    origin: Any = (0.0, 0.0)
    y_down: bool = False

    def __post_init__(self) -> None:
        free = copied("free", self.free)
        if free.dtype != bool or free.ndim != 2 or not free.any():
            found = f"{free.dtype} of shape {free.shape}"
            raise InputError("free", found=found, wanted="booleans (height, width), one at least True")
        resolution = positive("resolution", self.resolution)
        origin = real_array("origin", self.origin, ndim=1)
        if origin.size != 2:
            raise InputError("origin", found=f"{origin.size} numbers", wanted="2: x and y")
        largest = float(np.abs([origin, origin + np.array(free.shape[::-1]) * resolution]).max())
        if not resolution >= FINEST * largest:
            wanted = f"at least {FINEST:g} of the largest coordinate, {largest:g}"
            raise InputError("resolution", found=resolution, wanted=wanted)
        for name, value in (("free", frozen(free)), ("resolution", resolution), ("origin", origin)):
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        height, width = self.free.shape
        return f"Occupancy({width} × {height} cells of {self.resolution:g}, {int(self.free.sum())} free)"

    @classmethod
    def from_map(cls, drawn: TextMap, resolution: float = 1.0, origin: Any = (0.0, 0.0)) -> Occupancy:
        """A map in text, with its own sense of y.

        With ``origin`` (−0.5, −0.5) and ``resolution`` 1, positions that are whole numbers are those of its cells.
        """
        return cls(drawn.free, resolution, origin, drawn.origin == "upper")

    @classmethod
    def from_image(
        cls, path: Any, resolution: float, origin: Any = (0.0, 0.0), *, threshold: float = 0.5, y_down: bool = False
    ) -> Occupancy:
        """A picture, a pixel a cell; what is bright is free.

        Parameters
        ----------
        path:
            PNG, or another format that Pillow reads.
        resolution, origin:
            As in the class, for pixels as cells. The rows of a picture go downwards, so cell (0, 0) is the lower left
            pixel, and with ``y_down`` the upper left one.
        threshold:
            In (0, 1]: free is a pixel with a brightness (the mean of red, green and blue, times how opaque it is) of
            at least this; black is 0, white is 1. What is transparent counts as black. In maps of ROS the unknown is
            205/255 bright, so that 0.9 leaves what is known to be free.

        Raises
        ------
        ReadError
            The file is not there, no picture, or one whose pixels are not steps between black and white (floats, 32
            bits). ``InputError`` where nothing is free.
        """
        threshold = positive("threshold", threshold)
        if not threshold <= 1:
            raise InputError("threshold", found=threshold, wanted="a number above 0, at most 1")
        free = _brightness(path) >= threshold
        return cls(free if y_down else free[::-1], resolution, origin, y_down)

    @classmethod
    def around(cls, data: Any, resolution: float, *, margin: float = 0.0, y_down: bool = False) -> Occupancy:
        """Free cells all around a Recording or Demonstrations, ``margin`` more on every side, in their units.

        Edges of cells lie on multiples of the resolution. Raises ``BudgetError`` above ten million cells.
        """
        resolution, margin = positive("resolution", resolution), positive("margin", margin, zero=True)
        positions = planar(data)
        lower, upper = positions.min(axis=0) - margin, positions.max(axis=0) + margin
        with np.errstate(over="ignore"):
            sizes = np.floor((upper - lower) / resolution) + 2
        if not sizes.prod() <= MOST_CELLS:
            raise BudgetError("cells", needed=float(sizes.prod()), budget=MOST_CELLS, hint="a coarser resolution")
        origin = np.floor(lower / resolution) * resolution
        origin -= (origin > lower) * resolution
        width, height = (np.floor((upper - origin) / resolution) + 1).astype(int)
        return cls(np.ones((height, width), bool), resolution, origin, y_down)

    def cell_of(self, positions: Any) -> Ints:
        """(M, 2) the cell (x, y) of each position (M, 2); off the map it is a cell that is not there."""
        places = real_array("positions", positions, ndim=2)
        if places.shape[1] != 2:
            raise InputError("positions", found=f"shape {places.shape}", wanted="(M, 2)")
        with np.errstate(over="ignore"):
            steps = np.floor((places - self.origin) / self.resolution)
        return np.asarray(np.clip(steps, -FAR, FAR).astype(np.int64))

    def position_of(self, cells: Any) -> Floats:
        """(M, 2) the centre of each cell (M, 2), on the map or not."""
        return np.asarray(self.origin + (_whole(cells) + 0.5) * self.resolution)

    def on_map(self, cells: Any) -> Bools:
        """(M,) whether each cell (M, 2) is on the map."""
        return np.asarray(((_whole(cells) >= 0) & (cells < np.array(self.free.shape[::-1]))).all(axis=1))

    def is_free(self, cells: Any) -> Bools:
        """(M,) whether each cell (M, 2) is on the map and free."""
        inside = self.on_map(cells)
        x, y = np.where(inside[:, None], cells, 0).T
        return np.asarray(inside & self.free[y, x])

    def world(self, discount: float, **options: Any) -> GridWorld:
        """The free cells as a grid world whose states lie at their centres; ``options`` as of ``GridWorld``."""
        cells = np.argwhere(self.free)[:, ::-1]
        origin: Any = "upper" if self.y_down else "lower"
        return GridWorld(self.free, discount, origin=origin, coordinates=self.position_of(cells), **options)


def _brightness(path: Any) -> Floats:
    """(height, width) from 0, black, to 1, white; the first row is the uppermost."""
    from matplotlib.image import imread
    from PIL import Image

    place = plain_file(path)
    with guarded(place, "a picture"):
        with Image.open(place) as picture:
            mode = picture.mode
        if mode in ("I", "F"):
            wanted = "8 or 16 bits for a level"
            raise ReadError(str(path), found=f"pixels of kind {mode!r}", wanted=wanted, hint="save it as PNG")
        pixels = np.asarray(imread(place))
    scale = np.iinfo(pixels.dtype).max if pixels.dtype.kind in "iu" else 1
    levels = np.round(pixels.astype(float) * (LEVELS / scale))
    if levels.ndim == 2:
        return levels / LEVELS
    opaque = levels[..., 3] if levels.shape[2] == 4 else LEVELS
    return np.asarray(levels[..., :3].sum(axis=2) * opaque / (3 * LEVELS * LEVELS))


def _whole(cells: Any) -> Ints:
    array = np.asarray(cells)
    if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 2:
        found = f"{array.dtype} of shape {array.shape}"
        raise InputError("cells", found=found, wanted="integers (M, 2) of (x, y)")
    return array.astype(np.int64)
