"""What ``learn`` prints: a short table of subgoals and where the files are."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from subgoal.answers.subgoals import COUNTED_FROM, Subgoals, reaches
from subgoal.demonstrations.records import Demonstrations
from subgoal.plots.words import counted, decimals, trajectories
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.learned import weight_told
from subgoal.reporting.results import Results

MUCH = 0.05
"""Counts of rows dropped or changed above this share of the observations are told as a warning."""
SMALL = "* below 5 %: listed, not counted"


def smaller(found: Subgoals) -> str:
    """ ", and 1 smaller place", those that are listed and not counted."""
    places = len(found) - found.n_subgoals
    return f", and {counted(places, 'smaller place')}" if places else ""


def print_results(posterior: Posterior, results: Results, folder: Path) -> None:
    """Headline, subgoals, status, files; plain text when not on a terminal."""
    console = Console(highlight=False)
    demos, found = posterior.demonstrations, results.found
    table = Table(box=None, pad_edge=False)
    table.add_column("", justify="right")
    table.add_column("subgoal")
    for name in demos.names:
        table.add_column(escape(f"{name} ({demos.units})" if demos.units else name), justify="right")
    for heading in ("share", "90 % interval", "P(≥ 1 %)", "radius"):
        table.add_column(heading, justify="right")
    digits = decimals(demos.extent)
    for item in found:
        low, high = item.share_interval
        table.add_row(
            f"{item.label}{'' if reaches(item.share, COUNTED_FROM) else '*'}", escape(item.name),
            *(f"{x:.{digits}f}" for x in item.position), f"{item.share:.1%}",
            f"{low:.1%} to {high:.1%}", f"{item.inclusion:.2f}", f"{item.radius:.3g}",
        )  # fmt: skip
    count, rows = counted(found.n_subgoals, "subgoal"), counted(demos.n_observations, "observation")
    console.print(
        f"{count} with at least 5 % of {rows} in {trajectories(demos.n_trajectories)}{smaller(found)} "
        f"({counted(len(results.cut), 'segment')})",
        markup=False,
        soft_wrap=True,
    )
    console.print(table)
    if smaller(found):
        console.print(SMALL, markup=False, soft_wrap=True)
    colour = "green" if posterior.status is Status.CONVERGED else "red"
    console.print(posterior.status.value, style=colour, markup=False, soft_wrap=True)
    if weight_told(posterior):
        console.print(weight_told(posterior), markup=False, soft_wrap=True)
    print_notes(demos, console)
    console.print(f"Look at {folder / 'report.html'}", markup=False, soft_wrap=True)


def print_notes(demonstrations: Demonstrations, console: Console) -> None:
    """What was dropped, cut or filled in on the way in."""
    for what, number in demonstrations.source.notes.items():
        much = "warning: " if number > MUCH * demonstrations.n_observations else ""
        console.print(f"{much}on the way in: {what.replace('_', ' ')}: {number}", markup=False, soft_wrap=True)
