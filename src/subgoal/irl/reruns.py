"""Records of a sensitivity analysis: the answer under one setting, and all of them as a table with a verdict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.answers.subgoals import Subgoal
from subgoal.irl.variations import AGAIN
from subgoal.posterior.diagnostics import Status
from subgoal.runtime.checks import Floats

SETTLED = 1.05


@dataclass(frozen=True, eq=False, repr=False)
class Rerun:
    """The answer under one setting, beside the S subgoals of the posterior that have at least 5 %.

    Attributes
    ----------
    setting, kind:
        In words, and what was changed: "as sampled", "again" (nothing), "concentration", "confidence", "weight",
        "rate".
    every:
        Every so-manieth observation was used.
    n_observations, worth:
        Observations used, and how many independent ones they count for.
    n_subgoals:
        Subgoals with at least 5 %.
    places, shares:
        (S, d) and (S,) of the same subgoals; NaN and 0 for one that is not found again.
    moved, change:
        (S,) distance from where they were, and share less what it was.
    persistence, concentration:
        Posterior means; NaN where the model has none.
    rhat, status:
        Largest R-hat of the gate's summaries, and its verdict.
    """

    setting: str
    kind: str
    every: int
    n_observations: int
    worth: float
    n_subgoals: int
    places: Floats
    shares: Floats
    moved: Floats
    change: Floats
    persistence: float
    concentration: float
    rhat: float
    status: Status

    def __repr__(self) -> str:
        return f"Rerun({self.setting!r}, {self.n_subgoals} subgoals)"

    @property
    def lost(self) -> int:
        """How many subgoals are not found again."""
        return int(np.isnan(self.moved).sum())

    @property
    def settled(self) -> bool:
        """Whether the chains agree well enough for the row to be believed: R-hat at most 1.05."""
        return self.rhat <= SETTLED

    @property
    def largest_move(self) -> float:
        """Of the subgoals that are found again; 0 if there are none."""
        return float(np.nanmax(np.append(self.moved, 0.0)))

    @property
    def largest_change(self) -> float:
        """Of any share, up or down."""
        return float(np.abs(self.change).max(initial=0.0))


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity:
    """The answer under one setting after another. Printed, it is a table.

    Attributes
    ----------
    top:
        The S subgoals of the posterior with at least 5 %.
    rows:
        The posterior itself first, then the reruns that were finished.
    left_out:
        Settings that were not run, because Ctrl-C came before.
    unit:
        Of the places.
    """

    top: tuple[Subgoal, ...]
    rows: tuple[Rerun, ...]
    left_out: tuple[str, ...]
    unit: str

    def __repr__(self) -> str:
        return f"Sensitivity({len(self.rows) - 1} reruns, {len(self.top)} subgoals)"

    def __str__(self) -> str:
        return "\n".join([self.verdict, *self.lines()])

    @property
    def reruns(self) -> tuple[Rerun, ...]:
        """All but the posterior itself and the mere repetition."""
        return tuple(row for row in self.rows[1:] if row.kind != AGAIN)

    @property
    def chance(self) -> Rerun | None:
        """The same settings again in a short run: what changes there is chance."""
        return next((row for row in self.rows if row.kind == AGAIN), None)

    @property
    def verdict(self) -> str:
        """What stays and what does not, in a sentence or two."""
        if not self.reruns:
            return "No other setting was tried."
        tried = f"{len(self.reruns)} other settings" if len(self.reruns) > 1 else "the other setting"
        number, counts = self.rows[0].n_subgoals, sorted({row.n_subgoals for row in self.reruns})
        told = f"stays {number}" if counts == [number] else f"is {number} here and {_range(counts)} elsewhere"
        lost = sum(row.lost > 0 for row in self.reruns)
        again = number if self.chance is None else self.chance.n_subgoals
        told += "" if again == number else f", and {again} by chance in a mere repetition"
        gone = f"; a subgoal is missing under {lost} of them" if lost else ""
        move = f"{max(row.largest_move for row in self.reruns):.3g} {self.unit}".rstrip()
        most = max(self.reruns, key=lambda row: row.largest_change)
        chance = "" if self.chance is None else f"; {100 * self.chance.largest_change:.1f} points are chance"
        loose = sum(not row.settled for row in self.reruns)
        has = "has" if loose == 1 else "have"
        unsure = f" {loose} of these short reruns {has} not settled (R-hat above {SETTLED})." if loose else ""
        base = "" if self.rows[0].settled else " The posterior itself has not settled."
        return (
            f"Under {tried} the number of subgoals {told}{gone}. Places move by at most {move}, shares by at most "
            f"{100 * most.largest_change:.1f} percentage points ({most.setting}{chance}).{unsure}{base}"
        )

    def lines(self) -> list[str]:
        """The table, a line for each setting, under one of heads."""
        heads = ("setting", "subgoals", "lost", "moved", "share ±", "persistence", "concentration", "worth", "R-hat")
        cells = [heads, *(_cells(row) for row in self.rows)]
        wide = [max(len(row[k]) for row in cells) for k in range(len(heads))]
        lines = ["  ".join(_padded(row, wide)).rstrip() for row in cells]
        return [*lines, *(f"{setting}  not run" for setting in self.left_out)]


def _cells(row: Rerun) -> tuple[str, ...]:
    number = "" if np.isnan(row.persistence) else f"{row.persistence:.3f}"
    return (
        row.setting, str(row.n_subgoals), str(row.lost or "–"), f"{row.largest_move:.3g}",
        f"{100 * row.largest_change:.1f} %", number, f"{row.concentration:.2g}", f"{row.worth:,.0f}",
        f"{row.rhat:.2f}",
    )  # fmt: skip


def _padded(row: tuple[str, ...], wide: list[int]) -> list[str]:
    return [
        cell.ljust(width) if k == 0 else cell.rjust(width)
        for k, (cell, width) in enumerate(zip(row, wide, strict=True))
    ]


def _range(values: list[int]) -> str:
    return str(values[0]) if len(values) == 1 else f"{values[0]} to {values[-1]}"
