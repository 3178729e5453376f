"""``subgoal fly``: the subgoals of a folder of results flown by a simulated quadrotor."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from subgoal.cli import options as o
from subgoal.cli.waypoints import AnyPlane, Cyclic, Dwell, Folder, LeastShare, Metres, Visits

FILM = "flight.gif"


def fly(
    folder: Folder,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Folder; default: flight in the first one.")] = None,
    speed: Annotated[float, typer.Option(help="Metres per second, at most.")] = 1.0,
    acceleration: Annotated[float, typer.Option(help="Metres per second squared, at most.")] = 3.0,
    smoothing: Annotated[str, typer.Option(help="stop at each waypoint, or go through.")] = "stop",
    rounds: Annotated[int, typer.Option(help="Of waypoints that come round again.")] = 1,
    cyclic: Cyclic = None,
    visits: Visits = False,
    dwell: Dwell = 0.0,
    least_share: LeastShare = 0.05,
    merge_radius: o.MergedAsBefore = None,
    plane: AnyPlane = None,
    height: Annotated[float, typer.Option(help="Metres above the origin, for a horizontal plane.")] = 1.0,
    scale: Metres = None,
    vehicle: Annotated[str, typer.Option(help="hummingbird or crazyflie.")] = "hummingbird",
    tolerance: Annotated[
        float | None,
        typer.Option(help="Metres within which a waypoint is reached; default 0.1, or a quarter of the shortest leg."),
    ] = None,
    tilt_tolerance: Annotated[
        float, typer.Option(help="Radians within which the largest tilt is had, or a vehicle level.")
    ] = 0.3,
    most_seconds: Annotated[float, typer.Option(help="Longest flight that is simulated.")] = 600.0,
    seed: Annotated[int, typer.Option(help="Random seed of the noise.")] = 0,
    noise: Annotated[float, typer.Option(help="Metres by which measured positions are off (RMS).")] = 0.0,
    y_down: Annotated[bool | None, typer.Option(help="Draw y downwards; default: as the results are.")] = None,
    film: Annotated[bool, typer.Option("--film/--no-film", help="Whether to draw flight.gif.")] = True,
    quiet: o.Quiet = False,
) -> None:
    """Fly through the subgoals and compare with what was demonstrated.

    Writes flight.csv, flight.json, flight.png (and .svg) and flight.gif. A subgoal with a tilt, of poses in a vertical
    plane, is flown with that tilt, in a loop if need be. Ends with 1 if the vehicle did not arrive or lost its path.

    Example:

      subgoal fly out/ --out out/flight --speed 1.5
    """
    from subgoal.cli.compose import output_folder
    from subgoal.cli.waypoints import learned_in, told
    from subgoal.flight import FlightStatus, tracking, waypoints, write_flight
    from subgoal.flight import fly as flown
    from subgoal.plots.files import save_figure
    from subgoal.plots.flight import plot_flight
    from subgoal.plots.flight_animation import animate_flight
    from subgoal.reporting.results import drawn_downwards
    from subgoal.runtime.progress import progress_display

    posterior, found = learned_in(folder, merge_radius)
    made = waypoints(posterior, found=found, cyclic=cyclic, dwell=dwell, least_share=least_share, visits=visits)
    flight = flown(
        made, plane=plane, height=height, scale=scale, speed=speed, acceleration=acceleration, smoothing=smoothing,
        rounds=rounds, vehicle=vehicle, tolerance=tolerance, tilt_tolerance=tilt_tolerance,
        most_seconds=most_seconds, noise=noise, seed=seed,
        progress=progress_display("flight", quiet=quiet),
    )  # fmt: skip
    error = tracking(flight, posterior.demonstrations)
    y_down = drawn_downwards(folder) if y_down is None else y_down
    with output_folder(folder / "flight" if out is None else out) as place:
        write_flight(flight, error, place)
        save_figure(plot_flight(flight, made, posterior.demonstrations, y_down=y_down), place, "flight")
        (place / FILM).unlink(missing_ok=True)
        if film:
            animate_flight(flight, made, posterior.demonstrations, place / FILM, y_down=y_down)
    if not quiet:
        print(told(made))
        print(f"{flight.told}; {flight.duration:.1f} s")
        print(error.told)
        print(f"Look at {place / 'flight.png'}")
    if flight.status in (FlightStatus.DID_NOT_ARRIVE, FlightStatus.DIVERGED):
        raise typer.Exit(1)
