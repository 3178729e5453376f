"""The section on value functions and phase portraits, where subgoals were planned for in a continuous world."""

from __future__ import annotations

from typing import Any

from subgoal.answers.portraits import Portraits, portraits
from subgoal.answers.subgoals import Subgoals
from subgoal.plots.portraits import VALUES
from subgoal.plots.style import colour, with_unit
from subgoal.plots.words import marker_label, percent
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.interactive import Figure, axis, layout, short
from subgoal.reporting.pieces import lead, section
from subgoal.reporting.safe import label

TOLD = (
    "Each dot is a state that was seen; its colour is the share of the discounted future that can be spent at the "
    "chosen subgoal from there, and the line from it is where the best action leads in one step."
)


def portrait_section(posterior: Posterior, found: Subgoals, figures: dict[str, Any]) -> str:
    """Values of one listed subgoal at a time, chosen from a list; empty where nothing was planned."""
    seen = portraits(posterior, found)
    if seen is None:
        return ""
    figures["portrait"] = portrait_figure(posterior, found, seen)
    return section("Value functions and phase portraits", lead(TOLD) + '<div class="plot" id="portrait"></div>')


def portrait_figure(posterior: Posterior, found: Subgoals, seen: Portraits) -> Figure:
    """Three traces for each listed subgoal, of which one subgoal's are visible."""
    demos, (a, b) = posterior.demonstrations, seen.pair
    data: list[Figure] = []
    for k, goal in enumerate(found.listed):
        data += _of_one(seen, goal.position, k)
    count, each = len(found.listed), len(data) // len(found.listed)
    buttons = [
        {
            "label": label(f"{marker_label(goal)}: {percent(goal.share)}, held {seen.held[k]:.2f}"),
            "method": "restyle",
            "args": [{"visible": [t // each == k for t in range(count * each)]}],
        }
        for k, goal in enumerate(found.listed)
    ]  # fmt: skip
    menu = {"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom", "showactive": True}
    return {
        "data": data,
        "layout": layout(
            480, showlegend=False, updatemenus=[menu], xaxis=axis(with_unit(demos.names[a], demos.units)),
            yaxis=axis(with_unit(demos.names[b], demos.units)),
        ) | {"margin": {"l": 60, "r": 12, "t": 56, "b": 48}},
    }  # fmt: skip


def _of_one(seen: Portraits, position: Any, k: int) -> list[Figure]:
    a, b = seen.pair
    across: list[float | None] = []
    up: list[float | None] = []
    for state, step in zip(seen.states, seen.moved[:, k], strict=True):
        across += [short(state[a]), short(state[a] + step[a]), None]
        up += [short(state[b]), short(state[b] + step[b]), None]
    values = [round(float(v), 3) for v in seen.values[:, k]]
    marker = {"color": values, "colorscale": VALUES.capitalize(), "cmin": 0, "cmax": 1, "size": 7, "showscale": True,
              "colorbar": {"title": {"text": "value"}, "thickness": 12}}  # fmt: skip
    shown = {"type": "scatter", "visible": k == 0}
    return [
        {**shown, "mode": "lines", "x": across, "y": up, "line": {"color": "#98a2b3", "width": 1}, "hoverinfo": "skip"},
        {**shown, "mode": "markers", "x": [short(v) for v in seen.states[:, a]],
         "y": [short(v) for v in seen.states[:, b]], "marker": marker, "text": values,
         "hovertemplate": "value %{text}<extra></extra>"},
        {**shown, "mode": "markers", "x": [short(position[a])], "y": [short(position[b])], "hoverinfo": "skip",
         "marker": {"symbol": "circle-open", "size": 20, "line": {"width": 3}, "color": colour(k)}},
    ]  # fmt: skip
