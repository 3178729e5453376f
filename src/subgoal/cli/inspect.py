"""``subgoal inspect``: what a recording looks like before anything is learnt from it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from subgoal.cli import options as o


def inspect(
    file: o.File,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the picture.")] = Path("out"),
    y_down: Annotated[bool, typer.Option(help="Draw y downwards, as in images.")] = False,
    quiet: o.Quiet = False,
    format: o.Format = None,
    position: o.Position = None,
    action: o.Action = None,
    time: o.Time = None,
    trajectory: o.Trajectory = None,
    group: o.Group = None,
    time_scale: o.TimeScale = None,
    scale: o.Scale = None,
    units: o.Units = None,
    clock: o.Clock = None,
    likelihood: o.Likelihood = None,
    min_likelihood: o.MinLikelihood = None,
    bodypart: o.Bodypart = None,
    topic: o.Topic = None,
    frame: o.Frame = None,
    pose: o.Pose = False,
    plane: o.Plane = None,
    twist: o.Twist = False,
    rate: o.Rate = None,
    max_gap: o.MaxGap = None,
    separator: o.Separator = None,
    decimal: o.Decimal = None,
) -> None:
    """Show counts, rates, gaps and ranges of a recording, with a picture (recording.png).

    Example:

      subgoal inspect tracks.csv --position x,y --time t --trajectory id --out out/
    """
    from subgoal.cli.compose import clock_told, output_folder, rate_hint
    from subgoal.cli.learn import learn
    from subgoal.cli.wording import as_typed
    from subgoal.demonstrations.read import look
    from subgoal.demonstrations.summary import summarise
    from subgoal.plots.files import save_figure
    from subgoal.plots.recording import plot_recording

    reading = o.given(
        format=format, position=o.words(position), action=o.words(action), time=time, trajectory=trajectory,
        group=group, time_scale=time_scale, scale=scale, units=units, clock=clock, likelihood=likelihood,
        min_likelihood=min_likelihood, bodypart=bodypart, rate=rate, max_gap=max_gap, separator=separator,
        decimal=decimal, topic=topic, frame=frame, pose=pose or None, plane=plane, twist=twist or None,
    )  # fmt: skip
    record = look(file, **reading)
    if not quiet:
        print(as_typed("\n".join(summarise(record).lines()), inspect, learn))
        print(clock_told(record, file, reading))
        if hint := rate_hint(record, reading):
            print(hint)
    with output_folder(out) as folder:
        save_figure(plot_recording(record, y_down=y_down), folder, "recording")
    if not quiet:
        print(f"Look at {out / 'recording.png'}")
