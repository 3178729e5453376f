"""BNIRL (thesis chapter 4): several subgoals out of one unsegmented demonstration in a discrete world."""

from __future__ import annotations

from typing import Any

from subgoal.candidates import Candidates, visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.pairs import checked_pairs
from subgoal.likelihood.planned_actions import DEFAULT_CONFIDENCE, planned_actions
from subgoal.likelihood.planners import Planner
from subgoal.mdp.local_world import LocalWorld
from subgoal.mdp.planners.subgoal_plan import Convention
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import sample
from subgoal.runtime.progress import Progress


def bnirl(
    demonstrations: Demonstrations,
    mdp: TabularMDP | LocalWorld,
    *,
    candidates: Candidates | None = None,
    confidence: float = DEFAULT_CONFIDENCE,
    concentration: float = 1.0,
    convention: Convention = "continuing",
    tolerance: float | None = None,
    planner: Planner | None = None,
    planning_progress: Progress | None = None,
    **sampling: Any,
) -> Posterior:
    """Bayesian nonparametric inverse reinforcement learning, thesis Algorithm 4 with its errors mended.

    Plans for every candidate subgoal (lines 2-3), tabulates the softmax likelihood (4.2), and samples which subgoal
    explains which observation (lines 6-16) from the exact posterior (4.5).

    Parameters
    ----------
    demonstrations, mdp:
        States (N,) and actions (N,), and the world they are of.
    candidates:
        Where subgoals may be; None is every visited state with a uniform prior (Proposition 1). See
        ``visited_and_successors``, ``every_state`` and ``feature_subgoals`` for others.
    confidence:
        α per unit of the goal's reward; 10 to 30 suits a demonstrator who rarely errs.
    concentration:
        η of the Chinese restaurant process (2.8).
    convention, tolerance:
        Whether a goal is rewarded at every visit or ends the episode, and the largest error of an action value; see
        ``planned_actions``.
    planner:
        As in ``planned_actions``: None is exact in small worlds and in an envelope in large ones.
    planning_progress:
        Told how many candidates have been planned for; ``progress`` among the other settings is told of the sweeps.
    sampling:
        Settings of ``sample``: sampler, chains, draws, warmup, thin, seed, workers, checkpoint and so on.

    Raises
    ------
    What ``planned_actions`` and ``sample`` raise.
    """
    checked_pairs(demonstrations, mdp)
    candidates = visited(demonstrations) if candidates is None else candidates
    likelihood = planned_actions(
        demonstrations, candidates, mdp, confidence=confidence, convention=convention,
        tolerance=tolerance, planner=planner, workers=sampling.get("workers"), progress=planning_progress,
    )  # fmt: skip
    return sample(likelihood, concentration=concentration, **sampling)
