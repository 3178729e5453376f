"""The section on groups: what each was after, and where groups differ."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.answers.groups import GroupShares, group_shares
from subgoal.answers.subgoals import Subgoals
from subgoal.plots.style import OTHER_COLOUR, colour, ink_on
from subgoal.plots.words import counted, percent
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.interactive import axis, layout
from subgoal.reporting.pieces import details, lead, note, section
from subgoal.reporting.safe import label, text
from subgoal.reporting.tables import chip, short, table

MOST_GROUPS = 30
MOST_PAIRS = 200
MEANING = (
    "Shares of the observations that were recorded of a group; the ranges hold 90 % of the draws. They say how sure it "
    "is which place each observation was for, not how another recording of the group would turn out."
)


def shares_of_groups(posterior: Posterior, found: Subgoals) -> GroupShares | None:
    """Of the groups of the demonstrations; None for fewer than two, and where the assignments were not kept."""
    if posterior.assignments is None or len(posterior.demonstrations.group_names) < 2:
        return None
    return group_shares(posterior, found=found)


def group_section(shares: GroupShares | None, figures: dict[str, Any]) -> str:
    """Bars, the table of shares, and the differences behind a click; empty without groups."""
    if shares is None:
        return ""
    figures["groups"] = group_figure(shares)
    left_out = len(shares.names) - MOST_GROUPS
    more = note(f"{counted(left_out, 'more group')} not shown.") if left_out > 0 else ""
    picture = '<div class="plot" id="groups"></div>'
    body = lead(largest_difference(shares)) + picture + _shares(shares) + more + note(MEANING)
    pairs = counted(min(len(shares.pairs), MOST_PAIRS), "pair")
    return section("Groups", body) + details(f"Differences between groups ({pairs})", _differences(shares))


def largest_difference(shares: GroupShares) -> str:
    """The largest of the differences that are sure, in a sentence."""
    if not shares.differs.any():
        return "No two groups surely differ in any subgoal."
    size = np.where(shares.differs, np.abs(shares.difference), -1.0)
    p, s = (int(k) for k in np.unravel_index(size.argmax(), size.shape))
    a, b = shares.pairs[p].tolist()
    a, b = (a, b) if shares.difference[p, s] > 0 else (b, a)
    low, high = sorted(np.abs(100 * shares.difference_interval[p, s]))
    goal = shares.subgoals.listed[s]
    sure, total = int(shares.differs.sum()), shares.differs.size
    more, less = percent(shares.share[a, s]), percent(shares.share[b, s])
    return (
        f"Largest difference: {goal.name} has {more} of the observations of {shares.names[a]} and {less} of those of "
        f"{shares.names[b]}: {low:.0f} to {high:.0f} percentage points more. "
        f"The 90 % intervals of {sure} of {counted(total, 'difference')} leave zero out."
    )


def group_figure(shares: GroupShares) -> dict[str, Any]:
    """A bar for each group, in the colours of the subgoals."""
    k_count = min(len(shares.names), MOST_GROUPS)
    names = [label(name if len(name) <= 24 else name[:11] + "…" + name[-12:]) for name in shares.names[:k_count]]
    data = []
    for s, goal in enumerate(shares.subgoals.listed):
        values = 100 * shares.share[:k_count, s]
        data.append(_bar(label(goal.name), colour(s), values, [f"{v:.0f} %" if v >= 4 else "" for v in values]))
    rest = 100 * np.clip(1 - shares.share[:k_count].sum(axis=1), 0, None)
    if (rest >= 0.5).any():
        data.append(_bar("no listed subgoal", OTHER_COLOUR, rest, [""] * k_count))
    ticks = {"tickvals": list(range(k_count)), "ticktext": names, "range": [k_count - 0.4, -0.6], "showgrid": False}
    legend = {"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0, "traceorder": "normal"}
    across = axis("share of the observations of the group [%]", range=[0, 100])
    room = {"l": 60, "r": 30, "t": 14, "b": 48}
    return {"data": data, "layout": layout(
        120 + 34 * max(k_count, 2), margin=room, barmode="stack", xaxis=across, yaxis=axis("", **ticks),
        legend=legend,
    )}  # fmt: skip


def _bar(name: str, shade: str, values: Any, told: list[str]) -> dict[str, Any]:
    return {
        "type": "bar", "orientation": "h", "name": name, "y": list(range(len(values))), "x": np.round(values, 2),
        "width": 0.7, "marker": {"color": shade, "line": {"color": "#fff", "width": 1}}, "text": told,
        "textposition": "inside", "insidetextanchor": "middle", "textangle": 0, "textfont": {"color": ink_on(shade)},
        "hovertemplate": f"{name}: %{{x:.1f}} %<extra></extra>",
    }  # fmt: skip


def _shares(shares: GroupShares) -> str:
    listed = shares.subgoals.listed
    heads = ("Group", "Observations", *(chip(s) for s in range(len(listed))))
    rows = []
    for k, name in enumerate(shares.names[:MOST_GROUPS]):
        cells = (
            f"{short(shares.share[k, s])} <small>{_range(100 * shares.interval[k, s])} %</small>"
            for s in range(len(listed))
        )
        rows.append((text(name), f"{shares.sizes[k]:,}", *cells))
    return table(heads, rows, labels=("Group", "Observations", *(text(goal.name) for goal in listed)))


def _differences(shares: GroupShares) -> str:
    listed = shares.subgoals.listed
    heads = ("Groups", *(chip(s) for s in range(len(listed))))
    rows = []
    for p, (a, b) in enumerate(shares.pairs[:MOST_PAIRS].tolist()):
        cells = []
        for s in range(len(listed)):
            points = f"{100 * shares.difference[p, s]:+.0f}"
            bold = f"<b>{points}</b>" if shares.differs[p, s] else f'<span class="faint">{points}</span>'
            cells.append(f"{bold} <small>{_range(100 * shares.difference_interval[p, s])}</small>")
        rows.append((text(f"{shares.names[a]} − {shares.names[b]}"), *cells))
    told = "Share in the first group less that in the second, in percentage points; bold where 90 % of the draws leave "
    more = len(shares.pairs) - len(rows)
    left = note(f"{counted(more, 'more pair')} not shown.") if more > 0 else ""
    made = table(heads, rows, labels=("Groups", *(text(goal.name) for goal in listed)))
    return lead(told + "zero on one side.") + made + left


def _range(values: Any) -> str:
    low, high = (round(float(v)) + 0 for v in values)
    if low == high:
        return str(low)
    return f"{low}–{high}" if low >= 0 else f"{low} to {high}"
