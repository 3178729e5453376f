"""How much in how long."""

from __future__ import annotations

import pytest

from subgoal.teach.limits import Allowance


def test_what_is_taken_at_once_fills_again_with_time() -> None:
    allowance = Allowance(10.0, 30.0)
    assert allowance.wait(30, 100.0) == 0
    assert allowance.wait(20, 100.0) == pytest.approx(2.0)
    assert allowance.wait(20, 102.0) == 0


def test_a_refusal_takes_nothing() -> None:
    allowance = Allowance(10.0, 30.0)
    assert allowance.wait(40, 100.0) > 0
    assert allowance.wait(30, 100.0) == 0


def test_it_never_holds_more_than_its_most() -> None:
    allowance = Allowance(10.0, 30.0)
    assert allowance.wait(1, 0.0) == 0
    assert allowance.wait(31, 1e6) > 0
