"""Memory that a run will need, predicted before anything is allocated."""

from __future__ import annotations

import numpy as np

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.crp import expected_clusters
from subgoal.partition.protocol import Int32s, Sampler
from subgoal.posterior.posterior import Settings
from subgoal.runtime.checks import positive
from subgoal.runtime.errors import BudgetError

HELD_SHARE = 0.25
"""Assignments are held whole while they fit in this share of the budget."""
SPREAD = 64
"""Candidates in which one observation's draws are expected to lie, at most."""
LEARNED_GUESS = 5.0
SUMS = 6
"""Numbers for each cluster and candidate, at most."""
HINT = "fewer candidates, a smaller dense_entries, or a larger memory_budget"


def holds_assignments(n_observations: int, settings: Settings, budget: float) -> bool:
    """Whether (chains, draws, N) assignments are held whole."""
    return 4.0 * settings.chains * settings.draws * n_observations <= HELD_SHARE * budget


def allocate(shape: tuple[int, int, int]) -> Int32s:
    """Room for (chains, draws, N) assignments; ``BudgetError`` where the machine has less than the budget says."""
    try:
        return np.empty(shape, np.int32)
    except MemoryError:
        needed = 4.0 * float(np.prod(shape, dtype=float))
        raise BudgetError(
            "assignments", needed=needed, budget=0.0, hint="a smaller memory_budget or fewer draws"
        ) from None


def refuse_above_budget(likelihood: LogLikelihood, settings: Settings, sampler: Sampler, budget: float) -> None:
    """Raise ``BudgetError`` when the tables, sums, draws and tallies of a run are predicted to exceed the budget.

    What a chain of ``sampler`` holds beside them is told by its ``bytes_needed(n, g_count)``, if it has that.
    """
    n, g_count = likelihood.n_observations, likelihood.n_candidates
    budget = positive("memory_budget", budget)
    table = 16.0 * n * g_count if likelihood.is_dense else 0.0
    sums = 8.0 * g_count * (64 + SUMS * expected_clusters(n, _concentration(settings)))
    tallies = 24.0 * n * min(g_count, SPREAD)
    chain = sums + tallies + 100.0 * n + 24.0 * settings.sweeps
    if hasattr(sampler, "bytes_needed"):
        chain += sampler.bytes_needed(n, g_count)
    draws = 4.0 * settings.chains * settings.draws * n if holds_assignments(n, settings, budget) else 0.0
    needed = table + settings.chains * chain + draws
    if needed > budget:
        raise BudgetError("sample", needed=needed, budget=budget, hint=HINT)


def refuse_growth(active: int, n_candidates: int, chains: int, budget: float) -> None:
    """Raise ``BudgetError`` when the sums of ``active`` clusters would exceed the budget in the next round."""
    needed = 16.0 * active * n_candidates * chains
    if needed > budget:
        raise BudgetError(f"sums of {active} clusters", needed=needed, budget=budget, hint=HINT)


def _concentration(settings: Settings) -> float:
    """η, or a guess where it is learned."""
    return settings.concentration if isinstance(settings.concentration, float) else LEARNED_GUESS
