"""One style for every figure and the report: colours, sizes, labels."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PALETTE = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9",
    "#882255", "#8C8C1E", "#332288", "#44AA99", "#7A4B2A", "#DDB94F",
)  # fmt: skip
"""Okabe and Ito's colours first, then Tol's: told apart by most colour-blind readers, and numbered besides."""
OTHER_COLOUR = "#9A9A9A"
PATH_COLOUR = "#C9CDD2"
INK = "#23282E"
FAINT = "#6B7280"
ALARM = "#B42318"
TEXT, SMALL, TITLE = 10.5, 9.0, 13.0


def colour(k: int) -> str:
    """Colour of the k-th listed subgoal (from 0), grey for −1, everywhere the same."""
    return OTHER_COLOUR if k < 0 else PALETTE[k % len(PALETTE)]


def ink_on(background: str) -> str:
    """White or black, whichever is read better on ``background`` (#rrggbb)."""
    red, green, blue = (int(background[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return "#FFFFFF" if 0.2126 * red**2.2 + 0.7152 * green**2.2 + 0.0722 * blue**2.2 < 0.4 else "#000000"


def with_unit(name: str, unit: str) -> str:
    """An axis label: "x [mm]", or the name alone."""
    return f"{name} [{unit}]" if unit else name


def plain(text: str) -> str:
    """Text from data, so that matplotlib takes no dollar sign for mathematics."""
    return text.replace("$", r"\$")


def new_figure(
    width: float,
    height: float,
    title: str,
    posterior: Posterior | None = None,
    notes: Sequence[str] = (),
    *,
    left: float = 0.12,
) -> Figure:
    """An empty figure with its sentence on top, notes below, and the status if the draws are not to be trusted."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(width, height), facecolor="white")
    FigureCanvasAgg(figure)
    inch = 1 / height
    lines = textwrap.wrap(title, int((1 - left) * width * 9.3))
    figure.text(left, 1 - 0.12 * inch, plain("\n".join(lines)), fontsize=TITLE, color=INK, weight="bold", va="top")
    if posterior is not None and posterior.status is not Status.CONVERGED:
        told = textwrap.shorten(posterior.status.value, int((1 - left) * width * 11.5))
        below = 1 - (0.17 + 0.22 * len(lines)) * inch
        figure.text(left, below, told, fontsize=TEXT, color=ALARM, weight="bold", va="top")
    if notes:
        figure.text(left, 0.08 * inch, plain("; ".join(notes)), fontsize=SMALL, color=FAINT, va="bottom")
    return figure


def panel(figure: Figure, place: tuple[float, float, float, float], title: str, across: str, up: str) -> Axes:
    """Axes at ``place`` (left, bottom, width, height) with title and labels in the house style."""
    axes = figure.add_axes(place)
    axes.set_title(plain(title), fontsize=TEXT, color=INK, loc="left")
    axes.set_xlabel(plain(across), fontsize=TEXT, color=INK)
    axes.set_ylabel(plain(up), fontsize=TEXT, color=INK)
    axes.tick_params(labelsize=SMALL, colors=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_axisbelow(True)
    return axes


def whole_ticks(axes: Axes, which: str = "both") -> None:
    """Counts are whole numbers."""
    from matplotlib.ticker import MaxNLocator

    if which in ("x", "both"):
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if which in ("y", "both"):
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def limits(values: Sequence[float] | np.ndarray, margin: float = 0.05) -> tuple[float, float]:
    """The range of ``values`` with a margin, never empty."""
    low, high = float(np.min(values)), float(np.max(values))
    pad = margin * (high - low) or max(abs(low), 1.0) * margin
    return low - pad, high + pad


def equal_limits(axes: Axes, across: np.ndarray, up: np.ndarray) -> None:
    """Limits that hold all points with one scale on both axes and fill the panel."""
    box, size = axes.get_position(), axes.figure.get_size_inches()  # type: ignore[union-attr]
    shape = box.width * size[0] / (box.height * size[1])
    (left, right), (low, high) = limits(across), limits(up)
    width, height = max(right - left, shape * (high - low)), max(high - low, (right - left) / shape)
    axes.set_xlim((left + right - width) / 2, (left + right + width) / 2)
    axes.set_ylim((low + high - height) / 2, (low + high + height) / 2)
    axes.set_aspect("equal", adjustable="box")
