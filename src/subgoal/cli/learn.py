"""``subgoal learn``: from a recording to subgoals, segments, pictures and a report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from subgoal.cli import options as o
from subgoal.cli.pipeline import learn_file, scheduler_of

CELLS, PROCESSES = "grid", "gp"
"""Words for planning in cells, and by Gaussian processes."""
PLACES = "Candidate places"
RUN = "Run"


def learn(
    file: o.File,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("out"),
    learn_all: Annotated[
        bool,
        typer.Option(
            "--learn-all", help="Learn α, η, persistence and weight; what is given stays.", rich_help_panel=o.MODEL
        ),
    ] = False,
    confidence: Annotated[
        float | None,
        typer.Option("--confidence", "-a", help="α: nats per unit of direction; default 3.", rich_help_panel=o.MODEL),
    ] = None,
    concentration: Annotated[
        float | None,
        typer.Option(
            "--concentration", "-e", help="η: larger expects more subgoals; default 1.", rich_help_panel=o.MODEL
        ),
    ] = None,
    controller: Annotated[
        str, typer.Option(help="direction (straight to the goal) or proportional.", rich_help_panel=o.MODEL)
    ] = "direction",
    gain: Annotated[
        float | None, typer.Option(help="Of the proportional controller, 1/time; default 1.", rich_help_panel=o.MODEL)
    ] = None,
    speed_limit: Annotated[
        float | None,
        typer.Option(help="Of the proportional controller; default median speed.", rich_help_panel=o.MODEL),
    ] = None,
    weights: o.Weights = None,
    period: o.Period = None,
    candidates: Annotated[
        Path | None, typer.Option(help="CSV of places with position columns, name, prior.", rich_help_panel=PLACES)
    ] = None,
    epsilon: Annotated[
        float | None, typer.Option(help="Radius of the ε-net; default 3 % of the extent.", rich_help_panel=PLACES)
    ] = None,
    grid: Annotated[float | None, typer.Option(help="Regular grid of this spacing.", rich_help_panel=PLACES)] = None,
    merge_radius: o.MergeRadius = None,
    sampler: Annotated[
        str | None, typer.Option(help="Of subgoal.samplers; default collapsed_blocks.", rich_help_panel=RUN)
    ] = None,
    chains: Annotated[int, typer.Option(rich_help_panel=RUN)] = 4,
    draws: Annotated[int, typer.Option(help="Kept draws per chain.", rich_help_panel=RUN)] = 1000,
    warmup: Annotated[
        int | None, typer.Option(help="Sweeps before; default 1000, or 500 with --learn-all.", rich_help_panel=RUN)
    ] = None,
    thin: Annotated[
        int | None, typer.Option(help="Sweeps per kept draw; default 10, or 5 with --learn-all.", rich_help_panel=RUN)
    ] = None,
    seed: Annotated[int, typer.Option("--seed", "-s", rich_help_panel=RUN)] = 0,
    workers: Annotated[int | None, typer.Option(help="Chains at once.", rich_help_panel=RUN)] = None,
    backend: Annotated[
        str, typer.Option(help="threading, loky (processes) or dask.", rich_help_panel=RUN)
    ] = "threading",
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, for --backend dask.", rich_help_panel=RUN)
    ] = None,
    resume: Annotated[bool, typer.Option(help="Go on from the checkpoint in --out.", rich_help_panel=RUN)] = False,
    y_down: Annotated[bool, typer.Option(help="Draw y downwards, as in images.")] = False,
    sensitivity: o.Sensitivity = False,
    sweep: o.Sweep = False,
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
    likelihood: Annotated[
        str | None,
        typer.Option(
            help="grid: plan in cells; gp: plan in a continuous world, by Gaussian processes; instead of comparing "
            "directions. Else the column with the tracker's confidence.",
            rich_help_panel=o.MODEL,
        ),
    ] = None,
    cell: o.Cell = None,
    moves: o.Moves = 4,
    discount: Annotated[
        float | None,
        typer.Option(help="γ of the cells; default: felt across the whole world.", rich_help_panel=o.WORLD),
    ] = None,
    map: Annotated[
        Path | None,
        typer.Option(help="Where one can be: a picture, bright is free, or a text map.", rich_help_panel=o.WORLD),
    ] = None,
    map_corner: Annotated[
        str | None, typer.Option(help="Least x,y of the map; default 0,0.", rich_help_panel=o.WORLD)
    ] = None,
    outside: Annotated[
        str | None,
        typer.Option(help="Samples in walls and off the map: raise or drop.", rich_help_panel=o.WORLD),
    ] = None,
    dynamics: o.DynamicsOption = None,
    action_bounds: o.ActionBounds = None,
    floor: o.Floor = None,
    horizon: o.Horizon = None,
    dwell: o.Dwell = None,
    hold: o.Hold = None,
    min_likelihood: o.MinLikelihood = None,
    bodypart: o.Bodypart = None,
    topic: o.Topic = None,
    frame: o.Frame = None,
    pose: o.Pose = False,
    plane: o.Plane = None,
    twist: o.Twist = False,
    start_within: o.StartWithin = None,
    rate: o.Rate = None,
    every: o.Every = 1,
    velocity: o.Velocity = "central",
    window: o.Window = None,
    max_gap: o.MaxGap = None,
    thin_radius: o.ThinRadius = None,
    separator: o.Separator = None,
    decimal: o.Decimal = None,
) -> None:
    """Learn subgoals from a recording; write tables, pictures and report.html to a folder.

    Examples:

      subgoal learn tracks.csv --position x,y --time t --trajectory id --out out/

      subgoal learn tracks.csv --group animal --learn-all --sensitivity

      subgoal learn stroke.mat --every 20 --out out/

      subgoal learn poses.txt --rate 20 --out out/

      subgoal learn flip.mcap --topic /vicon/quad --plane yz --rate 20 --weights 1,1,0.3

      subgoal learn tracks.csv --likelihood grid --cell 0.5 --map floor.png --out out/

      subgoal learn drive.csv -p vx,vy,r,w --action delta,w_c -t t --every 20 --likelihood gp --floor .5,.4,1,.5

      subgoal learn tracks.txt --start-within 480:inf,-inf:140 --every 9 --window 5 -a 10 --y-down
    """
    world = o.given(
        cell=cell, discount=discount, map_file=map, corner=o.numbers("--map-corner", map_corner), outside=outside
    )
    wraps = o.PLANAR if plane and period is None else o.numbers("--period", period)
    reading = o.given(
        format=format, position=o.words(position), action=o.words(action), time=time, trajectory=trajectory,
        group=group, time_scale=time_scale, scale=scale, units=units, clock=clock,
        likelihood=None if likelihood in (CELLS, PROCESSES) else likelihood, min_likelihood=min_likelihood,
        bodypart=bodypart, start_within=o.intervals("--start-within", start_within), rate=rate, every=every,
        velocity=velocity, window=window, max_gap=max_gap, thin=thin_radius,
        period=wraps, separator=separator, decimal=decimal, topic=topic, frame=frame, pose=pose or None,
        plane=plane, twist=twist or None,
    )  # fmt: skip
    places = o.given(file=candidates, epsilon=epsilon, grid=grid)
    table = {"confidence": confidence, "controller": controller, "gain": gain, "speed_limit": speed_limit}
    metric = {"weights": o.numbers("--weights", weights), "period": wraps}
    run = o.given(
        concentration=concentration, sampler=sampler, chains=chains, draws=draws, warmup=warmup, thin=thin, seed=seed,
        workers=workers, backend=backend, resume=resume,
    )  # fmt: skip
    how: dict[str, Any] = {"merge_radius": merge_radius, "y_down": y_down, "quiet": quiet, "learn_all": learn_all,
                           "sensitive": sensitivity, "swept": sweep}  # fmt: skip
    continuous = o.given(
        action_bounds=o.intervals("--action-bounds", action_bounds), floor=o.numbers("--floor", floor),
        dynamics=dynamics, horizon=horizon, dwell=dwell, hold=hold,
    )  # fmt: skip
    with scheduler_of(scheduler, backend):
        if likelihood == PROCESSES:
            from subgoal.cli.continuous import learn_by_processes

            o.refuse(world, "--likelihood grid beside it")
            learn_by_processes(
                file, out, reading, places, metric, table, run, continuous, **how
            )  # fmt: skip
            return
        o.refuse(continuous, "--likelihood gp beside it")
        if likelihood == CELLS:
            from subgoal.cli.gridding import learn_in_cells

            learn_in_cells(file, out, reading, places, metric, table, run, world | {"moves": moves}, **how)
            return
        o.refuse(world, "--likelihood grid beside it")
        learn_file(file, out, reading, places, metric, table, run, **how)
