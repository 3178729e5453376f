"""Figure 7-4: a flip shown by hand is two subgoals, level at the bottom and inverted at the top; then it is flown.

The hand goes up, over and down on an upright ellipse, 0.15 m wide and 1 m high, and turns the vehicle once, evenly
along the way. A seed is right when exactly two subgoals hold 5 % of the observations, one within 0.3 rad of level and
one within 0.3 rad of inverted. A hand need not heed what a vehicle can do: the flight is a loop between the same poses.

A rounder loop has no straight ways between poses, and straight ways are all that action comparison knows: how many
subgoals it needs then is shown beside.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import INK, PALETTE, Headline, Options, run, sheet
from experiments.hand_held import FLOOR, HALF_HEIGHT, HALF_WIDTH, flip
from experiments.hand_held_picture import draw_flight, draw_subgoals
from experiments.hand_held_study import QUICK_SEEDS, SEEDS, Flown, Learned, flown, learn, over_seeds, stages
from subgoal.runtime.checks import Floats

NEAR = 0.3
"""Radians."""
ENDS = np.array([[0.0, FLOOR, 0.0], [0.0, FLOOR + 2 * HALF_HEIGHT, np.pi]])
"""Bottom and top of the flip."""
HALF_WIDTHS = (0.025, 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
QUICK_WIDTHS = (0.075, 0.5)
REPEATS = 5


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every seed is shown, learned and flown."""
    seeds = range(options.seed, options.seed + (QUICK_SEEDS if options.quick else SEEDS))
    every = over_seeds(seeds, one)
    off = [angles_off(learned.places) for learned, _ in every]
    counts = [len(learned.main) for learned, _ in every]
    loops = [loop(flight) for _, flight in every]
    headline: Headline = {
        "seeds": len(seeds),
        "seeds_correct": sum(k == 2 and max(angles) <= NEAR for k, angles in zip(counts, off, strict=True)),
        "n_subgoals": counts,
        "largest_angle_error": float(np.max(off)),
        "largest_place_error": max(places_off(learned.places) for learned, _ in every),
        "tracking_rmse": float(np.median([flight.tracking.rmse for _, flight in every])),
        "flights": [flight.flight.status.name for _, flight in every],
        "half_width_shown": HALF_WIDTH,
        "half_height_shown": HALF_HEIGHT,
        "loop_flown": {name: float(np.median([each[name] for each in loops])) for name in loops[0]},
        "largest_inverted_error_flown": max(each["inverted_error"] for each in loops),
        "seconds_from_file_to_flight": stages([{**learned.seconds, **flight.seconds} for learned, flight in every]),
        "by_half_width": rounder(seeds[0], QUICK_WIDTHS if options.quick else HALF_WIDTHS),
        "status": [learned.posterior.status.name for learned, _ in every],
    }
    return headline, picture(*every[0], off, headline)


def one(seed: int) -> tuple[Learned, Flown]:
    """Shown, learned, flown."""
    learned = learn(flip(seed), seed)
    return learned, flown(learned)


def angles_off(places: Floats) -> tuple[float, float]:
    """How far the subgoal nearest to level is from it, and the one nearest to inverted; radians."""
    angle = np.angle(np.exp(1j * (places[:, 2, None] - ENDS[:, 2])))
    level, inverted = np.abs(angle).min(axis=0)
    return float(level), float(inverted)


def places_off(places: Floats) -> float:
    """Largest distance of bottom and top from the nearest subgoal, metres."""
    return float(np.linalg.norm(places[:, None, :2] - ENDS[:, :2], axis=-1).min(axis=0).max())


def loop(flown: Flown) -> dict[str, float]:
    """Half the width and half the height of what was flown (m), how far from inverted it was at its highest point and
    from level at its end (rad), and how long it took (s).
    """
    flight = flown.flight
    width, height = np.ptp(flight.positions[:, 1:], axis=0) / 2
    top = int(flight.positions[:, 2].argmax())
    aside = np.abs(np.angle(np.exp(1j * (flight.angles[[top, -1]] - [np.pi, 0.0]))))
    return {
        "half_width": float(width), "half_height": float(height), "inverted_error": float(aside[0]),
        "level_error": float(aside[1]), "seconds": flight.duration,
    }  # fmt: skip


def rounder(seed: int, widths: tuple[float, ...]) -> list[Headline]:
    """How many subgoals a flip has that is as high and wider."""
    return [
        {"half_width": width, "n_subgoals": [len(learn(flip(k, width), k).main) for k in range(seed, seed + REPEATS)]}
        for width in widths
    ]


def picture(learned: Learned, flight: Flown, off: list[tuple[float, float]], headline: Headline) -> Figure:
    """The first seed from the hand to the flight, how far off each seed is, and rounder flips."""
    figure = sheet(13.0, 9.6)
    grid = figure.add_gridspec(2, 3)
    poses(figure.add_subplot(grid[:, 0]), learned)
    by_angle(figure.add_subplot(grid[0, 1]), learned)
    axes = figure.add_subplot(grid[:, 2])
    draw_flight(axes, learned, flight)
    draw_vehicle(axes, flight)
    flown_loop = loop(flight)
    wide, high = (2 * flown_loop[half] for half in ("half_width", "half_height"))
    axes.set_title(f"Flown in {flown_loop['seconds']:.1f} s: {wide:.2f} m wide, {high:.2f} m high,\n"
                   f"{np.degrees(flown_loop['inverted_error']):.0f}° from inverted at its top")  # fmt: skip
    by_width(figure.add_subplot(grid[1, 1]), headline["by_half_width"])
    figure.suptitle(
        f"A flip shown by hand: level and inverted, {headline['seeds_correct']} of {headline['seeds']} seeds right",
        x=0.01, ha="left",
    )  # fmt: skip
    return figure


def poses(axes: Axes, learned: Learned) -> None:
    """Pairs with the vehicle's attitude, in the colours of what they serve."""
    draw_subgoals(axes, learned)
    states = np.asarray(learned.demonstrations.states)[::5]
    ticks(axes, states[:, :2], states[:, 2], INK, 0.05)
    axes.set_title("The hand's poses and\nthe two subgoals")


def ticks(axes: Axes, places: Floats, angles: Floats, colour: str, half: float) -> None:
    """A bar across the vehicle, with a short mast on the side that the thrust goes to."""
    across, up = np.stack([np.cos(angles), np.sin(angles)], axis=1), np.stack([-np.sin(angles), np.cos(angles)], axis=1)
    for place, bar, mast in zip(places, across, up, strict=True):
        axes.plot(*np.stack([place - half * bar, place + half * bar]).T, color=colour, lw=1.4)
        axes.plot(*np.stack([place, place + 0.6 * half * mast]).T, color=colour, lw=1.0)


def draw_vehicle(axes: Axes, flight: Flown) -> None:
    """The flown attitude now and then."""
    rows = np.linspace(0, len(flight.flight.times) - 1, 30).astype(int)
    ticks(axes, flight.flight.positions[rows, 1:], flight.flight.angles[rows], PALETTE[1], 0.06)


def by_angle(axes: Axes, learned: Learned) -> None:
    """Height over the angle, in which the two ways are all but straight."""
    states = np.asarray(learned.demonstrations.states)
    axes.plot(np.degrees(np.unwrap(states[:, 2])), states[:, 1], ".", color=INK, ms=3)
    for k, goal in enumerate(learned.main):
        axes.plot(np.degrees(goal.position[2]) % 360, goal.position[1], "o", color=PALETTE[k], ms=14, mec="white")
    axes.set(title="Height over angle", xlabel="angle (°)", ylabel="z (m)")


def by_width(axes: Axes, rows: list[Headline]) -> None:
    """How many subgoals rounder flips have."""
    for row in rows:
        axes.plot([row["half_width"] / HALF_HEIGHT] * len(row["n_subgoals"]), row["n_subgoals"], "o", color=PALETTE[0],
                  alpha=0.5)  # fmt: skip
    axes.plot([row["half_width"] / HALF_HEIGHT for row in rows], [np.mean(row["n_subgoals"]) for row in rows],
              color=PALETTE[0])  # fmt: skip
    axes.axhline(2, color=PALETTE[1], lw=1)
    axes.set(title="Rounder flips have no straight ways", xlabel="width over height", ylabel="subgoals", ylim=(0, None))


if __name__ == "__main__":
    run("fig_7_4", experiment)
