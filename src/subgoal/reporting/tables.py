"""Tables and definitions of the report as HTML; every string goes through ``safe.text``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import COUNTED_FROM, CREDIBLE, LISTED_FROM, Subgoal, Subgoals, reaches
from subgoal.plots.style import colour, ink_on, with_unit
from subgoal.plots.words import compact, decimals, extent_of, percent, trajectories
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.safe import text

MOST_SEGMENTS = 200
MEANINGS = (
    ("Subgoal", "A place the demonstrator headed for. Candidates that stand for one place are merged into it."),
    ("Position", "Where its most probable candidate lies."),
    ("Share", "How much of the observations serves it in expectation, with the range that holds 90 % of the draws."),
    (f"P(≥ {percent(LISTED_FROM)})", "Posterior probability that at least this share of the observations serves it: "
     "how sure it is that the place is a subgoal at all."),
    ("Members", "How many candidates were merged into it."),
    ("Radius", f"Largest distance from the position to a member of the {percent(CREDIBLE)} credible set: "
     "how well the place is known. 0 means that one candidate holds it all."),
    ("Number of subgoals", f"Only those that hold at least {percent(COUNTED_FROM)} of the observations are counted."),
    ("Segment", "A run of observations of one trajectory with the same most probable subgoal."),
    ("Segment probability", "Mean over the run of the posterior probability of that subgoal."),
    ("Converged", "All chains agree on every summary below: R-hat at most 1.01, effective sample sizes of at least "
     "400. Otherwise the numbers may change with more sweeps."),
)  # fmt: skip


def table(
    heads: Sequence[str], rows: Iterable[Sequence[str]], *, stack: bool = True, labels: Sequence[str] | None = None
) -> str:
    """A table of ready cells; on a narrow screen each row becomes a block with the heads beside the cells.

    ``labels`` stand there for heads that are more than text.
    """
    beside = heads if labels is None else labels
    top = "".join(f"<th>{head}</th>" for head in heads)
    body = "".join(
        "<tr>"
        + "".join(f'<td data-label="{head}"><span>{cell}</span></td>' for head, cell in zip(beside, row, strict=True))
        + "</tr>"
        for row in rows
    )
    kind = ' class="stack"' if stack else ""
    return f"<table{kind}><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def chip(k: int) -> str:
    """The number of the k-th listed subgoal in its colour."""
    shade = colour(k)
    number = str(k + 1) if k >= 0 else "–"
    return f'<span class="chip" style="background:{shade};color:{ink_on(shade)}">{number}</span>'


def short(share: float) -> str:
    """A percentage for a cell."""
    return percent(share).replace("over", "&gt;").replace("under", "&lt;")


def subgoal_table(posterior: Posterior, found: Subgoals) -> str:
    """One row per listed subgoal."""
    extent, demos = extent_of(posterior), posterior.demonstrations
    digits = decimals(extent)
    rows = []
    for k, goal in enumerate(found.listed):
        low, high = goal.share_interval
        rows.append((
            chip(k) + (text(goal.name) if goal.name != f"subgoal {goal.label}" else "") + _not_counted(goal),
            compact(goal.position, extent),
            f"{short(goal.share)} <small>{100 * low:.0f}–{100 * high:.0f} %</small>",
            short(goal.inclusion),
            str(len(goal.members)),
            f"{goal.radius:.{digits}f}" if goal.radius else "0",
        ))  # fmt: skip
    named = len(demos.names) == posterior.candidates.points.shape[1]
    place = f"Position ({', '.join(demos.names)})" if named else "Position"
    position, radius = (text(with_unit(what, demos.units)) for what in (place, "Radius"))
    heads = ("Subgoal", position, "Share", f"P(≥ {percent(LISTED_FROM)})", "Members", radius)
    return table(heads, rows)


def _not_counted(goal: Subgoal) -> str:
    below = f"below {percent(COUNTED_FROM)}"
    return "" if reaches(goal.share, COUNTED_FROM) else f" <small>not counted: {text(below)}</small>"


def segment_table(posterior: Posterior, found: Subgoals, cut: Segments) -> str:
    """The first 200 segments."""
    demos = posterior.demonstrations
    unit = demos.time_unit if demos.times is not None else "row"
    rows = []
    for segment in cut.items[:MOST_SEGMENTS]:
        name = found.listed[segment.subgoal].name if segment.subgoal >= 0 else "no listed subgoal"
        rows.append((
            text(demos.trajectory_names[segment.trajectory]), chip(segment.subgoal) + text(name),
            f"{segment.begin:.6g}", f"{segment.end:.6g}", str(segment.stop - segment.start),
            short(segment.probability),
        ))  # fmt: skip
    heads = ("Trajectory", "Subgoal", text(f"From [{unit}]"), text(f"To [{unit}]"), "Observations", "Probability")
    more = len(cut) - len(rows)
    note = f'<p class="note">{more:,} more segments are not listed here.</p>' if more > 0 else ""
    return table(heads, rows) + note


def meanings() -> str:
    """What each number means."""
    return "<dl>" + "".join(f"<dt>{text(what)}</dt><dd>{text(said)}</dd>" for what, said in MEANINGS) + "</dl>"


def diagnostics_table(posterior: Posterior) -> str:
    """R-hat and effective sample sizes of each summary."""
    rows = []
    for name, each in posterior.diagnostics.items():
        verdict = "passes" if each.passes else '<span class="fail">fails</span>'
        rhat = f"{each.rhat:.4f}" if np.isfinite(each.rhat) else "undefined"
        rows.append((text(name), rhat, f"{each.ess_bulk:,.0f}", f"{each.ess_tail:,.0f}", verdict))
    return table(("Summary", "R-hat", "Bulk sample size", "Tail sample size", "Gate"), rows)


def provenance_table(posterior: Posterior, found: Subgoals) -> str:
    """Everything that decides the numbers, and what was done to the data on the way in."""
    demos, used, source = posterior.demonstrations, posterior.settings, posterior.demonstrations.source
    slow = int(np.asarray(posterior.uninformative).sum())
    radius = posterior.candidates.radius
    facts = {
        "data": f"{source.name} {f'(checksum {source.checksum[:16]})' if source.checksum else ''}",
        "observations": f"{demos.n_observations:,} in {trajectories(demos.n_trajectories)}",
        "unit of the times": "none" if demos.times is None else demos.time_unit,
        **{f"data: {what}": f"{count:,}" for what, count in source.notes.items()},
        "observations that say nothing": f"{slow:,} (kept; every candidate is as likely)",
        "candidates": f"{posterior.candidates.n_candidates:,}, radius {radius:.4g} {demos.units}",
        "merged within": f"{found.merge_radius:.4g} {demos.units}",
        "likelihood": used.likelihood,
        **({"planner": used.planner} if used.planner else {}),
        "confidence": f"{posterior.confidence:g}",
        "concentration": f"{posterior.concentration:g}",
        "sampler": used.sampler,
        "chains × draws": f"{posterior.n_chains} × {posterior.n_draws:,}",
        "warm-up, thin": f"{used.warmup:,}, {used.thin}",
        "seed": str(used.seed),
        "checksum of data and candidates": used.data,
        "version": f"subgoal {used.version}",
        "seconds": f"{posterior.seconds:.2f}",
    }
    return table(("Setting", "Value"), ((text(what), text(value)) for what, value in facts.items()))
