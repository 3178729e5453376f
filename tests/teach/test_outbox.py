"""What waits to be sent."""

from __future__ import annotations

import asyncio
from typing import Any

from subgoal.teach.outbox import MOST_WAITING, Outbox


def taken(*messages: dict[str, Any], close: bool = False) -> list[dict[str, Any]]:
    async def all_of_it() -> list[dict[str, Any]]:
        outbox = Outbox()
        for message in messages:
            outbox.put(message)
        if close:
            outbox.close()
            outbox.put({"type": "late"})
        return await outbox.take()

    return asyncio.run(all_of_it())


def test_of_answers_and_of_what_is_done_only_the_newest_is_sent() -> None:
    old, new = ({"type": "answer", "number": n} for n in (1, 2))
    done = [{"type": "done", "number": n} for n in (1, 2, 3)]
    assert taken(old, done[0], new, *done[1:]) == [new, done[2]]


def test_everything_else_is_sent_in_order() -> None:
    messages = [{"type": "error", "code": "a"}, {"type": "saved"}, {"type": "error", "code": "b"}]
    assert taken(*messages) == messages


def test_errors_that_nobody_reads_do_not_pile_up_but_the_rest_is_kept() -> None:
    errors = [{"type": "error", "code": str(k)} for k in range(2 * MOST_WAITING)]
    found = taken(*errors, {"type": "saved"})
    assert len(found) == MOST_WAITING + 1
    assert found[-1] == {"type": "saved"}


def test_what_waits_is_still_sent_when_it_is_closed_and_then_nothing() -> None:
    assert taken({"type": "saved"}, close=True) == [{"type": "saved"}]
    assert taken(close=True) == []
