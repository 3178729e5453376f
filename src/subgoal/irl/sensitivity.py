"""How much the answer hangs on what was chosen by hand: the same data under other priors, weights and rates."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from subgoal.answers.subgoals import Subgoal, Subgoals, subgoals
from subgoal.irl.as_sampled import as_sampled
from subgoal.irl.learn import learn
from subgoal.irl.reruns import Rerun, Sensitivity
from subgoal.irl.variations import Variation, variations
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import StoppedError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, progress_display

SHORT: Mapping[str, int] = {"chains": 4, "draws": 200, "warmup": 300, "thin": 3}
"""Long enough to find the places and their shares, too short for the gate."""
WITHIN = 2.0
"""A place of a rerun within so many merge radii of a place of the answer can be the same."""


def sensitivity(
    posterior: Posterior,
    *,
    found: Subgoals | None = None,
    model: Sampler | None = None,
    reweigh: bool = True,
    seed: int = 1,
    workers: int | None = None,
    progress: Progress | None = None,
    **length: int,
) -> Sensitivity:
    """Sample again under other settings and hold the answers beside that of the posterior.

    The settings: nothing changed (what differs there is chance); the concentration halved and doubled, or shape and
    rate of its prior; a fixed confidence halved and doubled; the weight of an observation halved and doubled, where it
    has one; every second and every fourth observation only. Subgoals are the same where their places lie within
    2 merge radii, so that most of the shares are matched.

    Parameters
    ----------
    posterior:
        From ``sample``, ``learn`` or ``load``, with its likelihood.
    found:
        Its merged subgoals; made if not given.
    model:
        A model or sampler of your own, if the posterior is from one.
    reweigh:
        Where all observations have one weight, it is estimated anew when the rate changes, as ``learn`` does; False
        keeps it, as is done where weights differ.
    seed, workers:
        As in ``sample``.
    progress:
        Told how many sweeps are done; by default a bar on a terminal and lines elsewhere.
    length:
        ``chains``, ``draws``, ``warmup`` and ``thin`` of each rerun, if not short ones.

    Returns
    -------
    Sensitivity. Ctrl-C gives the reruns that are finished, and names the others.

    Raises ``InputError`` where the likelihood is lost, or the model is neither of this library nor given.
    """
    used = as_sampled(posterior, model)
    base = subgoals(posterior) if found is None else found
    top = tuple(item for item in base.items[: base.n_subgoals])
    planned = variations(used, reweigh=reweigh)
    made = {**SHORT, **length}
    sweeps = made["chains"] * (made["warmup"] + made["draws"] * made["thin"])
    run: dict[str, Any] = {**made, "seed": seed, "workers": workers}
    rows = [_row("as sampled", "as sampled", 1, posterior, base, base, top)]
    display = progress_display("sensitivity") if progress is None else progress
    with Interrupt() as interrupt, display:
        for k, variation in enumerate(planned):
            if interrupt.requested:
                break
            again = _sampled(variation, run, _Part(display, k * sweeps, len(planned) * sweeps, variation.setting))
            if again is None:
                break
            own = subgoals(again, merge_radius=base.merge_radius)
            rows.append(_row(variation.setting, variation.kind, variation.every, again, own, base, top))
    left = tuple(variation.setting for variation in planned[len(rows) - 1 :])
    return Sensitivity(top, tuple(rows), left, posterior.demonstrations.units)


def _sampled(variation: Variation, run: dict[str, Any], part: Progress) -> Posterior | None:
    """The whole posterior of one setting, or None if Ctrl-C came."""
    draw = learn if variation.reweighed else sample
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            again = draw(variation.likelihood, **variation.arguments, **run, progress=part)
    except StoppedError:
        return None
    return again if again.n_draws == run["draws"] else None


class _Part:
    """The progress of one rerun among all."""

    def __init__(self, display: Progress, before: int, total: int, note: str) -> None:
        self.display, self.before, self.total, self.note = display, before, total, note

    def __enter__(self) -> _Part:
        return self

    def __exit__(self, *failure: Any) -> None:
        return None

    def update(self, done: int, total: int, note: str = "") -> None:
        """So many sweeps of this rerun are done."""
        self.display.update(self.before + done, self.total, self.note)


def _row(
    setting: str, kind: str, every: int, posterior: Posterior, found: Subgoals, base: Subgoals, top: tuple[Subgoal, ...]
) -> Rerun:
    places, shares, moved = matched(top, found, posterior, WITHIN * base.merge_radius)
    kept = posterior.parameters.get("persistence")
    weight = None if posterior.likelihood is None else posterior.likelihood.weight
    worst = [each.rhat for each in posterior.diagnostics.values()]
    return Rerun(
        setting=setting, kind=kind, every=every, n_observations=posterior.n_observations,
        worth=float(posterior.n_observations if weight is None else np.sum(weight)), n_subgoals=found.n_subgoals,
        places=places, shares=shares, moved=moved, change=shares - np.array([goal.share for goal in top]),
        persistence=float("nan") if kept is None else float(kept.mean()), concentration=posterior.concentration,
        rhat=max(worst, default=float("nan")), status=posterior.status,
    )  # fmt: skip


def matched(
    top: tuple[Subgoal, ...], found: Subgoals, posterior: Posterior, within: float
) -> tuple[Floats, Floats, Floats]:
    """Places (S, d), shares (S,) and distances moved (S,) of the subgoals that are those of ``top``.

    Each is that of at most one; only those ``within`` a distance count, and together they match as much of the shares
    as can be, nearer ones before others. NaN, 0 and NaN where there is none.
    """
    places = np.full((len(top), posterior.candidates.points.shape[1]), np.nan)
    shares, moved = np.zeros(len(top)), np.full(len(top), np.nan)
    if not top or not found.items:
        return places, shares, moved
    here = np.array([goal.position for goal in top])
    there = np.array([goal.position for goal in found.items])
    gap = posterior.candidates.metric.distance(here[:, None], there[None])
    share = np.array([goal.share for goal in found.items])
    both = np.minimum(np.array([goal.share for goal in top])[:, None], share)
    nearness = 1 - 0.5 * gap / within if within > 0 else np.ones(gap.shape)
    gain = np.where(gap <= within, both * nearness, 0.0)
    for s, k in zip(*linear_sum_assignment(gain, maximize=True), strict=True):
        if gain[s, k] > 0:
            places[s], shares[s], moved[s] = there[k], share[k], gap[s, k]
    return places, shares, moved
