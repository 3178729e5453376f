"""The folder of results: tables, summary, saved posterior, figures and report, all or nothing."""

from __future__ import annotations

import csv
import json
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from subgoal.answers.portraits import portraits
from subgoal.answers.residuals import residuals
from subgoal.answers.segments import OTHER, Segments, segments
from subgoal.answers.subgoals import COUNTED_FROM, Subgoals, reaches, subgoals
from subgoal.irl.compare import Comparison
from subgoal.irl.reruns import Sensitivity
from subgoal.irl.sweep_record import Sweep
from subgoal.posterior.archive import save
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.groups import shares_of_groups
from subgoal.reporting.learned import learned_numbers, weight_numbers
from subgoal.reporting.page import report
from subgoal.runtime.errors import InputError

STALE = (
    "residuals.png", "residuals.svg", "groups.csv", "sensitivity.csv", "comparison.csv", "comparison.png",
    "comparison.svg", "portraits.png", "portraits.svg", "sweep.csv", "sweep.png", "sweep.svg",
)  # fmt: skip
"""Files that not every posterior gives, taken away when a new result has none."""


@dataclass(frozen=True)
class Results:
    """What was written: the folder, and the answers in it."""

    folder: Path
    found: Subgoals
    cut: Segments


def write_results(
    posterior: Posterior,
    folder: str | Path,
    *,
    merge_radius: float | None = None,
    y_down: bool = False,
    found: Subgoals | None = None,
    sensitivity: Sensitivity | None = None,
    comparison: Comparison | None = None,
    sweep: Sweep | None = None,
) -> Results:
    """Write ``subgoals.csv``, ``segments.csv``, ``summary.json``, ``posterior.npz``, figures and ``report.html``.

    Where the demonstrations have groups there is ``groups.csv`` too; with a ``sensitivity`` its table
    ``sensitivity.csv``; with a ``comparison`` or a ``sweep`` over the confidence ``comparison.csv`` or ``sweep.csv``
    and a picture of it. ``found`` are the subgoals, made with ``merge_radius`` if not given.
    Everything is written to a folder beside the results and moved in at the end, so that a run that fails leaves the
    old results whole. Raises ``InputError`` when the folder cannot be written.
    """
    folder = Path(folder)
    found = subgoals(posterior, merge_radius=merge_radius) if found is None else found
    cut = segments(posterior, found)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        aside = Path(tempfile.mkdtemp(prefix=".writing-", dir=folder))
    except OSError as problem:
        raise InputError("results folder", found=str(problem), wanted="a folder that can be written") from None
    try:
        _write_tables(posterior, found, cut, aside, y_down)
        _write_more(posterior, found, sensitivity, aside)
        _write_comparison(comparison, aside)
        _write_sweep(sweep, aside)
        _draw(posterior, found, cut, aside, y_down)
        save(posterior, aside / "posterior.npz")
        page = aside / "report.html"
        report(
            posterior, page, found=found, cut=cut, sensitivity=sensitivity, comparison=comparison, sweep=sweep,
            y_down=y_down,
        )  # fmt: skip
        written = {path.name for path in aside.iterdir()}
        for name in sorted(written):
            (aside / name).replace(folder / name)
        for name in set(STALE) - written:
            (folder / name).unlink(missing_ok=True)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return Results(folder, found, cut)


def _write_tables(posterior: Posterior, found: Subgoals, cut: Segments, folder: Path, y_down: bool) -> None:
    names = posterior.demonstrations.names
    heads = (
        "subgoal", "name", *names, "share", "expected_observations", "share_low", "share_high", "inclusion",
        "prominence", "radius", "members",
    )  # fmt: skip
    _write_csv(folder / "subgoals.csv", heads, ([
        goal.label, goal.name, *goal.position, goal.share, goal.expected_observations, *goal.share_interval,
        goal.inclusion, goal.prominence, goal.radius, goal.members.size,
    ] for goal in found))  # fmt: skip
    heads = ("trajectory", "subgoal", "name", "start", "stop", "begin", "end", "probability")
    _write_csv(folder / "segments.csv", heads, ([
        posterior.demonstrations.trajectory_names[s.trajectory], "" if s.subgoal == OTHER else s.subgoal + 1,
        "other" if s.subgoal == OTHER else found.listed[s.subgoal].name, s.start, s.stop, s.begin, s.end, s.probability,
    ] for s in cut))  # fmt: skip
    text = json.dumps({**summary(posterior, found, cut), "y_down": y_down}, indent=1, allow_nan=False)
    (folder / "summary.json").write_text(text + "\n", encoding="utf-8")


def _write_more(posterior: Posterior, found: Subgoals, sensitivity: Sensitivity | None, folder: Path) -> None:
    """Tables that not every result has."""
    shares = shares_of_groups(posterior, found)
    if shares is not None:
        heads: tuple[str, ...] = ("group", "observations", "subgoal", "name", "share", "share_low", "share_high")
        _write_csv(folder / "groups.csv", heads, (
            [name, int(shares.sizes[k]), goal.label, goal.name, float(shares.share[k, s]),
             *shares.interval[k, s].tolist()]
            for k, name in enumerate(shares.names) for s, goal in enumerate(shares.subgoals.listed)
        ))  # fmt: skip
    if sensitivity is not None:
        heads = (
            "setting", "kind", "observations", "worth", "subgoals", "missing", "largest_move", "largest_share_change",
            "persistence", "concentration", "rhat", "status",
        )  # fmt: skip
        _write_csv(folder / "sensitivity.csv", heads, ([
            row.setting, row.kind, row.n_observations, row.worth, row.n_subgoals, row.lost, row.largest_move,
            row.largest_change, row.persistence, row.concentration, row.rhat, row.status.name,
        ] for row in sensitivity.rows))  # fmt: skip


def _write_comparison(found: Comparison | None, folder: Path) -> None:
    if found is None:
        return
    from subgoal.plots.comparison import plot_comparison
    from subgoal.plots.files import save_figure

    heads = (
        "method", "name", "bits_per_decision", "standard_error", "wrong", "size", "unit", "seconds", "folds_converged",
        "folds",
    )  # fmt: skip
    _write_csv(folder / "comparison.csv", heads, ([
        each.key, each.name, each.bits_per_decision, each.standard_error, each.loss, each.size, each.unit,
        each.seconds, *each.converged,
    ] for each in found.methods))  # fmt: skip
    save_figure(plot_comparison(found), folder, "comparison")


def _write_sweep(found: Sweep | None, folder: Path) -> None:
    if found is None:
        return
    from subgoal.plots.files import save_figure
    from subgoal.plots.sweep import plot_sweep

    _write_csv(folder / "sweep.csv", ("confidence", "trial", "subgoals"), (
        [float(level), k, int(count)] for level, row in zip(found.confidences, found.counts, strict=True)
        for k, count in enumerate(row)
    ))  # fmt: skip
    save_figure(plot_sweep(found), folder, "sweep")


def summary(posterior: Posterior, found: Subgoals, cut: Segments) -> dict[str, Any]:
    """The numbers of ``summary.json``."""
    demos = posterior.demonstrations
    return {
        "n_subgoals": found.n_subgoals,
        "n_subgoals_distribution": found.n_subgoals_distribution,
        "subgoals": [
            {"label": g.label, "name": g.name, "position": g.position.tolist(), "share": g.share, "radius": g.radius,
             "inclusion": g.inclusion, "counted": reaches(g.share, COUNTED_FROM)}
            for g in found
        ],
        "n_segments": len(cut),
        "merge_radius": found.merge_radius,
        "status": posterior.status.name,
        "converged": posterior.status is Status.CONVERGED,
        "status_text": posterior.status.value,
        "diagnostics": {name: _finite(asdict(each)) for name, each in posterior.diagnostics.items()},
        "observations": demos.n_observations,
        "trajectories": demos.n_trajectories,
        "learned": learned_numbers(posterior),
        "weight_of_evidence": weight_numbers(posterior),
        "uninformative_observations": int(posterior.uninformative.sum()),
        "candidates": posterior.candidates.n_candidates,
        "candidate_radius": posterior.candidates.radius,
        "units": demos.units,
        "time_unit": demos.time_unit,
        "source": asdict(demos.source),
        "settings": asdict(posterior.settings),
        "draws_made": posterior.n_draws,
        "sampling_seconds": posterior.seconds,
    }  # fmt: skip


def drawn_downwards(folder: Path) -> bool:
    """Whether the pictures of a folder of results were drawn with y downwards."""
    return _kept(folder, "y_down") is True


def merged_within(folder: Path) -> float | None:
    """The merge radius of a folder of results; None where it is not told."""
    radius = _kept(folder, "merge_radius")
    return float(radius) if isinstance(radius, (int, float)) and 0 <= radius < float("inf") else None


def _kept(folder: Path, name: str) -> Any:
    """What ``summary.json`` says; None where it says nothing."""
    try:
        return json.loads((folder / "summary.json").read_text(encoding="utf-8")).get(name)
    except (OSError, ValueError, AttributeError):
        return None


def _finite(numbers: dict[str, float]) -> dict[str, float | None]:
    return {name: value if abs(value) < float("inf") else None for name, value in numbers.items()}


def _write_csv(path: Path, heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(heads)
        writer.writerows([repr(float(cell)) if isinstance(cell, float) else cell for cell in row] for row in rows)


def _draw(posterior: Posterior, found: Subgoals, cut: Segments, folder: Path, y_down: bool) -> None:
    from subgoal.plots.counts import plot_count_posterior, plot_subgoal_count
    from subgoal.plots.files import save_figure
    from subgoal.plots.fit import plot_residuals
    from subgoal.plots.portraits import plot_portraits
    from subgoal.plots.strips import plot_segments
    from subgoal.plots.trajectories import plot_trajectories

    figures = {
        "trajectories": plot_trajectories(posterior, found, cut, y_down=y_down),
        "segments": plot_segments(posterior, found, cut),
        "subgoal_count": plot_subgoal_count(posterior),
        "count_posterior": plot_count_posterior(found),
    }
    seen = portraits(posterior, found)
    if seen is not None:
        figures["portraits"] = plot_portraits(posterior, found, seen)
    fit = residuals(posterior)
    if fit is not None:
        figures["residuals"] = plot_residuals(posterior, fit)
    for name, figure in figures.items():
        save_figure(figure, folder, name)
