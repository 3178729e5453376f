"""One number for the data behind a run, so that another run's checkpoint or world is told apart."""

from __future__ import annotations

from subgoal.likelihood.table import FixedTable, LogLikelihood
from subgoal.storage.archive import digest_arrays


def checksum_of(likelihood: LogLikelihood) -> str:
    """One checksum of what the table is made from: given numbers in full, a computed table by its marginals."""
    demos, candidates, source = likelihood.demonstrations, likelihood.candidates, likelihood.source
    marginal = likelihood.log_marginal
    probe = source.values if isinstance(source, FixedTable) else marginal
    return digest_arrays(
        demos.states, demos.actions, demos.offset, candidates.points, candidates.log_prior, candidates.radius,
        candidates.metric.weights, candidates.metric.period, probe,
    )  # fmt: skip
