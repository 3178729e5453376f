"""From what the chains gave to a ``Posterior``: counts, shares, diagnostics, the best draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.alg4 import PRINTED_FORMS
from subgoal.partition.learning import Noise
from subgoal.partition.protocol import Int32s
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.diagnostics import LARGEST_SHARES, gate
from subgoal.posterior.posterior import CountDraws, Posterior, Settings
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import StoppedError


def assemble(
    likelihood: LogLikelihood, noise: Noise | None, settings: Settings, records: Sequence[ChainRecord],
    room: Int32s | None, seconds: float,
) -> Posterior:  # fmt: skip
    """What the chains have given, with diagnostics; ``StoppedError`` when there is no draw yet.

    ``room`` (chains, draws, N) holds the assignments, if they are held.
    """
    traces = {name: np.stack([r.trace(name) for r in records]) for name in ("n_active", "log_joint", "log_likelihood")}
    kept = slice(settings.warmup + settings.thin - 1, None, settings.thin)
    joint, fit = traces["log_joint"][:, kept], traces.pop("log_likelihood")
    if not joint.size:
        raise StoppedError("stopped during the warm-up: there are no draws yet to give")
    counts = count_draws([record.count_rows for record in records])
    redraws = [rows for record in records if (rows := record.redraw_rows) is not None]
    n, places = likelihood.n_observations, likelihood.candidates.n_candidates
    parameters = _parameters(records)
    mean = np.empty(0) if noise is None else np.atleast_1d(parameters[noise.name].mean(axis=(0, 1)))
    at_mean: Any = likelihood if noise is None else noise.table(mean)
    summaries = label_free(counts, joint, traces["n_active"][:, kept], n)
    if likelihood.background:
        background = counts.by_group(np.arange(likelihood.n_candidates) - places, 1)
        summaries["background"] = background.reshape(joint.shape) / n
    summaries |= {name: values for name, values in parameters.items() if values.ndim == 2}
    if noise is not None and noise.name not in summaries:
        summaries[f"mean log {noise.name}"] = noise.summary(parameters[noise.name])
    diagnostics, status = gate(
        summaries, interrupted=traces["n_active"].shape[1] < settings.sweeps, biased=settings.sampler in PRINTED_FORMS
    )
    tally: Any = sum((record.tally for record in records[1:]), records[0].tally)
    best = max(records, key=lambda record: record.best[0]).best[1]
    held = room[:, : joint.shape[1]] if room is not None and records[0].room is not None else None
    return Posterior(
        demonstrations=likelihood.demonstrations,
        candidates=likelihood.candidates,
        settings=settings,
        assignments=None if held is None else _without_background(held, places),
        counts=counts.of_places(places),
        shares=sparse.csr_array(tally / joint.size)[:, :places],
        best_assignment=_without_background(best, places),
        log_joint=joint,
        log_likelihood=fit[:, kept],
        traces={**traces, "loss": -fit / n},
        diagnostics=diagnostics,
        status=status,
        uninformative=np.asarray(likelihood.source.uninformative),
        seconds=seconds,
        parameters=parameters,
        redraws=count_draws(redraws) if redraws else None,
        likelihood=at_mean,
    )


def _without_background(theta: Int32s, places: int) -> Int32s:
    """The same array with −1 where no subgoal is served."""
    theta[theta >= places] = -1
    return theta


def _parameters(records: Sequence[ChainRecord]) -> dict[str, NDArray[Any]]:
    each = [record.parameters for record in records]
    return {name: np.stack([one[name] for one in each]) for name in each[0]}


def count_draws(parts: Sequence[tuple[Ints, Ints, Ints]]) -> CountDraws:
    """The draws of all chains, one after the other, from the sizes, candidates and counts of each."""
    sizes, candidates, counts = (np.concatenate(part) for part in zip(*parts, strict=True))
    return CountDraws(np.concatenate([[0], np.cumsum(sizes)]), candidates, counts)


def label_free(counts: CountDraws, joint: Floats, n_active: Floats, n: int) -> dict[str, Floats]:
    """Label-invariant summaries (chain, draw): log joint, K, and the largest shares in falling order."""
    largest = counts.largest(LARGEST_SHARES) / n
    shares = {f"share {rank + 1}": largest[:, rank].reshape(joint.shape) for rank in range(LARGEST_SHARES)}
    return {"log joint": joint, "K": n_active, **shares}
