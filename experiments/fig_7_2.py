"""Figure 7-2: a square shown with a quadrotor in the hand, its four corners found, and flown.

A hand goes once round a square of 1.5 m (``hand_held``). A seed is right when exactly four subgoals hold 5 % of the
observations and each true corner has one within 10 cm; the hand rounds a corner over 8 cm, so that it never touches it.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.hand_held import CORNERS, round_the_square
from experiments.hand_held_picture import corners_sheet
from experiments.hand_held_study import (
    NEAR,
    QUICK_SEEDS,
    SEEDS,
    Flown,
    Learned,
    flown,
    learn,
    misses,
    over_seeds,
    stages,
)


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
    total = headline["seconds_from_file_to_flight"]["total"]
    titles = (
        f"Flown through the subgoals: {100 * flight.tracking.rmse:.1f} cm from the hand (RMS)",
        f"{headline['seeds_correct']} of {headline['seeds']} seeds right: the corner that is found worst",
        f"A square shown by hand, learned and flown: {total:.1f} s from the file to the flight",
    )
    return corners_sheet(round_the_square(seed), learned, learned, flight, worst, titles)


if __name__ == "__main__":
    run("fig_7_2", experiment)
