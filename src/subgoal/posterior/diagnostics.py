"""The gate: rank-normalised R-hat and effective sample sizes of label-invariant summaries (Vehtari et al. 2021)."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.runtime.checks import Floats

LARGEST_RHAT = 1.01
LEAST_ESS = 400
LEAST_CHAINS = 4
LARGEST_SHARES = 3


class Status(enum.Enum):
    """How far a posterior may be trusted; the value says it in words."""

    CONVERGED = "converged: R-hat at most 1.01 and effective sample sizes of at least 400 on every summary of the gate"
    NOT_CONVERGED = "NOT CONVERGED: more sweeps are needed; raise draws, warmup or thin"
    INTERRUPTED = "INTERRUPTED before all draws were made, and not converged by then; resume or run again"
    BIASED = "NOT THE POSTERIOR: this sampler is the thesis's printed form, which is biased; for comparison only"
    FEW_CHAINS = "NOT CONVERGED: fewer than 4 chains cannot show convergence; raise chains"


@dataclass(frozen=True)
class Diagnostic:
    """R-hat, bulk and tail effective sample size of one summary."""

    rhat: float
    ess_bulk: float
    ess_tail: float

    @property
    def passes(self) -> bool:
        """Whether this summary passes the gate; NaN does not."""
        return self.rhat <= LARGEST_RHAT and self.ess_bulk >= LEAST_ESS and self.ess_tail >= LEAST_ESS


def diagnose(values: Floats) -> Diagnostic:
    """Diagnostic of (chains, draws) values; one same value in all chains is converged, one per chain is not."""
    if not np.isfinite(values).all():
        return Diagnostic(np.inf, 1.0, 1.0)
    if np.ptp(values) == 0:
        return Diagnostic(1.0, float(values.size), float(values.size))
    if values.shape[1] < 4 or (np.ptp(values, axis=1) == 0).all():
        return Diagnostic(np.inf, 1.0, 1.0)
    from arviz_stats import base

    array_stats: Any = vars(base)["array_stats"]
    return Diagnostic(
        float(array_stats.rhat(values, method="rank")),
        float(array_stats.ess(values, method="bulk")),
        float(array_stats.ess(values, method="tail", prob=(0.05, 0.95))),
    )


def gate(summaries: Mapping[str, Floats], *, interrupted: bool, biased: bool) -> tuple[dict[str, Diagnostic], Status]:
    """Diagnostics of each (chains, draws) summary and the verdict."""
    diagnostics = {name: diagnose(np.asarray(values, float)) for name, values in summaries.items()}
    chains = next(iter(summaries.values())).shape[0]
    if biased:
        return diagnostics, Status.BIASED
    if chains >= LEAST_CHAINS and all(each.passes for each in diagnostics.values()):
        return diagnostics, Status.CONVERGED
    if interrupted:
        return diagnostics, Status.INTERRUPTED
    return diagnostics, Status.NOT_CONVERGED if chains >= LEAST_CHAINS else Status.FEW_CHAINS
