"""``subgoal report``: tables, pictures and page made again from a saved posterior."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from subgoal.cli import options as o


def report(
    folder: Annotated[Path, typer.Argument(help="Folder that subgoal learn wrote (with posterior.npz in it).")],
    merge_radius: o.MergedAsBefore = None,
    y_down: Annotated[bool | None, typer.Option(help="Draw y downwards; default: as before.")] = None,
    sensitivity: o.Sensitivity = False,
    sweep: o.Sweep = False,
    quiet: o.Quiet = False,
) -> None:
    """Make the tables, pictures and report.html of a folder again, for example with another merge radius.

    Example:

      subgoal report out/ --merge-radius 0.5
    """
    from subgoal.cli.gridding import kept_world
    from subgoal.cli.table import print_results
    from subgoal.cli.write import write
    from subgoal.posterior.archive import load
    from subgoal.reporting.results import drawn_downwards, merged_within

    posterior = load(folder / "posterior.npz", mdp=kept_world(folder))
    y_down = drawn_downwards(folder) if y_down is None else y_down
    merge_radius = merged_within(folder) if merge_radius is None else merge_radius
    results = write(
        posterior, folder, merge_radius=merge_radius, y_down=y_down, sensitive=sensitivity, swept=sweep, quiet=quiet
    )  # fmt: skip
    if not quiet:
        print_results(posterior, results, folder)
