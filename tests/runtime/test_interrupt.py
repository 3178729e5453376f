"""Ctrl-C as a request, also when what asked for it was called by something that asks too."""

from __future__ import annotations

import signal

import pytest

from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Noted, Silent


def test_a_request_reaches_whoever_called() -> None:
    usual = signal.getsignal(signal.SIGINT)
    with Interrupt() as outer:
        with Interrupt() as middle:
            with Interrupt() as inner:
                signal.raise_signal(signal.SIGINT)
            assert (inner.requested, middle.requested, outer.requested) == (True, True, True)
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        assert not Interrupt().requested
    assert signal.getsignal(signal.SIGINT) is usual


def test_what_is_over_learns_of_nothing() -> None:
    with Interrupt() as outer:
        with Interrupt() as before:
            pass
        signal.raise_signal(signal.SIGINT)
    assert outer.requested
    assert not before.requested


def test_notes_stand_before_those_of_the_work() -> None:
    told = []

    class Heard(Silent):
        def update(self, done: int, total: int, note: str = "") -> None:
            told.append((done, total, note))

    with Noted(Heard(), "round 2") as display:
        display.update(1, 3)
        display.update(2, 3, "slowly")
    assert told == [(1, 3, "round 2"), (2, 3, "round 2 slowly")]
