"""Every size and rate that the server holds its visitors to, in one record."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What one message, one drawing and one server may amount to.

    Attributes
    ----------
    message_bytes, file_bytes:
        Largest message of text, and largest file.
    batch_points:
        Points in one message.
    points_per_second, points_at_once:
        Points that a session may send for ever, and beyond that in one go (after a reconnection, say).
    messages_per_second, messages_at_once:
        The same, of messages.
    points, strokes:
        Of one drawing; a file has at most as many samples and trajectories.
    pairs:
        State-action pairs that are learned from.
    reach:
        Largest coordinate of a drawn point, metres.
    seconds:
        Latest time of a drawn point, since its session began.
    sessions:
        Kept at once. Beyond that the one that was left longest ago makes room, first of those in which nothing was
        done; if none was left, a new one is refused.
    flight_seconds:
        Longest flight that is simulated.
    take_over_seconds:
        How long a page that was loaded anew waits for the one before it to go.
    """

    message_bytes: int = 64 * 1024
    file_bytes: int = 16 * 1024**2
    batch_points: int = 1_000
    points_per_second: float = 1_000.0
    points_at_once: int = 5_000
    messages_per_second: float = 200.0
    messages_at_once: int = 1_000
    points: int = 20_000
    strokes: int = 200
    pairs: int = 5_000
    reach: float = 100.0
    seconds: float = 1e6
    sessions: int = 64
    flight_seconds: float = 120.0
    take_over_seconds: float = 1.5


class Allowance:
    """A bucket that fills at ``rate`` per second up to ``most``; what is asked beyond it is refused."""

    def __init__(self, rate: float, most: float) -> None:
        self._rate, self._most = rate, most
        self._left, self._when = most, 0.0

    def wait(self, amount: float, now: float) -> float:
        """0 where ``amount`` is taken; else the seconds after which it could be, and nothing is taken."""
        self._left = min(self._most, self._left + self._rate * max(0.0, now - self._when))
        self._when = now
        if amount <= self._left:
            self._left -= amount
            return 0.0
        return (amount - self._left) / self._rate
