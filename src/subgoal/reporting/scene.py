"""The interactive main figure: trajectories and subgoals in one, two or three dimensions."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import Subgoal, Subgoals
from subgoal.plots.shown import Shown, clock_of, ends_of, places_of, shown
from subgoal.plots.style import INK, PATH_COLOUR, colour, ink_on, with_unit
from subgoal.plots.words import decimals, extent_of, marker_label, percent
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.interactive import Figure, axis, layout
from subgoal.reporting.safe import label
from subgoal.reporting.sides import Sides, sides_of
from subgoal.runtime.checks import Floats

MOST_POINTS = 5_000
MOST_ARROWS = 3_000
LETTERS = ("x", "y", "z")
Trace = dict[str, Any]


def scene_figure(posterior: Posterior, found: Subgoals, cut: Segments, *, y_down: bool = False) -> tuple[Figure, str]:
    """The figure, and a note of what it leaves out.

    A legend entry toggles a subgoal with its observations; hovering tells subgoal, probability, time and trajectory.
    """
    demos = posterior.demonstrations
    places, part = places_of(demos), shown(demos.offset, MOST_POINTS)
    dimension = min(places.shape[1], 3)
    notes = [part.note] if part.note else []
    if places.shape[1] > 3:
        notes.append(f"first 3 of {places.shape[1]} dimensions")
    digits = decimals(extent_of(posterior), 10_000)
    if dimension == 1:
        clock = clock_of(demos)[0]
        coordinates = _round(np.column_stack([clock, places[:, 0]]), digits)
        data = [_paths(part.paths(coordinates))]
    else:
        coordinates = _round(places[:, :dimension], digits)
        data = [_paths(part.paths(coordinates, _round(ends_of(demos)[:, :dimension], digits)))]
    for k in [*range(len(found.listed)), -1]:
        if k >= 0 or (cut.labels[part.rows] < 0).any():
            data.append(_entry(k, found, dimension))
        rows = part.rows[cut.labels[part.rows] == k]
        if rows.size:
            data.append(_observations(posterior, found, cut, k, rows, coordinates, y_down=y_down, part=part))
    for goal in reversed(found.listed):
        data += _goal(posterior, goal, dimension, digits, coordinates)
    if dimension < 3:
        return {"data": data, "layout": _flat_layout(posterior, dimension, y_down)}, "; ".join(notes)
    sides = sides_of(posterior, np.column_stack([np.concatenate([t[letter] for t in data]) for letter in LETTERS]))
    notes += [] if sides.equal else ["each axis has a scale of its own"]
    return {"data": data, "layout": _solid_layout(posterior, sides, y_down)}, "; ".join(notes)


def _round(values: Floats, digits: int) -> Floats:
    return np.asarray(np.round(values, digits), np.float64)


def _spread(points: Floats) -> dict[str, Any]:
    """Columns as x, y and, in three dimensions, z."""
    return {letter: points[:, k] for k, letter in enumerate(LETTERS[: points.shape[1]])}


def _kind(dimension: int) -> str:
    return "scatter3d" if dimension == 3 else "scatter"


def _paths(paths: list[Floats]) -> Trace:
    """All trajectories as one broken line."""
    width = paths[0].shape[1]
    gap = np.full((1, width), np.nan)
    joined = np.concatenate([piece for path in paths for piece in (path, gap)])
    return {
        "type": _kind(width), "mode": "lines", "name": "trajectories", "hoverinfo": "skip", **_spread(joined),
        "line": {"color": PATH_COLOUR, "width": 1 if width < 3 else 2}, "connectgaps": False,
    }  # fmt: skip


def _entry(k: int, found: Subgoals, dimension: int) -> Trace:
    """A legend entry that stands for everything of one subgoal."""
    name = label(marker_label(found.listed[k])) if k >= 0 else "no listed subgoal"
    return {
        "type": _kind(dimension), "mode": "markers", "name": name, "legendgroup": f"goal {k}", "hoverinfo": "skip",
        **_spread(np.full((1, dimension), np.nan)), "marker": {"color": colour(k), "size": 11, "symbol": "circle"},
    }  # fmt: skip


def _observations(
    posterior: Posterior, found: Subgoals, cut: Segments, k: int, rows: Any, coordinates: Floats, *, y_down: bool,
    part: Shown,
) -> Trace:  # fmt: skip
    """Observations of one subgoal; arrows along the actions in two dimensions, if there are not too many."""
    demos = posterior.demonstrations
    clock, time_label = clock_of(demos)
    name = label(found.listed[k].name) if k >= 0 else "no listed subgoal"
    chance = np.round(cut.probability[rows, k], 3)
    marker: dict[str, Any] = {"color": colour(k), "size": 5 if coordinates.shape[1] < 3 else 3}
    if part.rows.size <= MOST_ARROWS and np.shape(demos.actions)[1:] == (2,) == np.shape(demos.states)[1:]:
        marker |= _arrows(posterior, rows, y_down)
    owner = demos.trajectory[rows]
    return {
        "type": _kind(coordinates.shape[1]), "mode": "markers", "name": name, "legendgroup": f"goal {k}",
        "showlegend": False,         **_spread(coordinates[rows]), "marker": marker,
        "text": [label(demos.trajectory_names[d]) for d in owner],
        "customdata": np.column_stack([chance, np.round(clock[rows], 3)]),
        "hovertemplate": f"%{{fullData.name}}<br>probability %{{customdata[0]}}<br>{label(time_label)}: "
                         "%{customdata[1]}<br>%{text}<extra></extra>",
    }  # fmt: skip


def _arrows(posterior: Posterior, rows: Any, y_down: bool) -> dict[str, Any]:
    actions = np.asarray(posterior.demonstrations.actions, float)[rows]
    turn = np.degrees(np.arctan2(actions[:, 1], actions[:, 0]))
    silent = np.asarray(posterior.uninformative)[rows]
    return {
        "symbol": ["circle" if s else "arrow" for s in silent],
        "angle": np.round(90 + turn if y_down else 90 - turn),
        "size": [4 if s else 8 for s in silent],
    }


def _goal(posterior: Posterior, goal: Subgoal, dimension: int, digits: int, coordinates: Floats) -> list[Trace]:
    """The ring of the credible set, the merged candidates and the numbered disc."""
    shade, group = colour(goal.label - 1), f"goal {goal.label - 1}"
    common = {"type": _kind(dimension), "legendgroup": group, "showlegend": False, "name": label(goal.name)}
    if dimension == 1:
        ends = [coordinates[:, 0].min(), coordinates[:, 0].max()]
        level = round(float(goal.position[0]), digits)
        line = {**common, "mode": "lines", "x": ends, "y": [level] * 2, "line": {"color": shade}, "hoverinfo": "skip"}
        return [line, _disc(common, goal, np.array([[ends[1], level]]))]
    traces = []
    if goal.radius > 0 and dimension == 2:
        turn = np.linspace(0, 2 * np.pi, 49)[:, None]
        ring = np.hstack([np.cos(turn), np.sin(turn)]) * goal.radius / posterior.candidates.metric.weights
        traces.append({**common, "mode": "lines", "fill": "toself", "fillcolor": shade + "1A", "hoverinfo": "skip",
                       "line": {"color": shade, "width": 1.2},
                       **_spread(np.round(goal.position + ring, digits))})  # fmt: skip
    members = posterior.candidates.points[goal.members[1:], :dimension]
    if len(members):
        look = {"symbol": "diamond-open", "size": 7 if dimension == 2 else 4, "color": shade}
        traces.append({**common, "mode": "markers", **_spread(np.round(members, digits)), "marker": look,
                       "hovertemplate": "merged candidate of %{fullData.name}<extra></extra>"})  # fmt: skip
    return [*traces, _disc(common, goal, np.round(goal.position[None, :dimension], digits))]


def _disc(common: Trace, goal: Subgoal, spot: Floats) -> Trace:
    shade = colour(goal.label - 1)
    flat = spot.shape[1] == 2
    return {
        **common, "mode": "markers+text", **_spread(spot), "text": [str(goal.label)],
        "textposition": "middle center" if flat else "top center",
        "textfont": {"color": ink_on(shade) if flat else INK, "size": 13, "weight": 700},
        "marker": {"color": shade, "size": 24 if flat else 15, "line": {"color": "#fff", "width": 2}},
        "hovertemplate": f"%{{fullData.name}}<br>share {percent(goal.share)}<extra></extra>",
    }  # fmt: skip


def _titles(posterior: Posterior) -> list[str]:
    demos = posterior.demonstrations
    return [with_unit(name, demos.units) for name in demos.names[:3]]


def _flat_layout(posterior: Posterior, dimension: int, y_down: bool) -> dict[str, Any]:
    titles = _titles(posterior)
    if dimension == 1:
        return layout(500, xaxis=axis(clock_of(posterior.demonstrations)[1]), yaxis=axis(titles[0]))
    turned = {"autorange": "reversed"} if y_down else {}
    return layout(500, xaxis=axis(titles[0]), yaxis=axis(titles[1], scaleanchor="x", **turned))


def _solid_layout(posterior: Posterior, sides: Sides, y_down: bool) -> dict[str, Any]:
    axes = {}
    for letter, title, low, high in zip(LETTERS, _titles(posterior), sides.low, sides.high, strict=True):
        ends = [high, low] if y_down and letter == "y" else [low, high]
        each = axes[f"{letter}axis"] = axis(title, range=ends)
        each["title"].pop("standoff")
        each.pop("automargin")
    box = {"aspectmode": "manual", "aspectratio": dict(zip(LETTERS, sides.ratio, strict=True))}
    scene = {**axes, **box, "camera": {"eye": {"x": 1.5, "y": -1.65, "z": 0.9}}}
    return layout(520, scene=scene, margin={"l": 0, "r": 0, "t": 0, "b": 0})
