"""What ends a run between two rounds, and what is passed on."""

from __future__ import annotations

import os
import signal
from concurrent.futures import BrokenExecutor
from typing import Any

import pytest

from subgoal.posterior.sample import _advance
from subgoal.runtime.progress import Silent


class Failing:
    """Rounds that fail, after Ctrl-C or without it."""

    def __init__(self, failure: BaseException, *, after_ctrl_c: bool) -> None:
        self._failure, self._after_ctrl_c = failure, after_ctrl_c

    def advance(self, records: list[Any]) -> bool:
        if self._after_ctrl_c:
            os.kill(os.getpid(), signal.SIGINT)
        raise self._failure


def run(failure: BaseException, *, after_ctrl_c: bool) -> None:
    _advance(Failing(failure, after_ctrl_c=after_ctrl_c), [], None, Silent(), 1)  # type: ignore[arg-type]


def test_workers_that_ctrl_c_ended_end_the_run_and_not_with_an_error() -> None:
    assert run(BrokenExecutor("terminated"), after_ctrl_c=True) is None


@pytest.mark.parametrize("failure", [KeyboardInterrupt(), ValueError("wrong"), MemoryError()])
def test_a_second_ctrl_c_and_real_errors_are_passed_on(failure: BaseException) -> None:
    """In the middle of a round the streams have run on: nothing may be given or written from there."""
    with pytest.raises(type(failure)):
        run(failure, after_ctrl_c=True)


def test_workers_that_end_by_themselves_are_an_error() -> None:
    with pytest.raises(BrokenExecutor):
        run(BrokenExecutor("out of memory"), after_ctrl_c=False)
