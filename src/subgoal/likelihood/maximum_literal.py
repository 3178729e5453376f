"""The likelihood of thesis (6.2) as printed, under a name that says so: to be looked at, not to be used.

(6.2) divides exp(αQ(s, a)) by its largest value over actions in place of its sum, or integral. What results is no
density: a candidate for which every action is as good as any other, one that cannot be reached say, has the value 1 for
whatever was done, which no candidate that asks for something can have on average. One such candidate explains all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from subgoal.likelihood.assigned import ActionValues, Chords, Shortfalls
from subgoal.likelihood.gp_values import TestedValues
from subgoal.likelihood.source import Assigned, Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError


def literal_maximum(likelihood: LogLikelihood) -> LogLikelihood:
    """The same table in the printed form of (6.2): log exp(αQ(s_i, a_i)) − log max_a exp(αQ(s_i, a)). Wrong.

    Zero for the best action of a candidate, and for every action where the candidate asks for none (flat Q); below zero
    elsewhere. The right form, ``planned_actions`` or ``action_comparison``, has the sum over actions, or the integral.

    Parameters
    ----------
    likelihood:
        Of planned actions, or of action comparison (there −α‖a − a_CL‖ stands for αQ), at one α or one for each
        candidate.

    Returns
    -------
    A table of given numbers, N × G, with the candidates, demonstrations and weights of ``likelihood``.

    Raises
    ------
    InputError
        A table of given numbers, whose actions are not known; a law of confidences; a background.
    """
    if likelihood.background:
        raise InputError("background", found=likelihood.background, wanted="0, as the printed form has none",
                         hint="a column of zeros is what it would give one")  # fmt: skip
    if isinstance(likelihood.confidence, Levels):
        raise InputError("confidence", found="a law of confidences", wanted="a number", hint="likelihood.at(3.0)")
    n, g_count = likelihood.n_observations, likelihood.n_candidates
    each = np.full(g_count, likelihood.confidence, float)
    values = np.empty((n, g_count))
    for g in range(g_count):
        taken = likelihood.source.assigned(np.full(n, g))
        alpha = np.full(n, each[g])
        values[:, g] = taken.log_density(alpha) - _best(taken).log_density(alpha)
    return LogLikelihood.from_table(
        values, candidates=likelihood.candidates, demonstrations=likelihood.demonstrations, weight=likelihood.weight
    )


def _best(taken: Assigned) -> Assigned:
    """The same observations, had each been the action that its candidate asks for."""
    if isinstance(taken, Chords):
        return replace(taken, taken=taken.asked)
    if isinstance(taken, Shortfalls):
        return replace(taken, gap=np.zeros_like(taken.gap))
    if isinstance(taken, ActionValues):
        return replace(taken, actions=taken.values.argmax(axis=1))
    if isinstance(taken, TestedValues):
        best = np.maximum(taken.taken, taken.tested.max(axis=1))
        return replace(taken, taken=best)
    raise InputError(
        "likelihood", found=type(taken).__name__, wanted="planned actions, of any kind, or action comparison"
    )
