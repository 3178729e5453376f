"""Threads: lanes do not wait for one another, and nothing holds the end of the process up."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable

from subgoal.teach.workshop import Lane, Workshop

LONG = 10.0


def run(work: Callable[[Workshop, threading.Event], Awaitable[None]]) -> None:
    """With a workshop and an event that is set at the end."""

    async def worked() -> None:
        workshop, released = Workshop(), threading.Event()
        try:
            await asyncio.wait_for(work(workshop, released), LONG)
        finally:
            released.set()
            workshop.close()

    asyncio.run(worked())


def test_flights_hold_up_no_other_lanes() -> None:
    async def worked(workshop: Workshop, released: threading.Event) -> None:
        flights = [asyncio.create_task(workshop.do(Lane.FLIGHT, released.wait)) for _ in range(20)]
        await asyncio.sleep(0)
        assert await workshop.do(Lane.WAITED_FOR, int, "7") == 7
        for flight in flights:
            flight.cancel()

    run(worked)


def test_what_is_cancelled_before_its_turn_is_left_out() -> None:
    done = []

    async def worked(workshop: Workshop, released: threading.Event) -> None:
        first = asyncio.create_task(workshop.do(Lane.FLIGHT, released.wait))
        second = asyncio.create_task(workshop.do(Lane.FLIGHT, done.append, 2))
        await asyncio.sleep(0)
        second.cancel()
        await asyncio.sleep(0)
        released.set()
        await first
        await workshop.do(Lane.FLIGHT, done.append, 3)

    run(worked)
    assert done == [3]


def test_threads_do_not_hold_up_the_end_of_the_process() -> None:
    before = set(threading.enumerate())
    workshop = Workshop()
    made = set(threading.enumerate()) - before
    workshop.close()
    assert {thread.daemon for thread in made} == {True}


def test_threads_end_when_the_workshop_closes() -> None:
    before = set(threading.enumerate())
    workshop = Workshop()
    made = set(threading.enumerate()) - before
    workshop.close()
    for thread in made:
        thread.join(LONG)
        assert not thread.is_alive()
