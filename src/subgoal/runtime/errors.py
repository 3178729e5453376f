"""Typed errors: every message says what, where, what was found, what was wanted and what to try."""

from __future__ import annotations

from functools import partial
from typing import Any


class SubgoalError(Exception):
    """Base of everything this library raises on purpose. It travels between processes with all that it says."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[SubgoalError], arguments: tuple[Any, ...], said: dict[str, Any]) -> SubgoalError:
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(said)
    return error


class InputError(SubgoalError, ValueError):
    """An argument or a data file is not what it should be.

    Parameters
    ----------
    what:
        The argument, column or file at fault, in the caller's words.
    found, wanted:
        What was there and what should have been.
    where:
        Place inside the input (row, column, index), if there is one.
    hint:
        What to try next, if that is known.
    """

    def __init__(
        self, what: str, *, found: Any, wanted: str, where: str | None = None, hint: str | None = None
    ) -> None:
        self.what, self.found, self.wanted, self.where, self.hint = what, found, wanted, where, hint
        place = f" at {where}" if where else ""
        advice = f" Try: {hint}." if hint else ""
        super().__init__(f"{what}{place}: found {found}, wanted {wanted}.{advice}")


def data_row(row: int) -> str:
    """A row of a file in words: ``row`` counts from 0, people count from 1 and leave the header out."""
    return f"data row {row + 1}, counted from 1"


class ReadError(InputError):
    """A file cannot be read as what it is said to be."""


class StorageError(InputError):
    """A file written by this library is torn, of another version or not ours."""


class BudgetError(SubgoalError, MemoryError):
    """The predicted memory of a request is above the stated budget; nothing was allocated."""

    def __init__(self, what: str, *, needed: float, budget: float, hint: str) -> None:
        self.what, self.needed, self.budget, self.hint = what, needed, budget, hint
        super().__init__(
            f"{what}: would need {needed / 2**20:,.0f} MiB, the budget is {budget / 2**20:,.0f} MiB. Try: {hint}."
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.what, needed=self.needed, budget=self.budget, hint=self.hint), ()


class PlanningError(SubgoalError):
    """A planner did not reach its tolerance; the message says how far it came and what to try."""


class StoppedError(SubgoalError):
    """The run was stopped before it had anything to give."""


class MissingExtraError(SubgoalError, ImportError):
    """An optional dependency is not installed."""

    def __init__(self, package: str, extra: str) -> None:
        super().__init__(f"{package} is not installed. Try: pip install 'subgoal[{extra}]'.")
