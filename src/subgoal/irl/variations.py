"""The settings under which a posterior is sampled again to see what hangs on them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.as_sampled import AsSampled
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.priors import Gamma
from subgoal.runtime.checks import Ints

AGAIN = "again"
HALVED_AND_DOUBLED = ((0.5, "halved"), (2.0, "doubled"))
RATES = ((2, "every 2nd observation"), (4, "every 4th observation"))


@dataclass(frozen=True, eq=False)
class Variation:
    """One setting: in words, what kind of change it is, and the arguments of ``sample`` (of ``learn`` if reweighed)."""

    setting: str
    kind: str
    likelihood: LogLikelihood
    arguments: dict[str, Any]
    every: int = 1
    reweighed: bool = False


def variations(used: AsSampled, *, reweigh: bool) -> list[Variation]:
    """All of them, nothing changed first; other rates only where some trajectory keeps two observations."""
    plain = Variation("the same again", AGAIN, used.likelihood, used.arguments)
    return [
        plain, *_concentrations(used, plain), *_confidences(used, plain), *_weights(used, plain),
        *_rates(used, plain, reweigh),
    ]  # fmt: skip


def _concentrations(used: AsSampled, plain: Variation) -> Iterator[Variation]:
    eta = used.concentration
    for factor, how in HALVED_AND_DOUBLED:
        if isinstance(eta, Gamma):
            priors = {"shape": replace(eta, shape=factor * eta.shape), "rate": replace(eta, rate=factor * eta.rate)}
            told: dict[str, float | Gamma] = {
                f"concentration: {what} {how}, Gamma({prior.shape:g}, {prior.rate:g})": prior
                for what, prior in priors.items()
            }
        else:
            told = {f"concentration {how}, {factor * eta:g}": factor * eta}
        for setting, value in told.items():
            arguments = used.arguments | {"concentration": value}
            yield replace(plain, setting=setting, kind="concentration", arguments=arguments)


def _confidences(used: AsSampled, plain: Variation) -> Iterator[Variation]:
    law = used.likelihood.confidence
    if used.confidence is not None or not isinstance(law, float) or isinstance(used.likelihood.source, FixedTable):
        return
    for factor, how in HALVED_AND_DOUBLED:
        table = used.likelihood.at(factor * law)
        yield replace(plain, setting=f"confidence {how}, {factor * law:g}", kind="confidence", likelihood=table)


def _weights(used: AsSampled, plain: Variation) -> Iterator[Variation]:
    weight = used.likelihood.weight
    if weight is None:
        return
    for factor, how in HALVED_AND_DOUBLED:
        told = f", {factor * weight[0]:.2g}" if np.ptp(weight) == 0 else ""
        table = used.likelihood.weighted(factor * weight)
        yield replace(plain, setting=f"weight of an observation {how}{told}", kind="weight", likelihood=table)


def _rates(used: AsSampled, plain: Variation, reweigh: bool) -> Iterator[Variation]:
    table, weight = used.likelihood, used.likelihood.weight
    scored = not isinstance(table.source, FixedTable)
    anew = reweigh and scored and weight is not None and float(np.ptp(weight)) == 0
    longest = int(np.diff(table.offset).max())
    for every, setting in RATES:
        if longest <= every:
            break
        rows = every_one_of(used.likelihood.demonstrations, every)
        table = some_rows(used.likelihood, rows)
        table = table if weight is None or anew else table.weighted(weight[rows])
        yield Variation(setting, "rate", table, plain.arguments, every, anew)


def every_one_of(demonstrations: Demonstrations, every: int) -> Ints:
    """Rows of every ``every``-th observation of each trajectory, from its first."""
    lengths = np.diff(demonstrations.offset)
    within = np.arange(demonstrations.n_observations) - np.repeat(demonstrations.offset[:-1], lengths)
    return np.flatnonzero(within % every == 0)


def some_rows(likelihood: LogLikelihood, rows: Ints) -> LogLikelihood:
    """The likelihood of some observations, in order; states and actions as they were measured, no weights."""
    demos = likelihood.demonstrations
    counts = np.bincount(demos.trajectory[rows], minlength=demos.n_trajectories)
    fewer = replace(
        demos, states=demos.states[rows], actions=demos.actions[rows], offset=np.append(0, np.cumsum(counts)),
        times=None if demos.times is None else demos.times[rows],
    )  # fmt: skip
    if isinstance(likelihood.source, FixedTable):
        source = FixedTable(likelihood.source.values[rows])
        return replace(likelihood, source=source, demonstrations=fewer, weight=None)
    return same_likelihood(likelihood, fewer)
