"""The sections on other settings: how much hangs on what was chosen, and on the rate of the recording."""

from __future__ import annotations

import numpy as np

from subgoal.irl.reruns import SETTLED, Rerun, Sensitivity
from subgoal.plots.style import with_unit
from subgoal.plots.words import counted
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.learned import in_time
from subgoal.reporting.pieces import lead, note, section
from subgoal.reporting.safe import text
from subgoal.reporting.tables import chip, short, table

MOST_GOALS = 8


def sensitivity_section(found: Sensitivity | None) -> str:
    """The verdict, and a line for each setting; empty where it was not computed."""
    if found is None:
        return ""
    learned = any(not np.isnan(row.persistence) for row in found.rows)
    heads = [
        "Setting", "Subgoals", "Missing", text(with_unit("Places move by up to", found.unit)),
        "Shares change by up to", "η", *(["ρ"] if learned else []), "Counts as", "R-hat",
    ]  # fmt: skip
    rows = [_setting(row, found.rows[0].n_subgoals, learned) for row in found.rows]
    told = [
        f"Each line is a new run, shorter than the one above; η is the concentration{', ρ the persistence' * learned}. "
        f"Changes in “the same again” are chance. An R-hat above {SETTLED} means that the short run is unsure itself."
    ]
    if found.left_out:
        told.append(f"Stopped before: {', '.join(found.left_out)}.")
    return section(
        "How sure are the settings", lead(found.verdict) + table(heads, rows) + "".join(note(each) for each in told)
    )


def _setting(row: Rerun, number: int, learned: bool) -> tuple[str, ...]:
    count = str(row.n_subgoals) if row.n_subgoals == number else f"<b>{row.n_subgoals}</b>"
    rhat = f"{row.rhat:.2f}" if row.settled else f'<span class="fail">{row.rhat:.2f}</span>'
    kept = "–" if np.isnan(row.persistence) else f"{row.persistence:.3f}"
    return (
        text(row.setting), count, f"<b>{row.lost}</b>" if row.lost else "–", f"{row.largest_move:.3g}",
        f"{100 * row.largest_change:.1f} points", f"{row.concentration:.2g}", *([kept] if learned else []),
        f"{row.worth:,.0f}", rhat,
    )  # fmt: skip


def rate_section(posterior: Posterior, found: Sensitivity | None) -> str:
    """The answer at the rate of the recording, at a half and a quarter; empty where it was not computed."""
    rates = [] if found is None else [row for row in found.rows if row.kind == "rate"]
    if found is None or not rates:
        return ""
    shown = found.top[:MOST_GOALS]
    heads = [
        "Recording", "Observations", "Count as", "Subgoals", *(chip(s) for s in range(len(shown))),
        *(["Subgoal drawn anew every"] if not np.isnan(found.rows[0].persistence) else []),
    ]  # fmt: skip
    labels = [head if "<" not in head else text(shown[k - 4].name) for k, head in enumerate(heads)]
    rows = [_rate(posterior, row, len(shown)) for row in (found.rows[0], *rates)]
    return section("Rate", lead(rate_words(found.rows[0], rates)) + table(heads, rows, labels=labels))


def rate_words(base: Rerun, rates: list[Rerun]) -> str:
    """Whether the rate of the recording decides the answer."""
    counts = [row.n_subgoals for row in rates]
    change = 100 * max(row.largest_change for row in rates)
    told = (
        f"stays {base.n_subgoals}" if set(counts) == {base.n_subgoals}
        else f"is {base.n_subgoals} with all observations and {' and '.join(map(str, counts))} with fewer"
    )  # fmt: skip
    lost = max(row.lost for row in rates)
    gone = f", {counted(lost, 'subgoal')} not found again" if lost else ""
    return (
        "Had the recording been made at a lower rate, with the same actions: the number of subgoals "
        f"{told}, shares change by at most {change:.1f} percentage points{gone}."
    )


def _rate(posterior: Posterior, row: Rerun, shown: int) -> tuple[str, ...]:
    name = "as recorded" if row.every == 1 else row.setting
    shares = ("–" if np.isnan(row.moved[s]) else short(float(row.shares[s])) for s in range(shown))
    kept = [] if np.isnan(row.persistence) else [text(in_time(posterior, row.every / max(1 - row.persistence, 1e-12)))]
    return text(name), f"{row.n_observations:,}", f"{row.worth:,.0f}", str(row.n_subgoals), *shares, *kept
