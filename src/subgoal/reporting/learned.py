"""What was learned beside the subgoals, and what each observation counts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from subgoal.answers.evidence import Evidence, evidence
from subgoal.irl.learn import UNSETTLED
from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.source import Levels
from subgoal.plots.words import counted
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.pieces import lead, note, section
from subgoal.reporting.safe import text
from subgoal.reporting.tables import short, table
from subgoal.runtime.checks import Floats

MEANINGS = {
    "concentration": ("Concentration η", "how readily new subgoals appear"),
    "persistence": ("Persistence ρ", "probability that the subgoal is kept from one observation to the next"),
    "persistence at the subgoal": ("Persistence on arrival", "the same where the state is at the subgoal"),
    "confidence": ("Confidence α", "how exactly actions follow their subgoal"),
    "group mass": ("Group mass a", "how much groups are alike"),
    "row mass": ("Row mass", "how much the successors of all subgoals are alike"),
    "stickiness": ("Stickiness", "share of a subgoal's successors that is itself"),
}
LEVELS = "noise levels"
GROUPS_DO_NOT_LAST = (
    "with groups (--group) how long subgoals last is not learned, and one place may then take nearly all that is "
    "noisy; compare with a run without groups, or give a confidence (--confidence)"
)
SAME = 0.25
"""The weight and the correlation left agree where their product is within this of one."""
FULL = 1.2
"""Up to this autocorrelation time, observations are as good as independent."""


def learned_numbers(posterior: Posterior) -> dict[str, Any]:
    """Mean and 95 % interval of each learned number over the draws, for ``summary.json``; empty without any.

    Noise is a list: each level of confidence, with its share of the actions. Numbers of each candidate are left out.
    """
    found: dict[str, Any] = {
        name.replace(" ", "_"): _mean_and_interval(draws)
        for name, draws in posterior.parameters.items()
        if draws.ndim == 2
    }
    draws, law = (
        posterior.parameters.get(LEVELS),
        None if posterior.likelihood is None else posterior.likelihood.confidence,
    )
    if draws is not None and isinstance(law, Levels):
        found[LEVELS.replace(" ", "_")] = [
            {"confidence": alpha, **_mean_and_interval(draws[..., m])}
            for m, alpha in enumerate(law.confidences.tolist())
        ]
    return found


def _mean_and_interval(draws: Any) -> dict[str, Any]:
    return {"mean": float(draws.mean()), "interval_95": np.quantile(draws, [0.025, 0.975]).tolist()}


def weight_numbers(posterior: Posterior) -> dict[str, Any] | None:
    """What observations count, for ``summary.json``; None where the likelihood is lost.

    The weight is found before sampling and is one number, so that it has no interval.
    """
    if posterior.likelihood is None:
        return None
    weight = posterior.likelihood.weight
    weight = np.ones(posterior.n_observations) if weight is None else np.asarray(weight)
    return {
        "mean": float(weight.mean()), "least": float(weight.min()), "most": float(weight.max()),
        "observations_count_as": float(weight.sum()), "settled": posterior.weight_settled,
    }  # fmt: skip


def weight_told(posterior: Posterior) -> str:
    """What ``learn`` found an observation to be worth, in a sentence; empty where it was not sought."""
    if posterior.weight_settled is None or posterior.likelihood is None or posterior.likelihood.weight is None:
        return ""
    told = f"each observation counts as {posterior.likelihood.weight[0]:.2g} of an independent one"
    return told if posterior.weight_settled else f"{told}. WARNING: {UNSETTLED}"


def learned_section(posterior: Posterior) -> str:
    """Every learned number with its 90 % interval; empty where nothing was learned."""
    rows = [*_numbers(posterior), *_levels(posterior)]
    if not rows:
        return ""
    told = "Nothing of this was set by hand: each number was drawn along with the subgoals, from its own prior."
    grouped = posterior.settings.model.startswith("Grouped(")
    more = note(f"{GROUPS_DO_NOT_LAST[0].upper()}{GROUPS_DO_NOT_LAST[1:]}.") if grouped else ""
    listed = table(("Number", "Mean", "90 % of the draws", "What it is"), rows)
    return section("Learned numbers", lead(told) + listed + more)


def _numbers(posterior: Posterior) -> Iterator[tuple[str, ...]]:
    for name, draws in posterior.parameters.items():
        if draws.ndim != 2:
            continue
        title, meaning = MEANINGS.get(name, (name, ""))
        if name == "persistence":
            steps = float(1 / np.maximum(1 - draws, 1e-12).mean())
            meaning += f"; it is drawn anew every {in_time(posterior, steps)} on average"
        low, high = np.quantile(draws, [0.05, 0.95])
        yield text(title), f"{draws.mean():.3g}", f"{low:.3g} – {high:.3g}", text(meaning)


def _levels(posterior: Posterior) -> Iterator[tuple[str, ...]]:
    """Shares of the levels of confidence, each with what it means for actions."""
    draws = posterior.parameters.get(LEVELS)
    law = None if posterior.likelihood is None else posterior.likelihood.confidence
    if draws is None or not isinstance(law, Levels):
        return
    flat = draws.reshape(-1, draws.shape[-1])
    for m, alpha in enumerate(law.confidences.tolist()):
        low, high = np.quantile(flat[:, m], [0.05, 0.95])
        yield (
            text(f"Actions of α = {alpha:g}"), short(float(flat[:, m].mean())),
            f"{100 * low:.0f} – {100 * high:.0f} %", text(_spread(posterior, alpha)),
        )  # fmt: skip


def _spread(posterior: Posterior, alpha: float) -> str:
    """What the share of one confidence is, and how far half of such actions lie from what their subgoal asks for."""
    source: Any = None if posterior.likelihood is None else posterior.likelihood.source
    law = None if source is None else source.distance_law(alpha)
    if law is None:
        return "share of the actions"
    grid = np.linspace(0, law.upper, 4001)
    half = float(np.interp(0.5, law.cdf(grid), grid))
    if source.kind != "directions":
        return f"share of the actions; half of them are within {half:.2g} of what the subgoal asks for"
    angle = float(np.degrees(2 * np.arcsin(min(half / 2, 1.0))))
    told = f"share of the actions; half of them are within {angle:.2g}° of the way to the subgoal"
    return told + (" (all but free)" if angle > 60 else "")


def counting_section(posterior: Posterior) -> str:
    """What each observation counts and why; empty where the likelihood or the assignments are lost."""
    likelihood = posterior.likelihood
    if likelihood is None or posterior.assignments is None or isinstance(likelihood.source, FixedTable):
        return ""
    found = evidence(posterior)
    weight = np.ones(posterior.n_observations) if likelihood.weight is None else np.asarray(likelihood.weight)
    sentence, fine = counting_words(posterior, weight, found)
    alarm = "" if fine else f'<p class="fail">{text(too_sure(found))}</p>'
    alarm += f'<p class="fail">{text(UNSETTLED.capitalize())}.</p>' if posterior.weight_settled is False else ""
    rows = [
        ("Observations", f"{posterior.n_observations:,}"),
        ("Weight of each", _weights(weight)),
        ("Independent ones they count for", f"{weight.sum():,.0f}"),
        ("Autocorrelation time of the errors", text(in_time(posterior, found.time, 1))),
    ]
    how = note(
        "Weights are powers of the likelihood. The autocorrelation time is 1 + 2 Σ of the correlations of errors that "
        "are above chance, in this answer."
    )
    return section("What each observation counts", lead(sentence) + alarm + table(("What", "How much"), rows) + how)


def counting_words(posterior: Posterior, weight: Floats, found: Evidence) -> tuple[str, bool]:
    """How serial correlation was accounted for, and whether that is enough."""
    product = float(found.time * weight.mean())
    fine = product <= 1 + SAME or found.time <= FULL
    n, worth = counted(posterior.n_observations, "observation"), float(weight.sum())
    if np.ptp(weight) > 0:
        return f"Weights differ: {n} count as {worth:,.0f} independent ones.", fine
    if weight[0] == 1:
        if found.time <= FULL:
            return "Errors of neighbouring actions are not correlated, so every observation counts in full.", fine
        return "Every observation counts in full.", fine
    row = in_time(posterior, 1 / float(weight[0]), 1)
    agrees = " The errors that are left agree with that." if abs(product - 1) <= SAME else ""
    return (
        f"Neighbouring actions share their errors, so that {row} in a row say as much as one independent observation: "
        f"each counts as {weight[0]:.2f}, and {n} as {worth:,.0f}.{agrees}"
    ), fine


def too_sure(found: Evidence) -> str:
    """What is wrong and what to do."""
    return (
        f"Errors of neighbouring actions are correlated over {found.time:.1f} observations, more than their weight "
        "allows for: the answer is surer than it should be. Try subgoal.learn(likelihood) (--learn-all), or a weight "
        f"of {found.weight:.2g}."
    )


def in_time(posterior: Posterior, steps: float, digits: int = 0) -> str:
    """ "13 observations (2.6 s)": a number of observations, and how long that is."""
    demos = posterior.demonstrations
    told = f"{steps:.{digits}f} observation" + ("" if f"{steps:.{digits}f}" == "1" else "s")
    if demos.times is None or demos.time_unit in ("sample", "step"):
        return told
    gaps = np.diff(demos.times)[np.diff(demos.trajectory) == 0]
    return f"{told} ({steps * float(np.median(gaps)):.3g} {demos.time_unit})" if gaps.size else told


def _weights(weight: Floats) -> str:
    return f"{weight[0]:.3g}" if np.ptp(weight) == 0 else f"{weight.min():.3g} – {weight.max():.3g}"
