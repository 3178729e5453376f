"""``subgoal learn``: from a recording to subgoals, segments, pictures and a report."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from subgoal.cli import options as o
from subgoal.runtime.errors import InputError, StoppedError

if TYPE_CHECKING:
    from subgoal.likelihood.table import LogLikelihood
    from subgoal.posterior.posterior import Posterior

CONFIDENCE = 3.0
CHECKPOINT = ".checkpoint.npz"
CELLS = "grid"
"""Word for planning in cells."""
PLACES = "Candidate places"
MODEL = "Model"
RUN = "Run"


def learn(
    file: o.File,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("out"),
    learn_all: Annotated[
        bool,
        typer.Option(
            "--learn-all", help="Learn α, η, persistence and weight; what is given stays.", rich_help_panel=MODEL
        ),
    ] = False,
    confidence: Annotated[
        float | None,
        typer.Option("--confidence", "-a", help="α: nats per unit of direction; default 3.", rich_help_panel=MODEL),
    ] = None,
    concentration: Annotated[
        float | None,
        typer.Option(
            "--concentration", "-e", help="η: larger expects more subgoals; default 1.", rich_help_panel=MODEL
        ),
    ] = None,
    controller: Annotated[
        str, typer.Option(help="direction (straight to the goal) or proportional.", rich_help_panel=MODEL)
    ] = "direction",
    gain: Annotated[
        float | None, typer.Option(help="Of the proportional controller, 1/time; default 1.", rich_help_panel=MODEL)
    ] = None,
    speed_limit: Annotated[
        float | None, typer.Option(help="Of the proportional controller; default: median speed.", rich_help_panel=MODEL)
    ] = None,
    weights: Annotated[
        str | None, typer.Option(help="Weight of each dimension, e.g. 1,1,0.3.", rich_help_panel=MODEL)
    ] = None,
    period: Annotated[
        str | None, typer.Option(help="Period of each dimension, e.g. inf,inf,6.2832.", rich_help_panel=MODEL)
    ] = None,
    candidates: Annotated[
        Path | None, typer.Option(help="CSV of places with position columns, name, prior.", rich_help_panel=PLACES)
    ] = None,
    epsilon: Annotated[
        float | None, typer.Option(help="Radius of the ε-net; default 3 % of the extent.", rich_help_panel=PLACES)
    ] = None,
    grid: Annotated[float | None, typer.Option(help="Regular grid of this spacing.", rich_help_panel=PLACES)] = None,
    merge_radius: Annotated[
        float | None, typer.Option(help="Places within it are one subgoal; default 5ε.", rich_help_panel=PLACES)
    ] = None,
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
            help="grid: plan in cells, instead of comparing directions. Else the column with the tracker's confidence.",
            rich_help_panel=MODEL,
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
    min_likelihood: o.MinLikelihood = None,
    bodypart: o.Bodypart = None,
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

      subgoal learn tracks.csv --likelihood grid --cell 0.5 --map floor.png --out out/

      subgoal learn tracks.txt --start-within 480:inf,-inf:140 --every 9 --window 5 -a 10 --y-down
    """
    world = o.given(
        cell=cell, discount=discount, map_file=map, corner=o.numbers("--map-corner", map_corner), outside=outside
    )
    reading = o.given(
        format=format, position=o.words(position), action=o.words(action), time=time, trajectory=trajectory,
        group=group, time_scale=time_scale, scale=scale, units=units, clock=clock,
        likelihood=None if likelihood == CELLS else likelihood, min_likelihood=min_likelihood, bodypart=bodypart,
        start_within=o.box(start_within), rate=rate, every=every, velocity=velocity, window=window, max_gap=max_gap,
        thin=thin_radius, period=o.numbers("--period", period), separator=separator, decimal=decimal,
    )  # fmt: skip
    places = o.given(file=candidates, epsilon=epsilon, grid=grid)
    table = {"confidence": confidence, "controller": controller, "gain": gain, "speed_limit": speed_limit}
    metric = {"weights": o.numbers("--weights", weights), "period": o.numbers("--period", period)}
    run = o.given(
        concentration=concentration, sampler=sampler, chains=chains, draws=draws, warmup=warmup, thin=thin, seed=seed,
        workers=workers, backend=backend, resume=resume,
    )  # fmt: skip
    how: dict[str, Any] = {"merge_radius": merge_radius, "y_down": y_down, "quiet": quiet, "learn_all": learn_all,
                           "sensitive": sensitivity}  # fmt: skip
    with scheduler_of(scheduler, backend):
        if likelihood == CELLS:
            from subgoal.cli.gridding import learn_in_cells

            learn_in_cells(file, out, reading, places, metric, table, run, world | {"moves": moves}, **how)
            return
        if world:
            option = f"--{next(iter(world)).split('_')[0]}"
            raise InputError(option, found="given", wanted="--likelihood grid beside it")
        learn_file(file, out, reading, places, metric, table, run, **how)


@contextmanager
def scheduler_of(address: str | None, backend: str) -> Iterator[None]:
    """A connected Dask client while it lasts, where there is an address."""
    if address is None:
        yield
        return
    if backend != "dask":
        raise InputError("--scheduler", found=address, wanted="--backend dask beside it")
    from subgoal.runtime.cluster import connect

    with connect(address):
        yield


def learn_file(
    file: Path,
    out: Path,
    reading: dict[str, Any],
    places: dict[str, Any],
    metric: dict[str, Any],
    table: dict[str, Any],
    run: dict[str, Any],
    *,
    merge_radius: float | None,
    y_down: bool,
    quiet: bool,
    learn_all: bool = False,
    sensitive: bool = False,
) -> None:
    """The pipeline behind ``learn`` and ``demo``: read, tabulate, sample, write, print."""
    from subgoal.cli.compose import candidate_places, clock_told, likelihood_table, output_folder
    from subgoal.demonstrations.metric import Metric
    from subgoal.demonstrations.read import read

    demonstrations = read(file, **reading)
    if not quiet:
        print(clock_told(demonstrations, file, reading))
    plan = Metric.of(demonstrations.states.shape[-1], metric["weights"], metric["period"])
    chosen = candidate_places(demonstrations, plan, **places)
    fixed = table["confidence"] is not None
    likelihood = likelihood_table(demonstrations, chosen, **(table if fixed else {**table, "confidence": CONFIDENCE}))
    with output_folder(out) as folder:
        learn_table(
            likelihood, folder, run, merge_radius=merge_radius, y_down=y_down, quiet=quiet, learn_all=learn_all,
            sensitive=sensitive, fixed=fixed, grouped="group" in reading,
        )  # fmt: skip


def learn_table(
    likelihood: LogLikelihood,
    folder: Path,
    run: dict[str, Any],
    *,
    merge_radius: float | None,
    y_down: bool,
    quiet: bool,
    learn_all: bool,
    sensitive: bool,
    fixed: bool,
    grouped: bool,
) -> None:
    """Sample, write and print, of a likelihood with its demonstrations; ``fixed`` keeps its confidence."""
    from subgoal.cli.compose import model_and_sampler
    from subgoal.cli.table import print_results
    from subgoal.cli.write import write
    from subgoal.reporting.learned import GROUPS_DO_NOT_LAST
    from subgoal.runtime.checks import positive

    merge_radius = None if merge_radius is None else positive("merge_radius", merge_radius, zero=True)
    if learn_all and grouped and not quiet:
        print(f"note: {GROUPS_DO_NOT_LAST}")
    sampler = run.pop("sampler", None)
    run = run | model_and_sampler(likelihood.demonstrations, sampler, grouped=grouped, learn_all=learn_all)
    run |= {"confidence": None} if learn_all and fixed else {}
    posterior = _sampled(likelihood, folder, run, learn_all=learn_all, quiet=quiet)
    complete = posterior.n_draws == posterior.settings.draws
    results = write(
        posterior, folder, merge_radius=merge_radius, y_down=y_down, sensitive=sensitive and complete, quiet=quiet
    )
    if not quiet:
        print_results(posterior, results, folder)
    if not complete:
        told = f"{posterior.n_draws} of {posterior.settings.draws} draws per chain"
        raise StoppedError(f"stopped with {told}, which stand in {folder}; --resume goes on")


def _sampled(
    likelihood: LogLikelihood, folder: Path, run: dict[str, Any], *, learn_all: bool, quiet: bool
) -> Posterior:
    """From ``learn`` or ``sample``, with a checkpoint in the folder; whether it converged is told later."""
    from subgoal.irl.learn import learn as learn_everything
    from subgoal.posterior.sample import ConvergenceWarning, sample
    from subgoal.runtime.progress import progress_display

    draw = learn_everything if learn_all else sample
    display = progress_display("sampling", quiet=quiet)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return draw(likelihood, checkpoint=folder / CHECKPOINT, progress=display, **run)
