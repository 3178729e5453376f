"""One subgoal for which every action is as good as any other: what it takes under (6.2) as printed, and normalised.

The thesis divides exp(αQ) by its largest value over actions. A candidate with flat Q (one that cannot be reached, say)
then has the value 1 for whatever was done. Here such a null candidate is added to the ε-net of real recordings, with
the same prior probability as any other: a column of log 1 in the printed form, and of the uniform density over
directions in the normalised one, which ``LogLikelihood.with_background`` adds as well.

Pen strokes of a hand that goes to corners (LASA), and the pedestrians of ``experiments.fig_5_4``, over a range of
confidences α. At an α that is too high for the recording even a fair density leaves actions to the null candidate:
those that go nowhere in particular.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments import fig_5_4
from experiments.common import GREY, INK, PALETTE, Headline, Options, find_data, run, sheet
from subgoal.answers.subgoals import subgoals
from subgoal.candidates import epsilon_net
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.readers import read_recording
from subgoal.demonstrations.recordings import starting_in
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import DEFAULT_CONFIDENCE, action_comparison
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats

SHAPES, EVERY = ("Line", "Angle", "Zshape"), 20
SHOWN = "Zshape"
CONFIDENCES = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0)
FORMS = ("normalised", "printed")
LONG: dict[str, Any] = {"draws": 500, "warmup": 500, "thin": 4}
SHORT: dict[str, Any] = {"draws": 100, "warmup": 100, "thin": 2}


class Case(NamedTuple):
    """A recording, the radius of its ε-net (None: the default), and the α at which it is used elsewhere here."""

    demonstrations: Demonstrations
    epsilon: float | None
    confidence: float


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Every recording at every confidence."""
    rows = {
        name: [measured(case, alpha, options) for alpha in confidences(case, options.quick)]
        for name, case in cases(options).items()
    }
    return {"rows": rows}, picture(rows, options)


def cases(options: Options) -> dict[str, Case]:
    """Pen strokes, and pedestrians where they are at hand."""
    folder = options.recordings
    found = {
        name: Case(strokes(options, name), None, DEFAULT_CONFIDENCE)
        for name in ((SHOWN,) if options.quick else SHAPES)
    }  # fmt: skip
    beside, _ = find_data("edinburgh_forum", folder.parent)
    if beside is not None:
        recording = starting_in(read_recording(beside / fig_5_4.FILE), (480, -np.inf), (np.inf, 140))
        found["pedestrians"] = Case(fig_5_4.selection(recording, options.seed), fig_5_4.EPSILON, fig_5_4.CONFIDENCE)
    return found


def strokes(options: Options, name: str) -> Demonstrations:
    """Seven strokes of one shape."""
    return demonstrate(read_recording(options.recordings / f"{name}.mat"), every=EVERY)


def confidences(case: Case, quick: bool) -> tuple[float, ...]:
    """All of them, or three with that of the case."""
    return tuple(sorted({1.0, case.confidence, 30.0})) if quick else CONFIDENCES


def measured(case: Case, alpha: float, options: Options) -> Headline:
    """Subgoals without a null candidate, and what one takes, by either form."""
    demos = case.demonstrations
    net = epsilon_net(demos) if case.epsilon is None else epsilon_net(demos, case.epsilon)
    fair = action_comparison(demos, net, confidence=alpha)
    row: Headline = {"confidence": alpha, "pairs": fair.n_observations, "candidates": fair.n_candidates}
    for form, likelihood in zip(FORMS, (fair, literal_maximum(fair)), strict=True):
        alone, beside = learn(likelihood, options), learn(with_null(likelihood, form, fair), options)
        row[form] = {
            "subgoals": subgoals(alone).n_subgoals,
            "observations_on_null": float(beside.expected_shares[-1] * fair.n_observations),
            "share_of_null": float(beside.expected_shares[-1]),
            "status": [alone.status.name, beside.status.name],
        }
    return row


def with_null(likelihood: LogLikelihood, form: str, fair: LogLikelihood) -> LogLikelihood:
    """One more candidate, the last, that asks for nothing, of the same prior probability as any other."""
    n = likelihood.n_observations
    column = np.zeros(n) if form == "printed" else fair.source.log_flat(0, n)
    table = np.column_stack([likelihood.rows(0, n), column])
    return LogLikelihood.from_table(table, demonstrations=likelihood.demonstrations)


def learn(likelihood: LogLikelihood, options: Options) -> Posterior:
    """The exchangeable mixture."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return sample(likelihood, seed=options.seed, **(SHORT if options.quick else LONG))


def picture(rows: dict[str, list[Headline]], options: Options) -> Figure:
    """The strokes with what the null candidate takes of them by either form, and its share over α."""
    figure = sheet(13.0, 4.6)
    axes = figure.subplots(1, 3, width_ratios=(1, 1, 1.5))
    demos = strokes(options, SHOWN)
    fair = action_comparison(demos, epsilon_net(demos))
    for axis, form, likelihood in zip(axes, FORMS, (fair, literal_maximum(fair)), strict=False):
        posterior = learn(with_null(likelihood, form, fair), options)
        _strokes(axis, demos, np.asarray(posterior.shares[:, [-1]].todense()).ravel(), form)
    _shares(axes[2], rows)
    figure.suptitle("A subgoal that asks for nothing explains everything, if its likelihood is not normalised",
                    x=0.01, ha="left")  # fmt: skip
    return figure


def _strokes(axis: Axes, demos: Demonstrations, null: Floats, form: str) -> None:
    """Each pair where it is, in one of two colours."""
    taken = null > 0.5
    places = np.asarray(demos.states)
    axis.scatter(places[:, 0], places[:, 1], s=11, c=np.where(taken, PALETTE[1], PALETTE[0]), lw=0)
    heading = {"normalised": "Normalised (the default)", "printed": "As printed in (6.2)"}[form]
    axis.set_title(f"{heading}\nthe null takes {null.sum():.1f} of {null.size} steps")
    axis.set(aspect="equal", xlabel="mm", ylabel="mm" if form == FORMS[0] else "")
    marks = [
        Line2D([], [], marker="o", ls="", ms=4, color=ink, label=told)
        for ink, told in ((PALETTE[0], "served by a place"), (PALETTE[1], "served by the null"))
    ]
    axis.legend(handles=marks, loc="center right", fontsize=8, handletextpad=0, borderpad=0)
    axis.set_xlim(-47, 24)


def _shares(axis: Axes, rows: dict[str, list[Headline]]) -> None:
    for k, (name, row) in enumerate(rows.items()):
        alpha, ink = [each["confidence"] for each in row], PALETTE[(5, 4, 0, 2)[k % 4]]
        fair, printed = ([each[form]["share_of_null"] for each in row] for form in FORMS)
        axis.plot(alpha, fair, "o-", ms=4, color=ink)
        axis.annotate(f"normalised, {name}", (alpha[-1], fair[-1]), xytext=(8, 0), textcoords="offset points",
                      va="center", fontsize=8.5, color=ink)  # fmt: skip
        axis.plot(alpha, printed, "s--", ms=4, color=PALETTE[1])
    axis.annotate("as printed, all recordings", (1.0, 1.0), xytext=(0, -12), textcoords="offset points",
                  va="center", fontsize=8.5, color=PALETTE[1])  # fmt: skip
    axis.axvline(DEFAULT_CONFIDENCE, color=GREY, lw=1, ls=":")
    axis.annotate("default α", (DEFAULT_CONFIDENCE, 0.8), xytext=(4, 0), textcoords="offset points", color=INK,
                  fontsize=8.5)  # fmt: skip
    axis.set_xscale("log")
    axis.set_xticks(CONFIDENCES, [f"{alpha:g}" for alpha in CONFIDENCES])
    axis.minorticks_off()
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axis.set(
        title="Share of each recording that the null takes", xlabel="confidence α", ylim=(-0.03, 1.05), xlim=(0.9, 130)
    )


if __name__ == "__main__":
    run("flat_subgoal", experiment, needs="lasa_handwriting")
