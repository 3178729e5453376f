"""``ShardedPosterior``: draws of how many observations each candidate has, with diagnostics and provenance."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.likelihood.shards import candidates_from, candidates_head
from subgoal.posterior.diagnostics import Diagnostic, Status
from subgoal.posterior.posterior import CountDraws, Settings
from subgoal.runtime.checks import Floats, whole
from subgoal.runtime.errors import StorageError
from subgoal.storage.archive import read_archive, write_archive

KIND = "sharded posterior"


@dataclass(frozen=True)
class CandidatePlace:
    """One candidate: where it is, P(it has observations | O), and how many it is expected to have."""

    candidate: int
    name: str
    position: tuple[float, ...]
    inclusion: float
    expected_size: float


@dataclass(frozen=True, eq=False, repr=False)
class ShardedPosterior:
    """Draws from p(n | O), the counts of each candidate; which observation is whose is not kept.

    Attributes
    ----------
    counts:
        Observations per candidate in each draw, row chain × draws + draw; those of the background are left out.
    log_joint, log_likelihood:
        (chain, draw) log p(θ, O) at dish level, and Σ ℓ[i, θ_i], both complete.
    traces:
        "n_active", "log_joint" and "loss" (mean −ℓ[i, θ_i], nats per observation), each (chain, sweep).
    diagnostics, status:
        The gate, as ``Posterior`` has it.
    """

    candidates: Candidates
    n_observations: int
    settings: Settings
    counts: CountDraws
    log_joint: Floats
    log_likelihood: Floats
    traces: dict[str, Floats]
    diagnostics: dict[str, Diagnostic]
    status: Status
    seconds: float

    def __repr__(self) -> str:
        made = f"{self.n_chains} chains × {self.n_draws} draws of {self.settings.sampler}"
        return f"ShardedPosterior({made}, {self.n_observations:,} observations, {self.status.name})"

    @property
    def n_chains(self) -> int:
        """Chains."""
        return int(self.log_joint.shape[0])

    @property
    def n_draws(self) -> int:
        """Kept draws per chain."""
        return int(self.log_joint.shape[1])

    @property
    def n_active(self) -> Floats:
        """(chain, draw) distinct candidates in use, the background counted as one."""
        kept = slice(self.settings.warmup + self.settings.thin - 1, None, self.settings.thin)
        return self.traces["n_active"][:, kept]

    def inclusion(self, least: int = 1) -> Floats:
        """(G,) P(n_g ≥ least | O) for each candidate."""
        enough = self.counts.count >= whole("least", least)
        found = np.bincount(self.counts.candidate[enough], minlength=self.candidates.n_candidates)
        return np.asarray(found / self.log_joint.size)

    @property
    def expected_size(self) -> Floats:
        """(G,) E[n_g | O]."""
        summed = np.bincount(self.counts.candidate, self.counts.count, minlength=self.candidates.n_candidates)
        return np.asarray(summed / self.log_joint.size)

    def places(self, inclusion: float = 0.5) -> list[CandidatePlace]:
        """Candidates that have observations with at least this probability, the largest expected size first."""
        chance, size = self.inclusion(), self.expected_size
        order = np.argsort(-size, kind="stable")
        return [
            CandidatePlace(g, self.candidates.name(g), tuple(self.candidates.points[g].tolist()), float(chance[g]),
                           float(size[g]))
            for g in order.tolist() if chance[g] >= inclusion
        ]  # fmt: skip


def save(posterior: ShardedPosterior, path: str | Path) -> Path:
    """Write it as one npz without pickle."""
    counts = posterior.counts
    arrays = {
        "count_offset": counts.offset, "count_candidate": counts.candidate, "count": counts.count,
        "log_joint": posterior.log_joint, "log_likelihood": posterior.log_likelihood,
    }  # fmt: skip
    arrays |= {f"trace_{name}": trace for name, trace in posterior.traces.items()}
    header = {
        "settings": asdict(posterior.settings), "status": posterior.status.name, "seconds": posterior.seconds,
        "diagnostics": {name: asdict(each) for name, each in posterior.diagnostics.items()},
        "n_observations": posterior.n_observations, "candidates": candidates_head(posterior.candidates),
    }  # fmt: skip
    write_archive(Path(path), KIND, header, arrays, keep_previous=False)
    return Path(path)


def load(path: str | Path) -> ShardedPosterior:
    """Read what ``save`` wrote. Raises ``StorageError`` for a torn, foreign or newer file."""
    header, arrays = read_archive(Path(path), KIND)
    try:
        return _posterior(header, arrays)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as problem:
        raise StorageError("sharded posterior file", where=str(path), found=f"a missing or wrong field ({problem})",
                           wanted="all fields of a sharded posterior") from None  # fmt: skip


def _posterior(header: dict[str, Any], arrays: dict[str, Any]) -> ShardedPosterior:
    mark = "trace_"
    return ShardedPosterior(
        candidates=candidates_from(header["candidates"]), n_observations=header["n_observations"],
        settings=Settings(**header["settings"]),
        counts=CountDraws(arrays["count_offset"], arrays["count_candidate"], arrays["count"]),
        log_joint=arrays["log_joint"], log_likelihood=arrays["log_likelihood"],
        traces={name.removeprefix(mark): trace for name, trace in arrays.items() if name.startswith(mark)},
        diagnostics={name: Diagnostic(**each) for name, each in header["diagnostics"].items()},
        status=Status[header["status"]], seconds=header["seconds"],
    )  # fmt: skip
