"""Positions in cells: the grid world around a recording or of a map, and planning in it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from subgoal.runtime.errors import BudgetError, InputError

if TYPE_CHECKING:
    from subgoal.likelihood.table import LogLikelihood

CELLS_ACROSS = 20
"""Cells along the longer side, where no size is given."""
NOT_OF_CELLS = ("start_within", "every", "velocity", "window")
PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff")


def gridded(
    file: Path, reading: dict[str, Any], box: Any, cell: float | None, moves: int, discount: float | None, *,
    map_file: Path | None = None, corner: Any = None, y_down: bool = False, confidence: float = 10.0,
) -> tuple[Any, Any, float]:  # fmt: skip
    """The grid world of a recording, the recording in it without standing still, and the side of a cell.

    Without a map all cells around the recording are free. Without a discount it is the one at which a subgoal is felt
    from one end of the world to the other.
    """
    from subgoal.demonstrations.read import look
    from subgoal.demonstrations.recordings import starting_within
    from subgoal.mdp import Occupancy, discount_for, to_cells
    from subgoal.mdp.grids.samples import planar
    from subgoal.runtime.checks import positive

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
        across = max(2, max(occupancy.free.shape))
        gamma = discount_for(across, confidence) if discount is None else discount
        made = to_cells(recording, occupancy, discount=gamma, moves=moves, staying="drop")
    except BudgetError as problem:
        raise InputError("--cell", found=f"{side:g}", wanted=f"larger cells: {problem}") from None
    except InputError as problem:
        if "no trajectory left" not in str(problem):
            raise
        wanted = f"cells that something moves between; positions span {extent:g}"
        raise InputError("--cell", found=f"{side:g}", wanted=wanted, hint="a smaller --cell") from None
    return *made, occupancy.resolution


def _map(file: Path, cell: float | None, corner: Any, y_down: bool) -> Any:
    """A picture, bright where one can be, or a map in text."""
    from subgoal.mdp import Occupancy, read_map

    side, origin = 1.0 if cell is None else cell, (0.0, 0.0) if corner is None else corner
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
        planner = partial(rtdp_subgoals, cache=folder / ".plans", backend=backend)
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
    from subgoal.cli.learn import learn_table
    from subgoal.likelihood.planned_actions import DEFAULT_CONFIDENCE

    _refuse_others(reading, places, metric, table)
    fixed = table["confidence"] is not None
    confidence = table["confidence"] if fixed else DEFAULT_CONFIDENCE
    box = reading.get("start_within")
    kept = {name: value for name, value in reading.items() if name not in NOT_OF_CELLS}
    grid, demonstrations, _ = gridded(
        file, kept, box, world.pop("cell", None), world.pop("moves"), world.pop("discount", None), y_down=y_down,
        confidence=confidence, **world,
    )  # fmt: skip
    with output_folder(out) as folder:
        likelihood = planned_likelihood(
            grid, demonstrations, epsilon=places.get("epsilon"), confidence=confidence, run=run, folder=folder,
            quiet=quiet,
        )  # fmt: skip
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
