"""Options that several commands share, and the words on the command line turned into values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from subgoal.runtime.errors import InputError

READING, MODEL = "Reading the file", "Model"
File = Annotated[Path, typer.Argument(help="Recording: CSV, Parquet, NPZ, tracker or trajectory file, or bag.")]
Format = Annotated[
    str | None, typer.Option(help="File format, if it is not found out by itself.", rich_help_panel=READING)
]
Weights = Annotated[str | None, typer.Option(help="Weight of each dimension, e.g. 1,1,0.3.", rich_help_panel=MODEL)]
Period = Annotated[
    str | None, typer.Option(help="Period of each dimension, e.g. inf,inf,6.2832.", rich_help_panel=MODEL)
]
MergeRadius = Annotated[float | None, typer.Option(help="Places within it are one subgoal; default 5ε.")]
MergedAsBefore = Annotated[
    float | None, typer.Option("--merge-radius", help="Places within it are one subgoal; default: as in the results.")
]
Position = Annotated[
    str | None, typer.Option("--position", "-p", help="Position columns, e.g. x,y.", rich_help_panel=READING)
]
Action = Annotated[
    str | None, typer.Option(help="Recorded action columns, e.g. vx,vy (else velocities).", rich_help_panel=READING)
]
Time = Annotated[str | None, typer.Option("--time", "-t", help="Time column.", rich_help_panel=READING)]
Trajectory = Annotated[
    str | None,
    typer.Option("--trajectory", "-i", help="Column that tells trajectories apart.", rich_help_panel=READING),
]
Group = Annotated[
    str | None,
    typer.Option("--group", "-g", help="Column of groups (animal, driver, day): own weights for each.",
                 rich_help_panel=READING),
]  # fmt: skip
Sensitivity = Annotated[
    bool, typer.Option("--sensitivity", help="Run again under other settings, and show what hangs on them.")
]
Sweep = Annotated[
    bool,
    typer.Option("--sweep", help="Count subgoals at one confidence after another: where they begin to fall apart."),
]
Scale = Annotated[
    float | None, typer.Option(help="Multiply positions, e.g. metres per pixel.", rich_help_panel=READING)
]
TimeScale = Annotated[
    float | None, typer.Option(help="Seconds per unit of the time column; 0.001 for ms.", rich_help_panel=READING)
]
Separator = Annotated[
    str | None, typer.Option(help="Between columns of text, if found out wrongly.", rich_help_panel=READING)
]
Decimal = Annotated[
    str | None, typer.Option(help="Decimal sign of text, if found out wrongly.", rich_help_panel=READING)
]
Units = Annotated[str | None, typer.Option(help="Unit of the positions after scaling.", rich_help_panel=READING)]
Clock = Annotated[
    str | None, typer.Option(help="When times go back: refuse, sort, split or drop.", rich_help_panel=READING)
]
Likelihood = Annotated[str | None, typer.Option(help="Column with the tracker's confidence.", rich_help_panel=READING)]
WORLD = "World"
Cell = Annotated[
    float | None,
    typer.Option(help="Side of a cell, in units of the positions; default 1/20 of the extent.", rich_help_panel=WORLD),
]
Moves = Annotated[
    int,
    typer.Option(
        help="4 or 8 directions. Paths recorded often cross edges of cells, hardly ever corners.", rich_help_panel=WORLD
    ),
]
CONTINUOUS = "Continuous world"
DynamicsOption = Annotated[
    str | None,
    typer.Option(
        help="What actions do: best (default), linear, neighbours or gp (learned), rear-drive or all-drive (the "
        "model car), or model.py:function of your own.",
        rich_help_panel=CONTINUOUS,
    ),
]
ActionBounds = Annotated[
    str | None,
    typer.Option(
        help="Least and most of each action, e.g. -.5:.5,0:3.6; default: as recorded.", rich_help_panel=CONTINUOUS
    ),
]
Floor = Annotated[
    str | None,
    typer.Option(
        help="Least difference that matters in each dimension; its unit is the spread, or this.",
        rich_help_panel=CONTINUOUS,
    ),
]
Horizon = Annotated[
    float | None,
    typer.Option(help="How far ahead the demonstrator looks; default 5 steps.", rich_help_panel=CONTINUOUS),
]
Dwell = Annotated[
    float | None,
    typer.Option(help="How long a subgoal is kept on average; 0: order says nothing.", rich_help_panel=CONTINUOUS),
]
Hold = Annotated[
    float | None,
    typer.Option(help="Share of the future that must be possible at a candidate.", rich_help_panel=CONTINUOUS),
]
MinLikelihood = Annotated[
    float | None, typer.Option(help="Drop samples the tracker trusts less.", rich_help_panel=READING)
]
Bodypart = Annotated[str | None, typer.Option(help="Body part (DeepLabCut) or node (SLEAP).", rich_help_panel=READING)]
Topic = Annotated[str | None, typer.Option(help="Topic of a ROS bag, if several hold poses.", rich_help_panel=READING)]
Frame = Annotated[
    str | None, typer.Option(help="Child frame of a topic of transforms, e.g. base_link.", rich_help_panel=READING)
]
Pose = Annotated[
    bool, typer.Option("--pose", help="Poses: position and a quaternion, x,y,z,qx,qy,qz,qw.", rich_help_panel=READING)
]
Plane = Annotated[
    str | None, typer.Option(help="Poses in a plane such as yz: y, z and an angle.", rich_help_panel=READING)
]
Twist = Annotated[
    bool,
    typer.Option("--twist", help="Velocities of Odometry as actions, and not differences.", rich_help_panel=READING),
]
PLANAR = (float("inf"), float("inf"), 6.283185307179586)
"""Periods of poses in a plane."""
StartWithin = Annotated[
    str | None,
    typer.Option(help="Only trajectories starting in a box, e.g. 480:inf,-inf:140.", rich_help_panel=READING),
]
Rate = Annotated[
    float | None,
    typer.Option(help="Resample to this rate (per time unit); frame rate of frames.", rich_help_panel=READING),
]
Every = Annotated[int, typer.Option(help="Keep every k-th sample.", rich_help_panel=READING)]
Velocity = Annotated[str, typer.Option(help="central, forward or savgol.", rich_help_panel=READING)]
Window = Annotated[int | None, typer.Option(help="Samples a velocity spans.", rich_help_panel=READING)]
MaxGap = Annotated[float | None, typer.Option(help="Split trajectories at longer gaps.", rich_help_panel=READING)]
ThinRadius = Annotated[
    float | None,
    typer.Option(help="Drop pairs nearer than this to a kept one of their track.", rich_help_panel=READING),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]


def refuse(given: dict[str, Any], wanted: str) -> None:
    """Raise ``InputError`` naming the first option of ``given``, if there is one."""
    for name in given:
        option = {"map_file": "--map", "corner": "--map-corner"}.get(name, f"--{name.replace('_', '-')}")
        raise InputError(option, found="given", wanted=wanted)


def words(text: str | None) -> list[str] | None:
    """ "x, y" as ["x", "y"]."""
    return None if text is None else [word.strip() for word in text.split(",") if word.strip()]


def numbers(what: str, text: str | None) -> list[float] | None:
    """ "1, 2.5" as [1.0, 2.5]."""
    try:
        return None if text is None else [float(word) for word in words(text) or []]
    except ValueError:
        raise InputError(what, found=repr(text), wanted="numbers with commas between them, e.g. 1,0.5") from None


def intervals(what: str, text: str | None) -> list[tuple[float, float]] | None:
    """ "480:inf,-inf:140" as [(480, inf), (-inf, 140)]."""
    if text is None:
        return None
    try:
        pairs = [word.split(":") for word in words(text) or []]
        return [(float(low), float(high)) for low, high in pairs]
    except ValueError:
        raise InputError(what, found=repr(text), wanted="low:high for each column, e.g. 480:inf,-inf:140") from None


def given(**options: Any) -> dict[str, Any]:
    """The options that are not None."""
    return {name: value for name, value in options.items() if value is not None}
