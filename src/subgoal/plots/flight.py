"""A flight beside its demonstration, and the same as a moving picture."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.flight.record import Flight, FlightStatus
from subgoal.flight.tracking import tracking
from subgoal.flight.waypoints import Waypoints
from subgoal.plots.shown import shown
from subgoal.plots.style import (
    ALARM,
    FAINT,
    INK,
    SMALL,
    TEXT,
    colour,
    equal_limits,
    ink_on,
    limits,
    new_figure,
    panel,
    with_unit,
)  # fmt: skip
from subgoal.runtime.checks import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN, FLOWN = "#8A9099", "#C2410C"
"""Of the hand, and of the vehicle."""
VEHICLES = 26
"""How often the vehicle is drawn along its way."""
MOST_MARKED = 25
"""Arrivals that are marked on the axes of time."""
SPAN = 0.035
"""Half of the vehicle's width, as a share of the extent."""


def plot_flight(
    flight: Flight, waypoints: Waypoints, demonstrations: Demonstrations, *, y_down: bool = False
) -> Figure:  # fmt: skip
    """The demonstrated path in grey, the flown one in colour with the vehicle's attitude, and the numbered waypoints.

    Beside it, over the time of the flight: how far the vehicle was from the demonstrated path, and its speed, or its
    tilt where the demonstration has an angle. In three dimensions the path is drawn from above and from the side.
    ``y_down`` turns the second coordinate over, as in images.
    """
    error = tracking(flight, demonstrations)
    pairs = [(0, 1)] if len(flight.placement.axes) == 2 else [(0, 1), (0, 2)]
    width = 11.5 if len(pairs) == 1 else 14.5
    figure = new_figure(width, 6.4, f"Flown in {flight.duration:.1f} s: {error.told}", None, [_told(flight)], left=0.07)
    alarms = [] if flight.status is FlightStatus.FLOWN else [flight.told]
    alarms += [note.split(";")[0] for note in flight.waypoints.notes]
    told = textwrap.shorten("; ".join(alarms), int(0.93 * width * 11.5))
    figure.text(0.07, 0.945, told, fontsize=TEXT, color=ALARM, weight="bold", va="top")
    right = 0.655 if len(pairs) == 1 else 0.74
    each = (right - 0.13) / len(pairs)
    for k, pair in enumerate(pairs):
        axes = panel(figure, (0.07 + k * each, 0.12, each - 0.055 * (len(pairs) > 1), 0.74), "", *_names(flight, pair))
        draw_paths(axes, flight, demonstrations, pair, y_down=y_down)
        draw_waypoints(axes, waypoints, flight, pair)
        if len(pairs) == 1:
            draw_vehicles(axes, flight, _spread(flight))
    vehicle = "vehicle and thrust" if flight.placement.upright else "vehicle and nose"
    _key(figure, vehicle if len(pairs) == 1 else "")
    _over_time(figure, right, 0.55, flight, error.flown, "from the demonstrated path", error.units)
    if error.angle_rmse is not None and flight.placement.upright:
        _over_time(figure, right, 0.12, flight, np.degrees(flight.angles), "tilt", "°")
    else:
        _over_time(figure, right, 0.12, flight, np.linalg.norm(flight.velocities, axis=1), "speed", "m/s")
    return figure


def draw_paths(
    axes: Axes, flight: Flight, demonstrations: Demonstrations, pair: tuple[int, int] = (0, 1), *, y_down: bool = False
) -> None:
    """Both paths in two of the positions, with limits that hold them."""
    from matplotlib.collections import LineCollection

    columns = [flight.placement.columns[k] for k in pair]
    places, part = np.asarray(demonstrations.states)[:, columns], shown(demonstrations.offset)
    axes.add_collection(LineCollection(part.paths(places), colors=SHOWN, linewidths=2.6, alpha=0.8), autolim=False)
    path = flight.shown[:, pair]
    axes.plot(*path.T, color=FLOWN, linewidth=1.4, zorder=3)
    both = np.vstack([places, path])
    equal_limits(axes, both[:, 0], both[:, 1])
    if y_down and columns[1] == 1:
        axes.invert_yaxis()


def draw_waypoints(axes: Axes, waypoints: Waypoints, flight: Flight, pair: tuple[int, int] = (0, 1)) -> None:
    """Discs in the colours and with the numbers of the subgoals, and a square where the flight begins."""
    columns = [flight.placement.columns[k] for k in pair]
    begin = flight.shown[0, pair]
    axes.plot(*begin, marker="s", markersize=13, markerfacecolor="none", markeredgecolor=INK, zorder=7)
    for label in np.unique(waypoints.labels):
        turns = np.flatnonzero(waypoints.labels == label)
        x, y = waypoints.positions[turns[0], columns]
        shade = colour(int(label) - 1)
        axes.text(
            x, y, str(label), color=ink_on(shade), fontsize=TEXT, weight="bold", ha="center", va="center_baseline",
            zorder=6, bbox={"boxstyle": "circle,pad=0.35", "facecolor": shade,
                            "edgecolor": "white", "linewidth": 1.4},
        )  # fmt: skip


def draw_vehicles(axes: Axes, flight: Flight, rows: list[int]) -> None:
    """The vehicle at some samples: a bar through its rotors, a mast to where it thrusts or, from above, its nose."""
    from matplotlib.collections import LineCollection

    lines = vehicle_lines(flight, rows, span_of(axes))
    axes.add_collection(LineCollection(lines, colors=INK, linewidths=1.5, zorder=4, capstyle="round"), autolim=False)


def vehicle_lines(flight: Flight, rows: list[int], span: float) -> list[Floats]:
    """Two lines (2, 2) for each sample, in the coordinates of the demonstration."""
    angle, places = flight.angles[rows], flight.shown[rows, :2]
    first = flight.placement.axes[0]
    turn = angle + (np.pi / 2 if flight.placement.upright and first != 2 else 0.0)
    mast = np.stack([np.cos(turn), np.sin(turn)], axis=1) * span
    bar = np.stack([-mast[:, 1], mast[:, 0]], axis=1)
    return [
        line for place, b, m in zip(places, bar, mast, strict=True)
        for line in (np.stack([place - b, place + b]), np.stack([place, place + 0.8 * m]))
    ]  # fmt: skip


def span_of(axes: Axes) -> float:
    """Half of the vehicle's width."""
    return float(SPAN * min(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())))


def _spread(flight: Flight) -> list[int]:
    """Samples evenly along the way."""
    gone = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(flight.positions, axis=0), axis=1)))
    wanted = np.linspace(0, gone[-1], VEHICLES)
    rows: list[int] = np.unique(np.searchsorted(gone, wanted).clip(0, len(gone) - 1)).tolist()
    return rows


def _told(flight: Flight) -> str:
    reached = int(flight.reached.sum())
    return (
        f"{flight.vehicle}, simulated; {reached} of {len(flight.misses)} places reached within "
        f"{100 * flight.tolerance:.3g} cm; the hand took its own time, so time is left out of the distances"
    )  # fmt: skip


def _names(flight: Flight, pair: tuple[int, int]) -> tuple[str, str]:
    own = flight.waypoints
    first, second = (with_unit(own.dimensions[flight.placement.columns[k]], own.units) for k in pair)
    return first, second


def _key(figure: Figure, vehicle: str) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.path import Path

    mast = Path([(-1, 0), (1, 0), (0, 0), (0, 0.8)], [Path.MOVETO, Path.LINETO, Path.MOVETO, Path.LINETO])
    handles = [
        Line2D([], [], color=SHOWN, linewidth=2.6, label="demonstrated"),
        Line2D([], [], color=FLOWN, linewidth=1.4, label="flown"),
        Line2D([], [], linestyle="", marker="s", markersize=9, markerfacecolor="none", color=INK, label="start"),
        Line2D([], [], linestyle="", marker="o", markersize=9, color=colour(0), label="number of a subgoal"),
    ]
    if vehicle:
        handles.append(Line2D([], [], linestyle="", marker=mast, markersize=14, color=INK, markeredgewidth=1.5,
               label=vehicle))  # fmt: skip
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.06, 0.925), ncols=5, frameon=False,
                  fontsize=SMALL, columnspacing=1.2, handletextpad=0.5)  # fmt: skip


def _over_time(
    figure: Figure, left: float, bottom: float, flight: Flight, values: Floats, name: str, unit: str
) -> None:
    """A curve over the flight, with the moments at which places are due."""
    axes = panel(figure, (left, bottom, 0.975 - left, 0.31), "", "time [s]" if bottom < 0.5 else "", "")
    axes.set_title(with_unit(name, unit), fontsize=TEXT, color=INK, loc="left", pad=16)
    axes.plot(flight.times, values, color=FLOWN, linewidth=1.3)
    axes.set_xlim(0, flight.duration)
    axes.set_ylim(*limits(np.append(values, 0.0)))
    for at, k in zip(flight.path.arrivals, flight.route.waypoint, strict=True):
        if at <= flight.duration and flight.path.arrivals.size <= MOST_MARKED:
            axes.axvline(at, color=FAINT, linewidth=0.7, linestyle=":", zorder=0)
            label = str(flight.waypoints.labels[k]) if k >= 0 else ""
            axes.text(at, 1.02, label, transform=axes.get_xaxis_transform(), ha="center", fontsize=SMALL, color=FAINT)
