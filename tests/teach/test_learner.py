"""Answers keep up with the drawing: nobody waits for one that is no longer asked for."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

from subgoal.teach.drawing import Drawing
from subgoal.teach.learner import IDLE, Learner, _work
from subgoal.teach.learning import Tuning
from subgoal.teach.limits import Limits
from subgoal.teach.live import Live
from subgoal.teach.messages import RefusedError
from subgoal.teach.workshop import Lane
from tests.teach.made import square

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")
LONG = 5.0
SQUARE = tuple(square())
LATER = tuple((t + 20, y, z) for t, y, z in SQUARE)


class Stuck:
    """A workshop in which what is asked for in some lanes never comes; ``meanwhile`` happens during the first work."""

    def __init__(self, *stuck: Lane) -> None:
        self.stuck, self.asked, self.left = stuck, [], 0
        self.meanwhile: list[Callable[[], None]] = []

    async def do(self, lane: Lane, work: Callable[..., Any], *arguments: Any) -> Any:
        self.asked.append(lane)
        try:
            if lane in self.stuck:
                await asyncio.Event().wait()
            await asyncio.sleep(0)
        except asyncio.CancelledError:
            self.left += 1
            raise
        found = work(*arguments)
        while self.meanwhile:
            self.meanwhile.pop()()
        return found


class Hand:
    """Draws, and hears what the learner says."""

    def __init__(self, *stuck: Lane) -> None:
        self.drawing, self.workshop, self.said = Drawing(Limits()), Stuck(*stuck), asyncio.Queue()
        self.learner = Learner(self.drawing, Limits(), self.workshop, Path("nowhere"), self.said.put_nowait)  # type: ignore[arg-type]
        self.number = 0

    def do(self, kind: str, *arguments: Any) -> None:
        getattr(self.drawing, kind)(*arguments)
        self.number += 1
        self.learner.look(self.number)

    async def stages(self, last: str) -> list[str]:
        """Of the answers until the one of that stage."""
        heard = []
        while last not in heard:
            message = await asyncio.wait_for(self.said.get(), LONG)
            heard.append(message.get("stage", message["type"]))
        return heard


def run(hand: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(hand())


def test_after_pen_up_comes_the_quick_answer_and_then_that_of_the_default_run() -> None:
    async def drawn() -> None:
        hand = Hand()
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        assert (await hand.stages("full"))[-2:] == ["settled", "full"]
        assert hand.workshop.asked[-2:] == [Lane.WAITED_FOR, Lane.IDLE]

    run(drawn)


def test_pen_up_does_not_wait_for_an_answer_to_the_open_stroke() -> None:
    async def drawn() -> None:
        hand = Hand(Lane.MEANWHILE)
        hand.do("begin")
        hand.do("add", SQUARE)
        await asyncio.sleep(0.01)
        assert hand.workshop.asked == [Lane.MEANWHILE]
        hand.do("lift")
        assert await hand.stages("settled") == ["settled"]
        assert hand.workshop.left == 1

    run(drawn)


def test_nothing_waits_for_a_default_run_and_it_is_left_when_one_draws_on() -> None:
    async def drawn() -> None:
        hand = Hand(Lane.IDLE)
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        await hand.stages("settled")
        await asyncio.sleep(2 * IDLE)
        assert hand.workshop.asked[-1] == Lane.IDLE
        for kind, *given in (("begin",), ("add", LATER), ("lift",)):
            hand.do(kind, *given)
        await hand.stages("settled")
        assert hand.workshop.left == 1

    run(drawn)


def test_an_answer_to_what_has_changed_since_is_not_said() -> None:
    async def drawn() -> None:
        hand = Hand()
        hand.workshop.meanwhile.append(lambda: hand.do("clear"))
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        message = await asyncio.wait_for(hand.said.get(), LONG)
        assert (message["number"], message["subgoals"]) == (hand.number, [])

    run(drawn)


def test_the_same_again_is_not_learned_again() -> None:
    async def drawn() -> None:
        hand = Hand()
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        await hand.stages("full")
        asked = len(hand.workshop.asked)
        hand.learner.look(hand.number + 1)
        await asyncio.sleep(0.05)
        assert len(hand.workshop.asked) == asked

    run(drawn)


def test_one_flight_is_prepared_at_a_time_and_left_when_the_drawing_changes() -> None:
    async def drawn() -> None:
        hand = Hand(Lane.FLIGHT)
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        await hand.stages("full")
        hand.learner.fly()
        hand.learner.look(hand.number)
        with pytest.raises(RefusedError, match="being prepared"):
            hand.learner.fly()
        while Lane.FLIGHT not in hand.workshop.asked:
            await asyncio.sleep(0)
        hand.do("clear")
        message = await asyncio.wait_for(hand.said.get(), LONG)
        assert (message["code"], "left" in message["text"]) == ("cannot", True)
        await asyncio.sleep(0)
        assert hand.workshop.left == 1

    run(drawn)


def test_what_was_changed_before_its_turn_is_not_learned_from() -> None:
    drawing = Drawing(Limits())
    drawing.begin()
    drawing.add(SQUARE)
    found = _work(drawing.sheet(), Tuning(), "settled", 1, Limits(), Live(), lambda: False)
    assert found == (None, None)


def test_what_fails_here_is_told_and_the_next_drawing_is_learned() -> None:
    async def drawn() -> None:
        hand = Hand()
        working = hand.workshop.do
        hand.workshop.do = broken  # type: ignore[method-assign]
        for kind, *given in (("begin",), ("add", SQUARE), ("lift",)):
            hand.do(kind, *given)
        message = await asyncio.wait_for(hand.said.get(), LONG)
        assert message["code"] == "failed"
        hand.workshop.do = working  # type: ignore[method-assign]
        for kind, *given in (("begin",), ("add", LATER), ("lift",)):
            hand.do(kind, *given)
        assert (await hand.stages("settled"))[-1] == "settled"

    async def broken(*_: Any) -> Any:
        raise RuntimeError("a bug")

    run(drawn)
