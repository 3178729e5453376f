"""The interactive figures as plain data and layout for Plotly: built without importing it, so that this is quick."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.answers.residuals import Residuals
from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import COUNTED_FROM, Subgoals
from subgoal.plots.counts import CHAIN_COLOURS, thinned_sweeps
from subgoal.plots.fit import EXPECTED, OBSERVED, TRANSFORM_BINS
from subgoal.plots.strips import MOST_ROWS, Bar, strip_bars
from subgoal.plots.style import INK, PALETTE, colour
from subgoal.plots.words import percent
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.safe import label

Figure = dict[str, Any]


def layout(height: int, **fields: Any) -> dict[str, Any]:
    """What all figures share."""
    return {
        "height": height,
        "margin": {"l": 60, "r": 12, "t": 14, "b": 48},
        "font": {"family": 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', "size": 12.5, "color": INK},
        "paper_bgcolor": "#ffffff",
        "modebar": {"bgcolor": "rgba(255,255,255,0.8)", "color": "#98a2b3", "activecolor": "#475467"},
        "plot_bgcolor": "#ffffff",
        "hovermode": "closest",
        "hoverlabel": {"align": "left"},
        "legend": {"orientation": "h", "y": -0.13, "x": 0, "yanchor": "top", "itemsizing": "constant"},
        **fields,
    }


def axis(title: str, **fields: Any) -> dict[str, Any]:
    """One axis in the house style."""
    return {
        "title": {"text": label(title), "standoff": 6}, "gridcolor": "#eef0f3", "linecolor": "#98a2b3",
        "zeroline": False, "automargin": True, **fields,
    }  # fmt: skip


def strip_figure(posterior: Posterior, found: Subgoals, cut: Segments) -> Figure:
    """Segments over time, one row per trajectory, paler where less sure."""
    demos = posterior.demonstrations
    rows = min(demos.n_trajectories, MOST_ROWS)
    bars, across = strip_bars(posterior, cut, rows)
    data = segment_bars(posterior, found, bars)
    names = [label(name if len(name) <= 24 else name[:11] + "…" + name[-12:]) for name in demos.trajectory_names[:rows]]
    ticks = {"tickvals": list(range(rows)), "ticktext": names, "range": [rows - 0.4, -0.6], "showgrid": False}
    height = 110 + 22 * max(rows, 4)
    legend = {"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0}
    return {"data": data, "layout": layout(height, barmode="overlay", xaxis=axis(across), yaxis=axis("", **ticks),
                                           legend=legend)}  # fmt: skip


def segment_bars(
    posterior: Posterior, found: Subgoals, bars: list[Bar], row: int | None = None, axes: dict[str, str] | None = None
) -> list[Figure]:
    """Traces of segments, one for each subgoal that has some: each in its row, or all in ``row``."""
    names = posterior.demonstrations.trajectory_names
    data: list[Figure] = []
    for k in [*range(len(found.listed)), -1]:
        mine = [bar for bar in bars if bar.subgoal == k]
        if not mine:
            continue
        name = label(found.listed[k].name) if k >= 0 else "no listed subgoal"
        data.append({
            "type": "bar", "orientation": "h", "name": name, "y": [b.row if row is None else row for b in mine],
            "x": [short(b.stop - b.start) for b in mine], "base": [short(b.start) for b in mine],
            "width": 0.8,
            "marker": {"color": colour(k), "opacity": [round(0.15 + 0.85 * b.probability**2, 3) for b in mine],
                       "line": {"color": "#fff", "width": 0.5}},
            "text": [label(names[b.row]) for b in mine], "textposition": "none",
            "customdata": [[short(b.start), short(b.stop), round(b.probability, 3), name] for b in mine],
            **(axes or {}),
            "hovertemplate": "%{customdata[3]}<br>%{text}: %{customdata[0]} to %{customdata[1]}<br>"
                             "probability %{customdata[2]}<extra></extra>",
        })  # fmt: skip
    return data


def trace_figure(posterior: Posterior) -> Figure:
    """Candidates in use and log joint over the sweeps of each chain, warm-up shaded."""
    data = []
    for which, scale in (("n_active", "y"), ("log_joint", "y2")):
        rows = thinned_sweeps(posterior.traces[which].shape[1])
        for chain, values in enumerate(posterior.traces[which]):
            data.append({
                "type": "scatter", "mode": "lines", "name": f"chain {chain}", "legendgroup": f"chain {chain}",
                "showlegend": scale == "y", "x": rows, "y": np.round(values[rows], 2), "yaxis": scale,
                "line": {"width": 0.8, "color": CHAIN_COLOURS[chain % len(CHAIN_COLOURS)]}, "opacity": 0.85,
            })  # fmt: skip
    warm = {
        "type": "rect", "xref": "x", "yref": "paper", "x0": 0, "x1": posterior.settings.warmup, "y0": 0, "y1": 1,
        "fillcolor": "#e5e7eb", "opacity": 0.6, "line": {"width": 0}, "layer": "below",
    }  # fmt: skip
    late = posterior.traces["log_joint"][:, posterior.settings.warmup // 2 :]
    spread = float(np.ptp(late)) * 0.15 or 1.0
    reach = [float(late.min()) - spread, float(late.max()) + spread]
    return {"data": data, "layout": layout(
        440, shapes=[warm] if posterior.settings.warmup else [], xaxis=axis("sweep (warm-up shaded)", anchor="y2"),
        yaxis=axis("candidates in use", domain=[0.54, 1]),
        yaxis2=axis("log p(θ, O) [nats]", domain=[0, 0.46], range=reach),
    )}  # fmt: skip


def count_figure(found: Subgoals) -> Figure:
    """P(number of subgoals | O)."""
    law = found.n_subgoals_distribution
    shades = [PALETTE[0] if k == found.n_subgoals else "#A9C6DD" for k in law]
    bars = {
        "type": "bar", "x": list(law), "y": [round(p, 4) for p in law.values()], "marker": {"color": shades},
        "text": [percent(p) for p in law.values()], "textposition": "outside", "cliponaxis": False,
        "hovertemplate": "%{x} subgoals: %{y}<extra></extra>",
    }  # fmt: skip
    across = axis(f"subgoals with at least {percent(COUNTED_FROM)} of the observations", dtick=1,
                  range=[min(law) - 1.5, max(law) + 1.5])  # fmt: skip
    up = axis("posterior probability", range=[0, 1.15 * max(law.values())])
    return {"data": [bars], "layout": layout(440, xaxis=across, yaxis=up, showlegend=False)}


def residual_figures(residuals: Residuals) -> tuple[Figure, Figure]:
    """Distances beside the model's expectation, and their probability integral transform."""
    edges, total = residuals.edges, max(residuals.distance.size, 1)
    seen = np.histogram(residuals.distance, edges)[0] / total
    expected = np.append(residuals.expected, residuals.expected[-1:])
    distance = [
        _bars(edges, seen),
        {"type": "scatter", "mode": "lines", "name": "the model expects", "x": np.round(edges, 4),
         "y": np.round(expected, 4), "line": {"color": EXPECTED, "shape": "hv", "width": 2.5}},
    ]  # fmt: skip
    unit = np.linspace(0, 1, TRANSFORM_BINS + 1)
    flat = {"type": "scatter", "mode": "lines", "name": "flat: the model is right", "x": [0, 1],
            "y": [1 / TRANSFORM_BINS] * 2, "line": {"color": EXPECTED, "width": 2.5}}  # fmt: skip
    transform = [_bars(unit, np.histogram(residuals.transform, unit)[0] / total), flat]
    titles = "distance from the action that the subgoal asks for", "probability of a smaller distance"
    first, second = (
        {"data": data, "layout": layout(340, xaxis=axis(title), yaxis=axis("share of the observations"),
                                        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0})}
        for data, title in zip((distance, transform), titles, strict=True)
    )  # fmt: skip
    return first, second


def _bars(edges: Any, heights: Any) -> dict[str, Any]:
    return {
        "type": "bar", "name": "observed", "x": np.round((edges[1:] + edges[:-1]) / 2, 4),
        "y": np.round(heights, 4), "width": np.round(np.diff(edges), 4), "marker": {"color": OBSERVED},
    }  # fmt: skip


def short(value: float) -> float:
    """Six significant digits."""
    return float(f"{value:.6g}")
