"""What a progress display foretells, and from when on."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from subgoal.runtime.progress import Bar, Lines, Progress


@pytest.fixture
def at(monkeypatch: pytest.MonkeyPatch):
    """Updates of a display at seconds of a clock of our own."""
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr("subgoal.runtime.progress.time", SimpleNamespace(monotonic=lambda: clock.now))

    def updated(display: Progress, *updates: tuple[float, int]) -> None:
        with display:
            for clock.now, done in updates:
                display.update(done, 44_000)
        clock.now = 0.0

    return updated


def told(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return [line.strip() for line in capsys.readouterr().err.splitlines()]


def test_the_first_step_foretells_nothing(at, capsys) -> None:
    at(Lines("sampling"), (57.0, 4))
    assert told(capsys) == ["sampling: 4/44000"]


@pytest.mark.parametrize("start", [[], [(0.0, 0)]])
def test_the_rate_is_that_after_the_first_step(at, capsys, start) -> None:
    at(Lines("sampling"), *start, (57.0, 4), (67.0, 4_004))
    assert told(capsys) == ["sampling: 4/44000", "sampling: 4004/44000, 400/s, 100 s left"]


def test_a_moment_after_the_first_step_foretells_nothing(at, capsys) -> None:
    at(Lines("sampling"), (9.0, 4), (10.5, 36))
    assert told(capsys) == ["sampling: 36/44000"]


def test_no_rate_is_told_while_nothing_is_done(at, capsys) -> None:
    at(Lines("sampling"), (57.0, 4), (70.0, 4))
    assert told(capsys) == ["sampling: 4/44000"] * 2


def test_what_was_done_before_is_no_part_of_the_rate(at, capsys) -> None:
    at(Lines("sampling"), (1.0, 40_000), (11.0, 42_000))
    assert told(capsys) == ["sampling: 42000/44000, 200/s, 10 s left"]


def test_uneven_steps_foretell_nothing(at, capsys) -> None:
    at(Lines("comparing", even=False), (1.0, 4), (21.0, 4_004))
    assert told(capsys) == ["comparing: 4004/44000"]


def test_a_display_begins_anew(at, capsys) -> None:
    display = Lines("sampling")
    at(display, (1.0, 4), (11.0, 4_004))
    at(display, (31.0, 4))
    assert told(capsys)[1] == "sampling: 4/44000"


def test_the_bar_tells_the_same_rate(at) -> None:
    rates = []
    bar = Bar("sampling")
    bar._display.update = lambda *task, rate, **more: rates.append(rate)  # type: ignore[method-assign]
    at(bar, (57.0, 4), (58.0, 8), (67.0, 4_004))
    assert rates == ["", "", "400/s"]
