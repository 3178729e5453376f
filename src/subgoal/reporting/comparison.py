"""The section that sets other accounts of the demonstrator beside subgoals."""

from __future__ import annotations

from subgoal.irl.compare import Compared, Comparison
from subgoal.plots.comparison import comparison_words, one_reward_words
from subgoal.reporting.pieces import lead, note, section
from subgoal.reporting.safe import text
from subgoal.reporting.tables import table

HEADS = (
    "Method", "Bits per decision ± standard error", "Behind the best (95 %, paired)", "Wrong", "Size", "Seconds",
    "Converged",
)  # fmt: skip


def comparison_section(found: Comparison | None) -> str:
    """A line for each method, the best first; empty where nothing was compared."""
    if found is None:
        return ""
    told = [
        "Each trajectory is foretold by fits to the trajectories of other folds, action by action. 0 bits is "
        "certainty. “Wrong” counts decisions in which the likeliest action was not taken.",
        *([f"{found.setting}."] if found.setting else []),
        *([f"Stopped before: {', '.join(found.unfinished)}."] if found.unfinished else []),
        *(f"{name} could not be fitted: {why}" for name, why in found.failed.items()),
    ]
    rows = [_row(found, each) for each in found.methods]
    return section(
        "Is one reward enough?",
        lead(f"{one_reward_words(found)}. {comparison_words(found)}.")
        + table(list(HEADS), rows)
        + "".join(note(each) for each in told),
    )


def _row(found: Comparison, each: Compared) -> tuple[str, ...]:
    gap = found.behind(each)
    low, high = gap.interval
    behind = "–" if each is found.best else f"{gap.bits_per_decision:.3f} ({low:.3f} to {high:.3f})"
    done, folds = each.converged
    status = "yes" if done == folds else f'<span class="fail">{done} of {folds} folds</span>'
    size = f"{each.size:.0f} {text(each.unit)}" if each.unit else "–"
    return (
        text(each.name), f"{each.bits_per_decision:.3f} ± {each.standard_error:.3f}", behind, f"{each.loss:.1%}", size,
        f"{each.seconds:.1f}", status,
    )  # fmt: skip
