"""``subgoal waypoints``: the subgoals of a folder of results as waypoints for a vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from subgoal.cli import options as o

if TYPE_CHECKING:
    from subgoal.flight import Waypoints
    from subgoal.posterior.posterior import Posterior

MOST_TOLD = 20
Folder = Annotated[Path, typer.Argument(help="Folder that subgoal learn wrote (with posterior.npz in it).")]
Cyclic = Annotated[
    bool | None,
    typer.Option("--cyclic/--one-pass", help="Whether the first comes again after the last; default: as demonstrated."),
]
Visits = Annotated[
    bool, typer.Option("--visits", help="Every subgoal each time it was gone to, and not once in a round.")
]
Dwell = Annotated[float, typer.Option(help="Seconds to stay at each.")]
LeastShare = Annotated[float, typer.Option(help="Subgoals with at least this share of the observations.")]
AnyPlane = Annotated[
    str | None, typer.Option(help="Plane of the world for two positions, e.g. yz; default: their names, or xy.")
]
Height = Annotated[float, typer.Option(help="Metres above the origin, for a horizontal plane.")]
Metres = Annotated[float | None, typer.Option("--scale", help="Metres per unit of the positions.")]


def waypoints(
    folder: Folder,
    out: Annotated[Path, typer.Option("--out", "-o", help="File: .csv, .json, or .mcap, .db3, .bag for ROS.")],
    cyclic: Cyclic = None,
    visits: Visits = False,
    dwell: Dwell = 0.0,
    least_share: LeastShare = 0.05,
    merge_radius: Annotated[float | None, typer.Option(help="Places within it are one subgoal; default 5ε.")] = None,
    frame: Annotated[str, typer.Option(help="Frame of the path, for ROS.")] = "map",
    plane: AnyPlane = None,
    height: Height = 1.0,
    scale: Metres = None,
    quiet: o.Quiet = False,
) -> None:
    """Write the subgoals as waypoints, in the order in which they were first gone to.

    Example:

      subgoal waypoints out/ --out out/waypoints.csv
    """
    from subgoal.answers.subgoals import subgoals
    from subgoal.flight import waypoints as ordered
    from subgoal.flight import write_waypoints

    posterior = learned_in(folder)
    found = subgoals(posterior, merge_radius=merge_radius)
    made = ordered(posterior, found=found, cyclic=cyclic, dwell=dwell, least_share=least_share, visits=visits)
    written = write_waypoints(made, out, frame=frame, plane=plane, height=height, scale=scale)
    if not quiet:
        print(told(made))
        print(f"Written to {written}")


def learned_in(folder: Path) -> Posterior:
    """The posterior that ``subgoal learn`` left; raises ``InputError`` where it did not."""
    from subgoal.posterior.archive import load
    from subgoal.runtime.errors import InputError

    if not (folder / "posterior.npz").is_file():
        found = "a file" if folder.is_file() else "no posterior.npz in it" if folder.is_dir() else "no such folder"
        raise InputError("folder", where=str(folder), found=found, wanted="a folder with posterior.npz",
                         hint="subgoal learn FILE --out FOLDER first")  # fmt: skip
    return load(folder / "posterior.npz")


def told(made: Waypoints) -> str:
    """The order in words."""
    from subgoal.plots.words import counted

    order = " → ".join(str(label) for label in made.labels[:MOST_TOLD]) + (" → …" if len(made) > MOST_TOLD else "")
    again = ", and round again" if made.cyclic else ""
    return f"{counted(len(made), 'waypoint')}, by number of the subgoal: {order}{again}"
