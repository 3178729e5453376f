"""``subgoal follow``: the subgoals of a recording while it is written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from subgoal.cli import options as o

if TYPE_CHECKING:
    from subgoal.streaming import Stream


def follow(
    file: Annotated[str, typer.Argument(help="CSV file that may still grow, or - for standard input.")],
    epsilon: Annotated[float, typer.Option(help="Radius of the ε-net of candidate places, in units of the positions.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("out"),
    confidence: Annotated[
        float, typer.Option("--confidence", "-a", help="α: nats per unit of direction.", rich_help_panel=o.MODEL)
    ] = 3.0,
    concentration: Annotated[
        float, typer.Option("--concentration", "-e", help="η: larger expects more subgoals.", rich_help_panel=o.MODEL)
    ] = 1.0,
    weights: o.Weights = None,
    period: o.Period = None,
    merge_radius: o.MergeRadius = None,
    draws: Annotated[int, typer.Option(help="Kept draws per chain, at the end.")] = 1000,
    warmup: Annotated[int, typer.Option(help="Sweeps before the first kept draw.")] = 200,
    thin: Annotated[int, typer.Option(help="Sweeps between kept draws.")] = 2,
    seed: Annotated[int, typer.Option("--seed", "-s")] = 0,
    wait: Annotated[
        float | None, typer.Option(help="End after so many seconds without a new line; else Ctrl-C ends it.")
    ] = None,
    y_down: Annotated[bool, typer.Option(help="Draw y downwards, as in images.")] = False,
    quiet: o.Quiet = False,
    position: o.Position = "x,y",
    time: o.Time = "t",
    trajectory: o.Trajectory = None,
    units: o.Units = None,
    rate: Annotated[
        float, typer.Option(help="Resample to this rate; 0 leaves the samples as they are.", rich_help_panel=o.READING)
    ] = 20.0,
    window: Annotated[int, typer.Option(help="Samples a velocity spans.", rich_help_panel=o.READING)] = 2,
    max_gap: o.MaxGap = None,
    separator: o.Separator = None,
    decimal: o.Decimal = None,
) -> None:
    """Learn subgoals while a recording is written; at its end, or at Ctrl-C, write what learn writes.

    Lines that are no sample (a word for a number, a time that goes back) are told and left out. Where the trajectory
    column changes, one trajectory ends and the next begins.

    Examples:

      subgoal follow track.csv --position x,y --time t --epsilon 0.05 --out out/

      some-tracker | subgoal follow - -p x,y,z -t stamp --rate 50 --epsilon 0.1
    """
    from subgoal.cli.compose import output_folder, tell_replaced
    from subgoal.cli.display import Display
    from subgoal.cli.following import Following, source_told
    from subgoal.demonstrations.metric import Metric
    from subgoal.runtime.checks import positive, whole
    from subgoal.streaming import Stream

    names = tuple(o.words(position) or ())
    _all_different([*names, time or "t", *([trajectory] if trajectory else [])])
    how = {"draws": whole("draws", draws), "warmup": whole("warmup", warmup, least=0), "thin": whole("thin", thin)}
    merge_radius = None if merge_radius is None else positive("merge_radius", merge_radius, zero=True)
    patience = float("inf") if wait is None else positive("wait", wait, zero=True)
    metric = Metric.of(len(names), o.numbers("--weights", weights), o.numbers("--period", period))
    stream = Stream(
        names=names, radius=epsilon, confidence=confidence, concentration=concentration, rate=rate or None,
        window=window, max_gap=max_gap, metric=metric, units=units or "", seed=seed, source=source_told(file),
    )  # fmt: skip
    with output_folder(out) as folder:
        tell_replaced(folder, quiet=quiet)
        display = Display(quiet=quiet, merge_radius=merge_radius)
        following = Following(stream, display, out=folder, rate=rate or None, max_gap=max_gap)
        following.read(
            file, position=names, time=time or "t", trajectory=trajectory, separator=separator, decimal=decimal,
            patience=patience,
        )  # fmt: skip
        _check_moved(stream, names)
        _write(stream, folder, how, merge_radius=merge_radius, y_down=y_down, quiet=quiet)


def _all_different(names: list[str]) -> None:
    """``InputError`` for a column that is asked for twice."""
    from subgoal.runtime.errors import InputError

    again = [name for k, name in enumerate(names) if name in names[:k]]
    if again:
        raise InputError("columns", found=f"{again[0]!r} more than once in --position, --time and --trajectory",
                         wanted="each column once")  # fmt: skip


def _check_moved(stream: Stream, names: Sequence[str]) -> None:
    """``InputError`` in words of the command where nothing came that could be learned from."""
    from subgoal.runtime.errors import InputError

    if not stream.n_pairs:
        raise InputError("recording", found="no line with numbers that has a later one after it",
                         wanted=f"two samples at least of {', '.join(names)}")  # fmt: skip
    if not np.asarray(stream.demonstrations().actions).any():
        raise InputError(
            "recording", found=f"nothing that moves in {stream.n_pairs} samples",
            wanted=f"{', '.join(names)} that change", hint="--position names the columns of the place",
        )  # fmt: skip


def _write(
    stream: Stream, folder: Path, how: dict[str, int], *, merge_radius: float | None, y_down: bool, quiet: bool
) -> None:
    """New draws of all that came, and the folder that ``learn`` writes."""
    import warnings

    from subgoal.cli.table import print_results
    from subgoal.cli.write import write
    from subgoal.posterior.sample import ConvergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = stream.posterior(**how)
    results = write(posterior, folder, merge_radius=merge_radius, y_down=y_down, sensitive=False, quiet=quiet)
    if not quiet:
        print_results(posterior, results, folder)
