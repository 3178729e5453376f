"""Demonstrations by hand of a quadrotor that is switched off (thesis 7.2), as a motion-capture room would record them.

What the hand does: it goes at a steady speed from corner to corner and rounds each; it trembles at 8 to 12 Hz. What the
room adds: white noise of position and angle. Nothing here knows the library's models.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

SIDE = 1.5
"""Metres."""
FLOOR = 0.5
"""Height of the lowest point, metres."""
CORNERS = SIDE * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) + [-SIDE / 2, FLOOR]
"""Of the square, in the plane (y, z) of the hand."""
HALF_WIDTH, HALF_HEIGHT = 0.075, 0.5
"""Of the flip, metres."""
TURN = 2 * np.pi


@dataclass(frozen=True)
class Hand:
    """How a hand moves and how well it is seen.

    Attributes
    ----------
    speed:
        m/s along the path.
    rounding:
        A corner is rounded from so many metres before it to so many after it.
    tremor, band:
        Root mean square of each coordinate in metres, and the band it lies in, Hz.
    noise, angle_noise:
        Standard deviations of a measured coordinate (m) and of the measured angle (rad).
    rate:
        Poses a second.
    """

    speed: float = 0.4
    rounding: float = 0.08
    tremor: float = 0.005
    band: tuple[float, float] = (8.0, 12.0)
    noise: float = 0.001
    angle_noise: float = 0.01
    rate: float = 100.0


HAND = Hand()


def through(corners: Floats, hand: Hand = HAND) -> Floats:
    """(M, 2) positions ``1/rate`` seconds apart on the way through ``corners`` (W, 2), each but the ends rounded.

    Where the way goes straight on or straight back there is nothing to round.
    """
    ways = np.diff(corners, axis=0)
    unit = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    pieces = [corners[:1]]
    for k in range(1, len(corners) - 1):
        before, after = corners[k] - hand.rounding * unit[k - 1], corners[k] + hand.rounding * unit[k]
        pieces.append(arc(before, corners[k], after))
    pieces.append(corners[-1:])
    return walked(np.concatenate(pieces), hand)[0]


def walked(points: Floats, hand: Hand) -> tuple[Floats, Floats]:
    """(M, 2) positions ``1/rate`` seconds apart along ``points``, and (M,) which share of the way lies behind each."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.arange(0.0, length[-1], hand.speed / hand.rate)
    return np.stack([np.interp(at, length, column) for column in points.T], axis=1), at / length[-1]


def arc(before: Floats, corner: Floats, after: Floats, points: int = 60) -> Floats:
    """(points, 2) of the circle that touches both legs of a corner at ``before`` and ``after``."""
    into, out = corner - before, after - corner
    turn = float(np.arctan2(into[0] * out[1] - into[1] * out[0], into @ out))
    if abs(abs(turn) - np.pi) < 1e-6 or abs(turn) < 1e-6:
        return np.stack([before, corner, after])
    radius = np.linalg.norm(into) / np.tan(abs(turn) / 2)
    heading = np.arctan2(into[1], into[0])
    side = np.sign(turn)
    centre = before + side * radius * np.array([-np.sin(heading), np.cos(heading)])
    angle = heading - side * np.pi / 2 + np.linspace(0.0, turn, points)
    return np.asarray(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def recorded(path: Floats, angles: Floats, seed: int, hand: Hand = HAND, *, name: str) -> Recording:
    """Poses (y, z, angle) of a hand on ``path`` (M, 2) with ``angles`` (M,), trembling and measured."""
    generator = stream(seed, 72)
    poses = np.column_stack([path + trembling(len(path), generator, hand), angles])
    poses += generator.normal(size=poses.shape) * np.array([hand.noise, hand.noise, hand.angle_noise])
    times = np.arange(len(poses)) / hand.rate
    return Recording(
        positions=poses, times=times, offset=np.array([0, len(poses)]), names=("y", "z", "angle"), units="m",
        source=Source(name), period=(np.inf, np.inf, TURN),
    )  # fmt: skip


def trembling(samples: int, generator: np.random.Generator, hand: Hand = HAND) -> Floats:
    """(samples, 2) noise in the band, each coordinate with the root mean square of the hand."""
    second = int(hand.rate)
    white = generator.normal(size=(samples + 2 * second, 2))
    shaken = sosfiltfilt(butter(2, hand.band, "bandpass", fs=hand.rate, output="sos"), white, axis=0)
    return np.asarray(hand.tremor * (shaken / shaken.std(axis=0))[second : second + samples])


def round_the_square(seed: int, rounds: int = 1, hand: Hand = HAND) -> Recording:
    """Figure 7-2: from one corner round the square and back to it, level all the while."""
    order = np.arange(4 * rounds + 1) % 4
    path = through(CORNERS[order], hand)
    return recorded(path, np.zeros(len(path)), seed, hand, name="hand-held square")


def hops(seed: int, legs: int, hand: Hand = HAND) -> tuple[Recording, Ints]:
    """Figure 7-3: ``legs`` random hops between the four corners, and the corners (legs + 1,) in order."""
    generator = stream(seed, 73)
    order = np.cumsum(np.concatenate([generator.integers(4, size=1), generator.integers(1, 4, size=legs)])) % 4
    path = through(CORNERS[order], hand)
    return recorded(path, np.zeros(len(path)), seed, hand, name="hand-held hops"), order


def flip(seed: int, half_width: float = HALF_WIDTH, half_height: float = HALF_HEIGHT, hand: Hand = HAND) -> Recording:
    """Figure 7-4: up, over the top and down again, turning evenly along the way; level at both ends, inverted above.

    The way is an upright ellipse from its lowest point round to it.
    """
    turned = np.linspace(0.0, TURN, 20_000)
    ellipse = np.stack([half_width * np.sin(turned), half_height * (1 - np.cos(turned))], axis=1)
    path, share = walked(ellipse + np.array([0.0, FLOOR]), hand)
    return recorded(path, TURN * share, seed, hand, name="hand-held flip")
