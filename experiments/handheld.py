"""Recorded, not simulated: a Kinect moved by hand to and fro along three axes (TUM RGB-D, freiburg1_xyz).

The hand turns back 16 times, at six places. Everything is the default of the library, at 20 Hz; nothing says where a
turn is. A seed is right when each of the six places has a subgoal within 0.12 m and at most eight subgoals hold 5 % of
the observations. What was shown is flown, turn by turn.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from experiments.hand_held_study import RATE, Clock, Flown, Learned, stages
from subgoal.answers.segments import OTHER, segments
from subgoal.answers.subgoals import subgoals
from subgoal.candidates import epsilon_net
from subgoal.demonstrations.read import read
from subgoal.flight import fly, tracking, waypoints
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats

FILE = "freiburg1_xyz-groundtruth.txt"
TURNS = np.array([
    [1.08, 0.64, 1.34], [1.42, 0.64, 1.76], [1.29, 0.95, 1.58], [1.25, 0.29, 1.57], [1.02, 0.59, 1.66],
    [1.44, 0.56, 1.41],
])  # fmt: skip
"""The six places, metres; each is a mean of turns that lie up to 0.1 m apart."""
NEAR, MOST = 0.12, 8
SEEDS, QUICK_SEEDS = 25, 3
VIEWS = ((0, 1), (0, 2))


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The recording is learned with several seeds, and flown once."""
    seeds = range(options.seed, options.seed + (QUICK_SEEDS if options.quick else SEEDS))
    path = options.recordings / FILE
    every = [learn(path, seed) for seed in seeds]
    off = np.array([distances(learned.places) for learned in every])
    counts = [len(learned.main) for learned in every]
    flight = flown(every[0])
    headline: Headline = {
        "seeds": len(seeds),
        "seeds_correct": sum(k <= MOST and miss <= NEAR for k, miss in zip(counts, off.max(axis=1), strict=True)),
        "n_subgoals": counts,
        "distance_of_turns": off.max(axis=0),
        "tracking_rmse": flight.tracking.rmse,
        "flight": flight.flight.status.name,
        "waypoints_flown": len(flight.waypoints.positions),
        "seconds_from_file_to_flight": stages([{**every[0].seconds, **flight.seconds}]),
        "status": [learned.posterior.status.name for learned in every],
    }
    return headline, picture(every[0], flight, headline)


def learn(path: Path, seed: int) -> Learned:
    """From the file to subgoals, with nothing set but the rate."""
    clock = Clock()
    demos = read(path, rate=RATE)
    clock.lap("read")
    likelihood = action_comparison(demos, epsilon_net(demos))
    clock.lap("table")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(likelihood, seed=seed)
    clock.lap("sample")
    found = subgoals(posterior)
    clock.lap("subgoals")
    return Learned(demos, posterior, found, clock.seconds)


def flown(learned: Learned) -> Flown:
    """In space, from turn to turn as they were made."""
    clock = Clock()
    route = waypoints(learned.posterior, found=learned.found, visits=True)
    clock.lap("waypoints")
    flight = fly(route)
    clock.lap("fly")
    return Flown(route, flight, tracking(flight, learned.demonstrations), clock.seconds)


def distances(places: Floats) -> Floats:
    """(6,) from each turning place to the nearest subgoal, metres."""
    return np.asarray(np.linalg.norm(places[:, None] - TURNS, axis=-1).min(axis=0))


def picture(learned: Learned, flight: Flown, headline: Headline) -> Figure:
    """The recording from above and from the side, over time, and the flight."""
    figure = sheet(12.5, 9.6)
    grid = figure.add_gridspec(2, 2)
    for k, view in enumerate(VIEWS):
        places(figure.add_subplot(grid[0, k]), learned, view)
    over_time(figure.add_subplot(grid[1, 0]), learned)
    axes = figure.add_subplot(grid[1, 1])
    axes.plot(*np.asarray(learned.demonstrations.states)[:, [0, 2]].T, color=INK, lw=0.9, label="hand")
    axes.plot(*flight.flight.positions[:, [0, 2]].T, color=PALETTE[1], lw=1.5, label="quadrotor")
    axes.legend()
    axes.set_aspect("equal")
    axes.set(title=f"Flown, {flight.tracking.rmse:.2f} m from the hand (RMS)", xlabel="x (m)", ylabel="z (m)")
    figure.suptitle(
        f"A camera moved by hand: its six turning places among {headline['n_subgoals'][0]} subgoals", x=0.01, ha="left"
    )
    return figure


def places(axes: Axes, learned: Learned, view: tuple[int, int]) -> None:
    """Two coordinates of the pairs in the colours of their subgoals, with the turning places as crosses."""
    states, columns = np.asarray(learned.demonstrations.states), list(view)
    label = segments(learned.posterior, found=learned.found).labels
    axes.plot(*states[label == OTHER][:, columns].T, ".", color=GREY, ms=3)
    for k, goal in enumerate(learned.main):
        axes.plot(*states[label == k][:, columns].T, ".", color=PALETTE[k % 8], ms=3)
        axes.plot(*goal.position[columns], "o", color=PALETTE[k % 8], mec="white", ms=16, zorder=4)
        axes.annotate(str(k + 1), tuple(goal.position[columns]), color="white", ha="center", va="center", zorder=5)
    axes.plot(*TURNS[:, columns].T, "+", color=INK, ms=14, mew=1.4, zorder=6)
    axes.set_aspect("equal")
    seen = "from above" if view == (0, 1) else "from the side"
    axes.set(title=f"Subgoals {seen}; crosses: where the hand turned", xlabel="x (m)", ylabel=f"{'xyz'[view[1]]} (m)")


def over_time(axes: Axes, learned: Learned) -> None:
    """Each coordinate over time, and the subgoal that each moment serves."""
    demos = learned.demonstrations
    times, states = np.asarray(demos.times, float), np.asarray(demos.states)
    seconds = times - times[0]
    label = segments(learned.posterior, found=learned.found).labels
    for k in range(3):
        axes.plot(seconds, states[:, k], color=GREY, lw=0.8)
        axes.scatter(seconds, states[:, k], s=4, c=[PALETTE[g % 8] if g != OTHER else GREY for g in label], zorder=3)
        axes.annotate("xyz"[k], (seconds[-1], states[-1, k]), xytext=(4, 0), textcoords="offset points", va="center")
    axes.set(title="Which subgoal each moment serves", xlabel="time (s)", ylabel="position (m)")


if __name__ == "__main__":
    run("handheld", experiment, needs="tum_rgbd_handheld")
