"""Figure 7-2: a square shown with a quadrotor in the hand, its four corners found, and flown.

A hand goes once round a square of 1.5 m (``hand_held``). A seed is right when exactly four subgoals hold 5 % of the
observations and each true corner has one within 10 cm; the hand rounds a corner over 8 cm, so that it never touches it.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run, sheet
from experiments.hand_held import CORNERS, round_the_square
from experiments.hand_held_picture import draw_flight, draw_misses, draw_recording, draw_subgoals
from experiments.hand_held_study import QUICK_SEEDS, SEEDS, Flown, Learned, flown, learn, misses, over_seeds, stages

NEAR = 0.1
"""Metres."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every seed is shown, learned and flown."""
    seeds = range(options.seed, options.seed + (QUICK_SEEDS if options.quick else SEEDS))
    every = over_seeds(seeds, one)
    worst = [float(misses(learned.places, CORNERS).max()) for learned, _ in every]
    counts = [len(learned.main) for learned, _ in every]
    headline: Headline = {
        "seeds": len(seeds),
        "seeds_correct": sum(k == len(CORNERS) and miss <= NEAR for k, miss in zip(counts, worst, strict=True)),
        "n_subgoals": counts,
        "largest_corner_error": max(worst),
        "tracking_rmse": float(np.median([flight.tracking.rmse for _, flight in every])),
        "tracking_rmse_largest": max(flight.tracking.rmse for _, flight in every),
        "flights": [flight.flight.status.name for _, flight in every],
        "seconds_from_file_to_flight": stages([{**learned.seconds, **flight.seconds} for learned, flight in every]),
        "status": [learned.posterior.status.name for learned, _ in every],
    }
    return headline, picture(seeds[0], *every[0], worst, headline)


def one(seed: int) -> tuple[Learned, Flown]:
    """Shown, learned, flown."""
    learned = learn(round_the_square(seed), seed)
    return learned, flown(learned)


def picture(seed: int, learned: Learned, flight: Flown, worst: list[float], headline: Headline) -> Figure:
    """The first seed from the hand to the flight, and how far off each seed is."""
    figure = sheet(12.0, 9.6)
    axes = figure.subplots(2, 2)
    draw_recording(axes[0, 0], round_the_square(seed), learned)
    draw_subgoals(axes[0, 1], learned, CORNERS)
    axes[0, 1].set_title("Subgoals and what serves them; crosses: corners")
    draw_flight(axes[1, 0], learned, flight)
    axes[1, 0].set_title(f"Flown through the subgoals: {100 * flight.tracking.rmse:.1f} cm from the hand (RMS)")
    title = f"{headline['seeds_correct']} of {headline['seeds']} seeds right: the corner that is found worst"
    draw_misses(axes[1, 1], worst, NEAR, title, "distance (m)")
    total = headline["seconds_from_file_to_flight"]["total"]
    figure.suptitle(f"A square shown by hand, learned and flown: {total:.1f} s from the file to the flight", x=0.01,
                    ha="left")  # fmt: skip
    return figure


if __name__ == "__main__":
    run("fig_7_2", experiment)
