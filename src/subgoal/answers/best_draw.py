"""The likeliest assignment that was drawn, and by how many nats some other might be better, at most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subgoal.optima import MapPartition, map_partition
from subgoal.posterior.posterior import EXCHANGEABLE, Posterior
from subgoal.runtime.checks import whole

BOUND_STEPS = 300


@dataclass(frozen=True, eq=False, repr=False)
class BestDraw:
    """The draw of highest log joint, with a certificate where there is one.

    Attributes
    ----------
    assignment:
        (N,) candidate of each observation, −1 for the background: ``Posterior.best_assignment``.
    log_joint:
        log p(θ, O) in nats, weights integrated out, with the densities of whatever else was learned.
    gap:
        Nats by which the log joint of some other assignment may be higher, at most; None where no bound is known.
    upper_bound:
        No assignment has a higher log joint; None where no bound is known.
    improved, improved_log_joint:
        (N,) where local search from the draw ends, and its log joint; None where no bound is known.
    why_no_gap:
        What stands against a bound; empty where there is one.
    """

    assignment: NDArray[np.int32]
    log_joint: float
    gap: float | None = None
    upper_bound: float | None = None
    improved: NDArray[np.int32] | None = None
    improved_log_joint: float | None = None
    why_no_gap: str = ""

    def __repr__(self) -> str:
        told = "gap unknown" if self.gap is None else f"at most {self.gap:.3g} nats below the best"
        return f"BestDraw(log joint {self.log_joint:.6g}, {told})"

    @property
    def improved_gap(self) -> float | None:
        """Like ``gap``, of the assignment at which local search from the draw ends; never larger."""
        if self.upper_bound is None or self.improved_log_joint is None:
            return None
        return max(self.upper_bound - self.improved_log_joint, 0.0)


def best_draw(posterior: Posterior, *, bound_steps: int = BOUND_STEPS) -> BestDraw:
    """The best draw of all, and how far its log joint lies below a bound on that of every assignment.

    The bound is that of ``optima.map_partition``: on log p(θ, O) of the exchangeable model with a fixed likelihood and
    a fixed concentration, with or without background and weights of observations. No bound is known for models in
    which subgoals follow each other or groups differ, nor where concentration or noise were learned, since the log
    joint then is a density of these numbers as well, nor without the likelihood; ``gap`` then is None and
    ``why_no_gap`` says which.

    A gap says how good the best draw is as an optimum. It says nothing of how well the draws cover the posterior:
    a draw is not meant to be an optimum, and with many observations that could serve either of two subgoals all draws
    lie far below it.

    Parameters
    ----------
    bound_steps:
        Steps of the Lagrangian bound at most, as in ``map_partition``; more may narrow the gap.
    """
    steps, log_joint = whole("bound_steps", bound_steps), float(posterior.log_joint.max())
    why = _why_none(posterior)
    likelihood = posterior.likelihood
    if why or likelihood is None:
        return BestDraw(posterior.best_assignment, log_joint, why_no_gap=why)
    places = posterior.candidates.n_candidates
    start = np.where(posterior.best_assignment < 0, places, posterior.best_assignment)
    found: MapPartition = map_partition(
        likelihood, posterior.concentration, start=start, restarts=0, bound_steps=steps
    )  # fmt: skip
    return BestDraw(
        assignment=posterior.best_assignment,
        log_joint=log_joint,
        gap=max(found.upper_bound - log_joint, 0.0),
        upper_bound=found.upper_bound,
        improved=np.where(found.assignment >= places, -1, found.assignment).astype(np.int32),
        improved_log_joint=found.log_joint,
    )


def _why_none(posterior: Posterior) -> str:
    """Why no bound is known; empty where one is."""
    if posterior.likelihood is None:
        return "the likelihood is not at hand"
    if posterior.settings.model != EXCHANGEABLE:
        return f"no bound is known for {posterior.settings.model}"
    if posterior.parameters:
        return f"the log joint is a density of what was learned too: {', '.join(posterior.parameters)}"
    return ""
