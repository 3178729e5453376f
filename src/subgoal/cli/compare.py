"""``subgoal compare``: several accounts of one recording, scored on what they have not seen."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from subgoal.cli import options as o
from subgoal.runtime.errors import StoppedError

if TYPE_CHECKING:
    from subgoal.irl.compare import Comparison

PRINTED_WIDTH = 110


def compare(
    file: o.File,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("out"),
    cell: o.Cell = None,
    moves: o.Moves = 4,
    discount: Annotated[float, typer.Option(help="γ of the world.", rich_help_panel=o.WORLD)] = 0.95,
    methods: Annotated[
        str | None,
        typer.Option(
            "--methods",
            "-m",
            help="bnirl, bnirl-persistent, bayesian (minutes), entropy, apprenticeship, "
            "margin; floors are always there. Default: all but bayesian.",
        ),
    ] = None,
    folds: Annotated[int | None, typer.Option(help="Of whole trajectories; default 5.")] = None,
    seed: Annotated[int, typer.Option("--seed", "-s")] = 0,
    y_down: Annotated[bool, typer.Option(help="Draw y downwards, as in images.")] = False,
    quiet: o.Quiet = False,
    format: o.Format = None,
    position: o.Position = None,
    time: o.Time = None,
    trajectory: o.Trajectory = None,
    time_scale: o.TimeScale = None,
    scale: o.Scale = None,
    units: o.Units = None,
    clock: o.Clock = None,
    likelihood: o.Likelihood = None,
    min_likelihood: o.MinLikelihood = None,
    bodypart: o.Bodypart = None,
    topic: o.Topic = None,
    frame: o.Frame = None,
    start_within: o.StartWithin = None,
    rate: o.Rate = None,
    max_gap: o.MaxGap = None,
    separator: o.Separator = None,
    decimal: o.Decimal = None,
) -> None:
    """Is one reward enough? Grid the recording, fit subgoals and single rewards, score both on unseen trajectories.

    Prints a table (bits per decision, share wrong, size, time) and writes comparison.csv, comparison.png and a report
    of the subgoals with the comparison in it.

    Examples:

      subgoal compare tracks.csv --trajectory id --cell 0.5 --out out/

      subgoal compare tracks.csv --methods bnirl,entropy --folds 10
    """  # fmt: skip
    reading = o.given(
        format=format, position=o.words(position), time=time, trajectory=trajectory, time_scale=time_scale,
        scale=scale, units=units, clock=clock, likelihood=likelihood, min_likelihood=min_likelihood,
        bodypart=bodypart, rate=rate, max_gap=max_gap, separator=separator, decimal=decimal, topic=topic,
        frame=frame,
    )  # fmt: skip
    from rich.console import Console

    from subgoal.cli.compose import output_folder
    from subgoal.cli.gridding import gridded
    from subgoal.cli.table import print_notes
    from subgoal.irl import compare as comparing
    from subgoal.irl.rivals import lasting_posterior, merge_radius
    from subgoal.plots.comparison import comparison_words, one_reward_words
    from subgoal.reporting.results import write_results
    from subgoal.runtime.progress import progress_display

    world, demonstrations, side = gridded(
        file, reading, o.intervals("--start-within", start_within), cell, moves, discount
    )
    if not quiet:
        told = f"{world.n_states} cells, {demonstrations.n_observations} decisions in"
        print(f"{told} {demonstrations.n_trajectories} trajectories")
        print_notes(demonstrations, Console(highlight=False))
    with output_folder(out) as folder:
        found = comparing.compare(
            demonstrations, world.mdp, methods=o.words(methods), folds=folds, seed=seed,
            progress=progress_display("comparing", quiet=quiet, even=False),
        )  # fmt: skip
        told = f"Cells of {side:.4g} {demonstrations.units}".rstrip() + f", {moves} directions, discount {discount:g}"
        found = replace(found, setting=f"{told}; subgoals in this report: BNIRL with lasting subgoals, confidence 10")
        posterior = lasting_posterior(demonstrations, world.mdp, seed)
        merged = merge_radius(demonstrations, world.mdp)
        write_results(posterior, folder, merge_radius=merged, y_down=y_down, comparison=found)
    if not quiet:
        print_comparison(found)
        print(f"{one_reward_words(found)}\n{comparison_words(found)}")
        print(f"Look at {out / 'report.html'}")
    if found.unfinished:
        raise StoppedError(f"stopped before {', '.join(found.unfinished)}; the others stand in {out}")


def print_comparison(found: Comparison) -> None:
    """One table; plain text when not on a terminal."""
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, width=None if sys.stdout.isatty() else PRINTED_WIDTH)
    table = Table(box=None, pad_edge=False)
    table.add_column("method", no_wrap=True)
    for heading in ("bits/decision ± s.e.", "wrong", "size", "seconds", "converged"):
        table.add_column(heading, justify="right")
    for each in found.methods:
        done, folds = each.converged
        table.add_row(
            each.name, f"{each.bits_per_decision:.3f} ± {each.standard_error:.3f}", f"{each.loss:.1%}",
            f"{each.size:.0f} {each.unit}" if each.unit else "–", f"{each.seconds:.1f}", f"{done}/{folds}",
        )  # fmt: skip
    console.print(table)
    for name, why in found.failed.items():
        console.print(f"{name} could not be fitted: {why}", markup=False, soft_wrap=True)
