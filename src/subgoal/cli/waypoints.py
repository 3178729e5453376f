"""``subgoal waypoints``: the subgoals of a folder of results as waypoints for a vehicle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from subgoal.cli import options as o

if TYPE_CHECKING:
    from subgoal.answers.subgoals import Subgoals
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
Metres = Annotated[float | None, typer.Option("--scale", help="Metres per unit of the positions.")]
TABLES = (".csv", ".json")


def waypoints(
    folder: Folder,
    out: Annotated[Path, typer.Option("--out", "-o", help="File: .csv, .json, or .mcap, .db3, .bag for ROS.")],
    cyclic: Cyclic = None,
    visits: Visits = False,
    dwell: Dwell = 0.0,
    least_share: LeastShare = 0.05,
    merge_radius: o.MergedAsBefore = None,
    frame: Annotated[str | None, typer.Option(help="Frame of the path, for ROS; default: map.")] = None,
    plane: AnyPlane = None,
    height: Annotated[
        float | None, typer.Option(help="Metres above the origin, for a horizontal plane; default 1.")
    ] = None,
    scale: Metres = None,
    quiet: o.Quiet = False,
) -> None:
    """Write the subgoals as waypoints, in the order in which they were first gone to.

    A .csv keeps neither where to begin nor whether the first comes again; a .json keeps everything.

    Example:

      subgoal waypoints out/ --out out/waypoints.csv
    """
    from subgoal.flight import waypoints as ordered
    from subgoal.flight import write_waypoints

    given = {"frame": frame, "plane": plane, "height": height, "scale": scale}
    for_ros: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    _refuse_of_tables(out, for_ros)
    posterior, found = learned_in(folder, merge_radius)
    made = ordered(posterior, found=found, cyclic=cyclic, dwell=dwell, least_share=least_share, visits=visits)
    written = write_waypoints(made, out, **for_ros)
    if not quiet:
        print(told(made))
        print(f"Written to {written}")


def _refuse_of_tables(out: Path, for_ros: dict[str, Any]) -> None:
    """``InputError`` for options that say where a path for ROS lies, beside a file that is none."""
    from subgoal.runtime.errors import InputError

    if for_ros and out.suffix in TABLES:
        told = " and ".join(f"--{name}" for name in for_ros)
        raise InputError(told, found="given", wanted=f"none beside {out.suffix}, which keeps places as they are",
                         hint="a name that ends in .mcap, .db3 or .bag")  # fmt: skip


def learned_in(folder: Path, merge_radius: float | None) -> tuple[Posterior, Subgoals]:
    """What ``subgoal learn`` left, and its subgoals, merged as there unless another radius is given.

    Raises ``InputError`` where it left nothing.
    """
    from subgoal.answers.subgoals import subgoals
    from subgoal.posterior.archive import load
    from subgoal.reporting.results import merged_within
    from subgoal.runtime.errors import InputError

    if not (folder / "posterior.npz").is_file():
        found = "a file" if folder.is_file() else "no posterior.npz in it" if folder.is_dir() else "no such folder"
        raise InputError("folder", where=str(folder), found=found, wanted="a folder with posterior.npz",
                         hint="subgoal learn FILE --out FOLDER first")  # fmt: skip
    posterior = load(folder / "posterior.npz")
    return posterior, subgoals(posterior, merge_radius=merged_within(folder) if merge_radius is None else merge_radius)


def told(made: Waypoints) -> str:
    """The order in words, and what to know."""
    from subgoal.plots.words import counted

    order = " → ".join(str(label) for label in made.labels[:MOST_TOLD]) + (" → …" if len(made) > MOST_TOLD else "")
    again = ", and round again" if made.cyclic else ""
    return "\n".join([f"{counted(len(made), 'waypoint')}, by number of the subgoal: {order}{again}", *made.notes])
