"""Residuals: does the model's confidence fit what was observed?"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.answers.residuals import Residuals
from subgoal.plots.style import PALETTE, SMALL, new_figure, panel
from subgoal.plots.words import reading
from subgoal.posterior.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OBSERVED, EXPECTED = "#A9C6DD", PALETTE[1]
TRANSFORM_BINS = 20


def plot_residuals(posterior: Posterior, residuals: Residuals) -> Figure:
    """Distances from the asked action beside what the model expects, and their probability integral transform."""
    figure = new_figure(10.4, 4.4, reading(posterior, residuals), posterior, left=0.075)
    total = max(residuals.distance.size, 1)
    axes = panel(figure, (0.075, 0.14, 0.4, 0.66), "", "distance from the action that the subgoal asks for",
                 "share of the observations")  # fmt: skip
    seen = np.histogram(residuals.distance, residuals.edges)[0] / total
    axes.bar(residuals.edges[:-1], seen, np.diff(residuals.edges), align="edge", color=OBSERVED, edgecolor="white",
             linewidth=0.5, label="observed")  # fmt: skip
    expected = np.concatenate([residuals.expected, residuals.expected[-1:]])
    axes.step(residuals.edges, expected, where="post", color=EXPECTED, linewidth=2, label="the model expects")
    axes.legend(frameon=False, fontsize=SMALL)
    axes.set_xlim(residuals.edges[0], residuals.edges[-1])
    other = panel(figure, (0.565, 0.14, 0.4, 0.66), "flat if the model is right; left heavy: more precise",
                  "probability of a smaller distance", "share of the observations")  # fmt: skip
    edges = np.linspace(0, 1, TRANSFORM_BINS + 1)
    shares = np.histogram(residuals.transform, edges)[0] / total
    other.bar(edges[:-1], shares, 1 / TRANSFORM_BINS, align="edge", color=OBSERVED, edgecolor="white", linewidth=0.5)
    other.axhline(1 / TRANSFORM_BINS, color=EXPECTED, linewidth=2)
    other.set_xlim(0, 1)
    return figure
