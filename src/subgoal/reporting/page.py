"""``report``: one self-contained HTML page of a posterior."""

from __future__ import annotations

import contextlib
import secrets
from pathlib import Path
from typing import Any

from subgoal.answers.residuals import residuals
from subgoal.answers.segments import Segments, segments
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.irl.compare import Comparison
from subgoal.irl.reruns import Sensitivity
from subgoal.irl.sweep_record import Sweep
from subgoal.plots.shown import is_unordered
from subgoal.plots.words import certainty, headline, reading, sure
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.boundaries import boundary_section
from subgoal.reporting.comparison import comparison_section
from subgoal.reporting.groups import group_section, shares_of_groups
from subgoal.reporting.interactive import count_figure, residual_figures, strip_figure, trace_figure
from subgoal.reporting.learned import counting_section, learned_section
from subgoal.reporting.pieces import details, section
from subgoal.reporting.portraits import portrait_section
from subgoal.reporting.safe import script_json, text
from subgoal.reporting.scene import scene_figure
from subgoal.reporting.sensitivity import rate_section, sensitivity_section
from subgoal.reporting.style import CSS
from subgoal.reporting.sweep import sweep_section
from subgoal.reporting.tables import diagnostics_table, meanings, provenance_table, segment_table, subgoal_table

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:; "
    "form-action 'none'; base-uri 'none'"
)
"""The browser itself refuses whatever would leave the page."""
DRAW = """
for (const [id, figure] of Object.entries(JSON.parse(document.getElementById("figures").textContent)))
  Plotly.newPlot(id, figure.data, figure.layout, {
    responsive: true, displaylogo: false, displayModeBar: id === "scene" ? "hover" : false, plotlyServerURL: "",
    showSendToCloud: false, modeBarButtonsToRemove: ["sendChartToCloud", "sendDataToCloud",
      "lasso2d", "select2d", "autoScale2d", "tableRotation"]});
"""


def report(
    posterior: Posterior,
    path: str | Path,
    *,
    found: Subgoals | None = None,
    cut: Segments | None = None,
    sensitivity: Sensitivity | None = None,
    comparison: Comparison | None = None,
    sweep: Sweep | None = None,
    title: str | None = None,
    y_down: bool = False,
) -> Path:
    """Write one HTML page that says what was found, how sure that is, and what it rests on.

    Parameters
    ----------
    path:
        The file to write; it is complete in itself and works offline.
    found, cut:
        Subgoals and segments of this posterior; computed if not given.
    sensitivity:
        That of this posterior, to be shown; it takes a while, so it is not computed here.
    comparison:
        Other methods on the same demonstrations, to be shown.
    sweep:
        How many subgoals there are at each confidence, to be shown.
    title:
        A line above the headline; the name of the data if not given.
    y_down:
        The second axis points down, as in images.

    Returns
    -------
    The path. A reader finds the old file or the new one, never half of one.
    """
    found = subgoals(posterior) if found is None else found
    cut = segments(posterior, found) if cut is None else cut
    figures: dict[str, Any] = {}
    body = "\n".join([
        _first_screen(posterior, found, cut, title, y_down, figures),
        group_section(shares_of_groups(posterior, found), figures),
        _strip(posterior, found, cut, figures),
        boundary_section(posterior, found, cut, figures),
        details("What each number means", meanings()),
        portrait_section(posterior, found, figures),
        _counts(posterior, found, figures),
        comparison_section(comparison),
        _fit(posterior, figures),
        sweep_section(posterior, sweep, figures),
        sensitivity_section(sensitivity),
        rate_section(posterior, sensitivity),
        counting_section(posterior),
        learned_section(posterior),
        section("Convergence", diagnostics_table(posterior)),
        section("Settings and provenance", provenance_table(posterior, found)),
    ])  # fmt: skip
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    _write(target, _page(title or headline(posterior, found), body, figures))
    return target


def _page(title: str, body: str, figures: dict[str, Any]) -> str:
    from plotly.offline import get_plotlyjs

    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{text(title)}</title>
<style>{CSS}</style></head>
<body><main>
{body}
</main>
<script type="application/json" id="figures">{script_json(figures)}</script>
<script>{get_plotlyjs()}</script>
<script>{DRAW}</script>
</body></html>
"""


def _first_screen(
    posterior: Posterior, found: Subgoals, cut: Segments, title: str | None, y_down: bool, figures: dict[str, Any]
) -> str:
    figures["scene"], note = scene_figure(posterior, found, cut, y_down=y_down)
    return f"""<header><p class="eyebrow">{text(title or posterior.demonstrations.source.name)}</p>
<h1>{text(headline(posterior, found))}</h1>
<p class="sub">{text(certainty(found, posterior).capitalize())}</p>
{_badge(posterior.status)}</header>
<div class="first"><div class="card"><div class="plot" id="scene"></div>
<p class="note">Discs are subgoals, grey lines trajectories; a click in the legend hides a subgoal.
{text(note and note[0].upper() + note[1:] + ".")}</p></div>
<div class="card"><h2>Subgoals</h2>{subgoal_table(posterior, found)}</div></div>"""


def _badge(status: Status) -> str:
    """Green or red, in words."""
    word, _, rest = status.value.partition(":")
    if status is Status.INTERRUPTED:
        word, rest = "INTERRUPTED", status.value.removeprefix("INTERRUPTED")
    kind = "good" if status is Status.CONVERGED else "bad"
    return f'<p class="badge {kind}" role="status"><b>{text(word.upper())}</b> {text(rest.strip())}</p>'


def _strip(posterior: Posterior, found: Subgoals, cut: Segments, figures: dict[str, Any]) -> str:
    if is_unordered(posterior.demonstrations):
        return ""
    figures["strip"] = strip_figure(posterior, found, cut)
    rows = len(figures["strip"]["layout"]["yaxis"]["ticktext"])
    left_out = posterior.demonstrations.n_trajectories - rows
    more = f" {left_out:,} more trajectories are not shown." if left_out > 0 else ""
    told = f'<p class="sub">Which part serves which subgoal; the paler, the less sure.{more}</p>'
    listed = details(f"Table of {len(cut):,} segments", segment_table(posterior, found, cut))
    return section("Segments", f'{told}<div class="plot" id="strip"></div>') + listed


def _counts(posterior: Posterior, found: Subgoals, figures: dict[str, Any]) -> str:
    figures["count"], figures["traces"] = count_figure(found), trace_figure(posterior)
    return f"""<div class="pair"><div class="card"><h2>How many subgoals</h2>
<p class="sub">{text(sure(found, posterior))}</p><div class="plot" id="count"></div></div>
<div class="card"><h2>Chains</h2><p class="sub">They should look alike, without a trend after the warm-up.</p>
<div class="plot" id="traces"></div></div></div>"""


def _fit(posterior: Posterior, figures: dict[str, Any]) -> str:
    seen = residuals(posterior)
    if seen is None:
        return ""
    figures["distance"], figures["transform"] = residual_figures(seen)
    return section(
        "Does the confidence fit?",
        f'<p class="sub">{text(reading(posterior, seen))}</p><div class="pair"><div class="plot" id="distance"></div>'
        '<div class="plot" id="transform"></div></div>',
    )


def _write(path: Path, page: str) -> None:
    aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        aside.write_text(page, encoding="utf-8")
        aside.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            aside.unlink()
