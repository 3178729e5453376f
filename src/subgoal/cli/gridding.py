"""Positions in cells: the grid world around a recording or of a map, and planning in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from subgoal.runtime.errors import BudgetError, InputError, StoppedError

if TYPE_CHECKING:
    from subgoal.likelihood.table import LogLikelihood

CELLS_ACROSS = 20
"""Cells along the longer side, where no size is given."""
KIND = "grid world"
PLANS, WORLD = ".plans", ".world.npz"
"""Where plans and the world are kept in the folder of the results."""
NOT_OF_CELLS = ("start_within", "every", "velocity", "window")
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff")


def gridded(
    file: Path, reading: dict[str, Any], box: Any, cell: float | None, moves: int, discount: float | None, *,
    map_file: Path | None = None, corner: Any = None, y_down: bool = False, confidence: float = 10.0,
    outside: Any = "raise", quiet: bool = True,
) -> tuple[Any, Any, float]:  # fmt: skip
    """The grid world of a recording, the recording in it without standing still, and the side of a cell.

    Without a map all cells around the recording are free. Without a discount it is the one at which a subgoal is felt
    from one end of the world to the other.
    """
    from subgoal.demonstrations.read import look
    from subgoal.demonstrations.recordings import starting_within
    from subgoal.mdp import Occupancy, discount_for, to_cells
    from subgoal.mdp.grids.occupancy import MOST_CELLS
    from subgoal.mdp.grids.samples import planar
    from subgoal.runtime.checks import positive

    if map_file is None and corner is not None:
        raise InputError("--map-corner", found="given", wanted="--map beside it")
    if map_file is not None and cell is None:
        raise InputError("--cell", found="none", wanted="the side of a pixel of --map, in units of the positions")
    if outside not in ("raise", "drop"):
        raise InputError("--outside", found=repr(outside), wanted="raise or drop")
    if discount is not None and not 0 <= discount < 1:
        raise InputError("--discount", found=discount, wanted="at least 0 and below 1")
    recording: Any = look(file, **reading)
    if box is not None:
        recording = starting_within(recording, box)
    positions = planar(recording)
    extent = float((positions.max(axis=0) - positions.min(axis=0)).max())
    side = positive("--cell", extent / CELLS_ACROSS if cell is None and extent > 0 else 1.0 if cell is None else cell)
    try:
        if map_file is None:
            occupancy = Occupancy.around(recording, side, y_down=y_down)
        else:
            occupancy = _map(map_file, cell, corner, y_down)
        if not quiet and map_file is not None:
            print(f"map: {told_extent(occupancy)}")
        across = max(2, max(occupancy.free.shape))
        gamma = discount_for(across, confidence) if discount is None else discount
        made = to_cells(recording, occupancy, discount=gamma, moves=moves, staying="drop", outside=outside)
    except BudgetError:
        raise InputError("--cell", found=f"{side:g}", wanted=f"larger cells: {MOST_CELLS:,} at most") from None
    except InputError as problem:
        if "no trajectory left" not in str(problem):
            raise
        wanted = f"cells that something moves between; positions span {extent:g}"
        raise InputError("--cell", found=f"{side:g}", wanted=wanted, hint="a smaller --cell") from None
    return *made, occupancy.resolution


def told_extent(occupancy: Any) -> str:
    """Where a map lies, in words, so that a corner that is not right shows."""
    low, high = occupancy.origin, occupancy.origin + occupancy.resolution * np.array(occupancy.free.shape[::-1])
    free = f"{occupancy.free.sum():,} of {occupancy.free.size:,} cells free"
    return f"x of {low[0]:g} to {high[0]:g}, y of {low[1]:g} to {high[1]:g}, {free}"


def _map(file: Path, cell: Any, corner: Any, y_down: bool) -> Any:
    """A picture, bright where one can be, or a map in text."""
    from subgoal.mdp import Occupancy, read_map

    side, origin = cell, (0.0, 0.0) if corner is None else corner
    if file.suffix.lower() in PICTURES:
        return Occupancy.from_image(file, side, origin, y_down=y_down)
    return Occupancy.from_map(read_map(file), side, origin)


def planned_likelihood(
    world: Any, demonstrations: Any, *, epsilon: float | None, confidence: float, run: dict[str, Any], folder: Path,
    quiet: bool,
) -> LogLikelihood:  # fmt: skip
    """The table of planned actions, for an ε-net of the visited cells; plans in envelopes are kept in ``folder``."""
    from functools import partial

    from subgoal.candidates import epsilon_net
    from subgoal.likelihood.planned_actions import planned_actions
    from subgoal.likelihood.planners import SMALL_GRID
    from subgoal.mdp import plan_subgoals, rtdp_subgoals
    from subgoal.runtime.progress import progress_display

    candidates = epsilon_net(demonstrations, epsilon)
    large = world.n_states > SMALL_GRID
    backend = run.get("backend", "threading")
    planner: Any = partial(plan_subgoals, backend=backend)
    if large:
        planner = partial(rtdp_subgoals, cache=folder / PLANS, backend=backend)
    if not quiet:
        print(f"{world.n_states:,} cells, discount {world.discount:.6g}, {demonstrations.n_observations:,} decisions, "
              f"{candidates.n_candidates} candidates")  # fmt: skip
    likelihood = planned_actions(
        demonstrations, candidates, world, confidence=confidence, planner=planner, workers=run.get("workers"),
        progress=progress_display("planning", quiet=quiet),
    )  # fmt: skip
    if not quiet:
        print(f"planned by {likelihood.planner}")
    return likelihood


def learn_in_cells(
    file: Path, out: Path, reading: dict[str, Any], places: dict[str, Any], metric: dict[str, Any],
    table: dict[str, Any], run: dict[str, Any], world: dict[str, Any], *, y_down: bool, quiet: bool, **how: Any,
) -> None:  # fmt: skip
    """``learn --likelihood grid``: as ``learn_file``, with actions planned in the cells of a grid world."""
    from subgoal.cli.compose import output_folder
    from subgoal.cli.pipeline import CHECKPOINT, learn_table
    from subgoal.likelihood.planned_actions import DEFAULT_CONFIDENCE

    _refuse_others(reading, places, metric, table)
    fixed = table["confidence"] is not None
    confidence = table["confidence"] if fixed else DEFAULT_CONFIDENCE
    box = reading.get("start_within")
    kept = {name: value for name, value in reading.items() if name not in NOT_OF_CELLS}
    grid, demonstrations, _ = gridded(
        file, kept, box, world.pop("cell", None), world.pop("moves"), world.pop("discount", None), y_down=y_down,
        confidence=confidence, quiet=quiet, **world,
    )  # fmt: skip
    with output_folder(out) as folder:
        if run.get("resume") and not (folder / CHECKPOINT).exists():
            run = run | {"resume": False}
        try:
            likelihood = planned_likelihood(
                grid, demonstrations, epsilon=places.get("epsilon"), confidence=confidence, run=run, folder=folder,
                quiet=quiet,
            )  # fmt: skip
        except KeyboardInterrupt:
            where = f"; what was planned is kept in {folder / PLANS}" if (folder / PLANS).exists() else ""
            raise StoppedError(f"stopped while planning{where}, and the same command goes on") from None
        keep_world(folder, grid)
        learn_table(likelihood, folder, run, y_down=y_down, quiet=quiet, fixed=fixed, grouped="group" in reading, **how)


def _refuse_others(
    reading: dict[str, Any], places: dict[str, Any], metric: dict[str, Any], table: dict[str, Any]
) -> None:
    """Raise ``InputError`` for what only a comparison of directions can use."""
    given = {"--action": reading.get("action"), "--thin-radius": reading.get("thin"), "--gain": table["gain"],
             "--speed-limit": table["speed_limit"], "--weights": metric["weights"], "--period": metric["period"],
             "--candidates": places.get("file"), "--grid": places.get("grid")}  # fmt: skip
    told = [name for name, value in given.items() if value is not None]
    told += ["--controller"] if table["controller"] != "direction" else []
    told += ["--every"] if reading.get("every", 1) != 1 else []
    if told:
        wanted = "none of them beside --likelihood grid, where steps between cells are the actions"
        raise InputError(" and ".join(told), found="given", wanted=wanted)


def keep_world(folder: Path, grid: Any) -> None:
    """Write the grid world beside the results, so that a report can be made again."""
    from subgoal.storage.archive import write_archive

    header = {"discount": grid.discount, "moves": grid.moves, "origin": grid.origin, "shape": list(grid.free.shape)}
    arrays = {"free": np.packbits(grid.free), "coordinates": grid.coordinates}
    write_archive(folder / WORLD, KIND, header, arrays, keep_previous=False)


def kept_world(folder: Path) -> Any:
    """The grid world that ``keep_world`` wrote, or None."""
    from subgoal.mdp import GridWorld
    from subgoal.storage.archive import read_archive

    if not (folder / WORLD).exists():
        return None
    header, arrays = read_archive(folder / WORLD, KIND)
    height, width = header["shape"]
    free = np.unpackbits(arrays["free"], count=height * width).reshape(height, width).astype(bool)
    return GridWorld(
        free, header["discount"], moves=header["moves"], origin=header["origin"], coordinates=arrays["coordinates"]
    )
