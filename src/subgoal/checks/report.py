"""What was checked, what was measured and what would have been allowed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Found = tuple[bool | None, str]
"""Whether it passed (None: not run) and what was measured."""


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes
    ----------
    name:
        What was checked.
    passed:
        True, False, or None where it could not be run.
    measured:
        What was found, in words.
    threshold:
        What would have been allowed, in words.
    """

    name: str
    passed: bool | None
    measured: str
    threshold: str

    def __str__(self) -> str:
        mark = {True: "ok  ", False: "FAIL", None: "--  "}[self.passed]
        return f"{mark}  {self.name:<42}  {self.measured}  (allowed: {self.threshold})"


@dataclass(frozen=True, repr=False)
class Report:
    """All checks of one subject. Printed, it is a table."""

    subject: str
    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing failed; what could not be run does not count."""
        return not self.failures

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that failed."""
        return tuple(check for check in self.checks if check.passed is False)

    def __getitem__(self, name: str) -> Check:
        return {check.name: check for check in self.checks}[name]

    def __repr__(self) -> str:
        return f"Report({self._summary})"

    def __str__(self) -> str:
        return "\n".join([self._summary, *(f"  {check}" for check in self.checks)])

    @property
    def _summary(self) -> str:
        ran = sum(check.passed is not None for check in self.checks)
        left = len(self.checks) - ran
        return f"{self.subject}: {ran - len(self.failures)} of {ran} checks passed" + (f", {left} not run" * (left > 0))


def tried(name: str, threshold: str, measure: Callable[[], Found]) -> Check:
    """The check, failed with the error's own words if ``measure`` raises one."""
    try:
        passed, measured = measure()
    except Exception as problem:
        passed, measured = False, f"raised {type(problem).__name__}: {str(problem)[:200]}"
    return Check(name, passed, measured, threshold)
