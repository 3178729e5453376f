"""The section on the confidence: how many subgoals there are at each, where that was tried."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.irl.sweep_record import Sweep
from subgoal.plots.style import PALETTE
from subgoal.plots.sweep import sweep_words
from subgoal.plots.words import percent
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.interactive import axis, layout
from subgoal.reporting.pieces import details, lead, note, section
from subgoal.reporting.tables import table

HEADS = ("Confidence", "Subgoals, mean", "± sd", "Least", "Most")


def sweep_section(posterior: Posterior, found: Sweep | None, figures: dict[str, Any]) -> str:
    """What lasts over which range, with its curve and table; empty where no confidence but one was tried."""
    if found is None:
        return ""
    figures["sweep"] = sweep_figure(found)
    rows = [
        (f"{level:.3g}", f"{mean:.2f}", f"{sd:.2f}", str(row.min()), str(row.max()))
        for level, mean, sd, row in zip(found.confidences, found.mean, found.sd, found.counts, strict=True)
    ]
    told = (
        f"{found.counts.shape[1]} chains at each level; counted are candidates that serve at least "
        f"{percent(found.settings['least_share'])} of the observations in the last draw."
    )
    used = posterior.settings.confidence
    own = f" The answer above is at {used:.3g}." if isinstance(used, float) else ""
    left = f" Stopped before: {', '.join(f'{x:.3g}' for x in found.left_out)}." if found.left_out.size else ""
    shown = lead(sweep_words(found) + "." + own) + '<div class="plot" id="sweep"></div>' + note(told + left)
    return section("How many subgoals at each confidence", shown) + details("Table of the levels", table(HEADS, rows))


def sweep_figure(found: Sweep) -> dict[str, Any]:
    """Mean number of subgoals against α, with two standard deviations to both sides."""
    line = {
        "type": "scatter", "mode": "lines+markers", "x": found.confidences, "y": np.round(found.mean, 3),
        "error_y": {"type": "data", "array": np.round(2 * found.sd, 3), "thickness": 1.2},
        "line": {"color": PALETTE[0]},
        "hovertemplate": "confidence %{x:.3g}: %{y}<extra></extra>",
    }  # fmt: skip
    top = float((found.mean + 2 * found.sd).max()) * 1.1 + 0.5
    across, up = axis("confidence", type="log"), axis("number of subgoals", range=[0, top])
    return {"data": [line], "layout": layout(380, xaxis=across, yaxis=up, showlegend=False)}
