"""Figure 7-3: random hops between four corners; the subgoals are the four corners, whatever the order.

40 to 100 hops along sides and diagonals, by a hand as in Figure 7-2. A seed is right when exactly four subgoals hold
5 % of the observations; how far they are from the corners is told beside. The first hops are flown, in the order of the
visits.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.hand_held import CORNERS, hops
from experiments.hand_held_picture import corners_sheet
from experiments.hand_held_study import QUICK_SEEDS, SEEDS, Flown, Learned, flown, learn, misses, over_seeds, stages
from subgoal.demonstrations.records import Recording
from subgoal.runtime.seeds import stream

FEWEST, MOST = 40, 100
"""Hops."""
SAMPLING = {"draws": 400, "warmup": 400, "thin": 5}
"""A tenth of the default draws; there are thousands of pairs."""
FLOWN = 12
"""Hops that are flown."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every seed is learned; the first hops of the first are flown."""
    seeds = range(options.seed, options.seed + (QUICK_SEEDS if options.quick else SEEDS))
    every = over_seeds(seeds, lambda seed: learn(shown(seed), seed, **SAMPLING))
    worst = [float(misses(learned.places, CORNERS).max()) for learned in every]
    counts = [len(learned.main) for learned in every]
    first = learn(beginning(seeds[0]), seeds[0])
    flight = flown(first, visits=True)
    headline: Headline = {
        "seeds": len(seeds),
        "seeds_correct": sum(k == len(CORNERS) for k in counts),
        "n_subgoals": counts,
        "hops": [legs(seed) for seed in seeds],
        "pairs": [learned.posterior.n_observations for learned in every],
        "largest_corner_error": max(worst),
        "tracking_rmse": flight.tracking.rmse,
        "flight": flight.flight.status.name,
        "waypoints_flown": len(flight.waypoints.positions),
        "seconds_from_file_to_subgoals": stages([learned.seconds for learned in every]),
        "status": [learned.posterior.status.name for learned in every],
    }
    return headline, picture(shown(seeds[0]), every[0], first, flight, worst, headline)


def legs(seed: int) -> int:
    """How many hops a seed has."""
    return int(stream(seed, 74).integers(FEWEST, MOST + 1))


def shown(seed: int) -> Recording:
    """The whole demonstration."""
    return hops(seed, legs(seed))[0]


def beginning(seed: int) -> Recording:
    """A shorter one, to be flown."""
    return hops(seed, FLOWN)[0]


def picture(
    recording: Recording, learned: Learned, first: Learned, flight: Flown, worst: list[float], headline: Headline
) -> Figure:
    """The first seed, the flight of its first hops, and how far off each seed is."""
    titles = (
        f"{FLOWN} hops, flown in the order shown: {100 * flight.tracking.rmse:.1f} cm (RMS)",
        f"Exactly four in {headline['seeds_correct']} of {headline['seeds']} seeds: the corner found worst",
        f"{headline['hops'][0]} random hops between four corners: {headline['n_subgoals'][0]} subgoals",
    )
    return corners_sheet(recording, learned, first, flight, worst, titles)


if __name__ == "__main__":
    run("fig_7_3", experiment)
