"""One number for the data behind a run, so that another run's checkpoint or world is told apart."""

from __future__ import annotations

import numpy as np

from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.table import LogLikelihood
from subgoal.storage.archive import digest_arrays


def checksum_of(likelihood: LogLikelihood) -> str:
    """One checksum of what the table is made from: given numbers in full, a computed table by its marginals.

    The confidence has no part in it: that is a setting.
    """
    demos, candidates, source = likelihood.demonstrations, likelihood.candidates, likelihood.source
    probe = source.values if isinstance(source, FixedTable) else likelihood.at(source.unit).log_marginal
    weight = np.empty(0) if likelihood.weight is None else likelihood.weight
    return digest_arrays(
        demos.states, demos.actions, demos.offset, candidates.points, candidates.log_prior, candidates.radius,
        candidates.metric.weights, candidates.metric.period, probe, weight,
    )  # fmt: skip
