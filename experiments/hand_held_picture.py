"""How the figures of hand-held demonstrations are drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from experiments.common import GREY, INK, PALETTE, sheet
from experiments.hand_held import CORNERS
from experiments.hand_held_study import NEAR, Flown, Learned
from subgoal.answers.segments import OTHER, segments
from subgoal.demonstrations.records import Recording
from subgoal.runtime.checks import Floats


def corners_sheet(
    recording: Recording, learned: Learned, shown: Learned, flown: Flown, worst: Sequence[float], titles: Sequence[str]
) -> Figure:
    """What was ``learned`` of a recording, what was ``shown`` and flown, and the farthest corner of each seed.

    ``titles`` are of the flight, of the seeds, and of the whole.
    """
    figure = sheet(12.0, 9.6)
    axes = figure.subplots(2, 2)
    draw_recording(axes[0, 0], recording, learned)
    draw_subgoals(axes[0, 1], learned, CORNERS)
    axes[0, 1].set_title("Subgoals and what serves them; crosses: corners")
    draw_flight(axes[1, 0], shown, flown)
    axes[1, 0].set_title(titles[0])
    draw_misses(axes[1, 1], worst, titles[1])
    figure.suptitle(titles[2], x=0.01, ha="left")
    return figure


def draw_recording(axes: Axes, recording: Recording, learned: Learned) -> None:
    """The hand as the room saw it, and what is left of it after down-sampling."""
    axes.plot(*recording.positions[:, :2].T, color=GREY, lw=0.7)
    states = np.asarray(learned.demonstrations.states)
    axes.plot(*states[:, :2].T, ".", color=INK, ms=2.5)
    axes.plot(*recording.positions[0, :2], "o", color=INK, ms=6)
    rate = len(recording.times) / np.ptp(recording.times)
    axes.set_title(f"The hand: {rate:.0f} Hz (grey), {len(states)} pairs at 20 Hz")
    frame(axes)


def draw_subgoals(axes: Axes, learned: Learned, corners: Floats | None = None) -> None:
    """Pairs in the colour of their subgoal; discs where these are, as large as their share; crosses at the corners."""
    states = np.asarray(learned.demonstrations.states)
    label = segments(learned.posterior, found=learned.found).labels
    axes.plot(*states[label == OTHER, :2].T, ".", color=GREY, ms=4)
    for k, goal in enumerate(learned.main):
        colour = PALETTE[k % len(PALETTE)]
        axes.plot(*states[label == k, :2].T, ".", color=colour, ms=4)
        axes.plot(*goal.position[:2], "o", color=colour, mec="white", ms=17, zorder=4)
        axes.annotate(
            str(k + 1), tuple(goal.position[:2]), color="white", ha="center", va="center", weight="bold", zorder=7
        )
    if corners is not None:
        axes.plot(*corners.T, "+", color=INK, ms=15, mew=1.4, zorder=6)
    frame(axes)


def draw_flight(axes: Axes, learned: Learned, flown: Flown) -> None:
    """The flown path over the hand's, with the waypoints."""
    axes.plot(*np.asarray(learned.demonstrations.states)[:, :2].T, color=INK, lw=1.0, label="hand")
    axes.plot(*flown.flight.positions[:, 1:].T, color=PALETTE[1], lw=1.8, label="quadrotor")
    places = flown.waypoints.positions
    axes.plot(*places[:, :2].T, "s", color=PALETTE[0], mec="white", ms=9, label="waypoints", zorder=4)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3)
    frame(axes)


def draw_misses(axes: Axes, values: Sequence[float], title: str) -> None:
    """One distance per seed, below the one that it has to keep."""
    axes.bar(range(len(values)), values, color=[PALETTE[0] if v <= NEAR else PALETTE[1] for v in values])
    axes.axhline(NEAR, color=PALETTE[1], lw=1.2)
    axes.annotate("accepted below", (len(values) - 0.5, NEAR), xytext=(0, 3), textcoords="offset points", ha="right",
                  color=PALETTE[1])  # fmt: skip
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set(title=title, xlabel="seed", ylabel="distance (m)", ylim=(0, NEAR * 1.25))


def frame(axes: Axes) -> None:
    """Metres alike in both directions."""
    axes.set_aspect("equal")
    axes.set(xlabel="y (m)", ylabel="z (m)")
    axes.margins(0.12)
