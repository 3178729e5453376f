"""What each chain over shards has given so far: traces, and the counts of its kept draws."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.blocked import draw_weights
from subgoal.posterior.chains import sparse_rows
from subgoal.runtime.checks import Floats, Ints

TRACES = ("n_active", "log_likelihood", "log_joint")


class ShardedChain:
    """One chain: its counts (G,), its generator, its traces and draws; ``arrays`` and ``restore`` for checkpoints.

    It begins with no observation assigned, so that its first weights are drawn from the prior.
    """

    def __init__(self, n_candidates: int, generator: np.random.Generator) -> None:
        self.generator = generator
        self.counts = np.zeros(n_candidates, np.int64)
        self._traces: dict[str, list[float]] = {name: [] for name in TRACES}
        self._rows: list[tuple[Ints, Ints, Ints]] = []

    @property
    def sweeps(self) -> int:
        """Sweeps done."""
        return len(self._traces["n_active"])

    def weights(self, prior: Floats, concentration: float) -> tuple[Floats, np.random.Generator]:
        """(G,) log weights drawn given the counts, the largest 0, and the generator after that; nothing is changed."""
        generator, drawn = copy.deepcopy(self.generator), np.empty(prior.size)
        draw_weights(self.counts, prior, concentration, drawn, generator)
        return drawn, generator

    def add(
        self, counts: Ints, log_likelihood: float, log_joint: float, generator: np.random.Generator, kept: bool
    ) -> None:
        """Take in a sweep."""
        self.counts, self.generator = counts, generator
        for name, value in zip(TRACES, (float((counts > 0).sum()), log_likelihood, log_joint), strict=True):
            self._traces[name].append(value)
        if kept:
            self._rows.append(sparse_rows(counts[None]))

    def trace(self, name: str) -> Floats:
        """(sweeps,) "n_active", "log_likelihood" or "log_joint"."""
        return np.array(self._traces[name])

    @property
    def count_rows(self) -> tuple[Ints, Ints, Ints]:
        """Sizes per draw, candidates and counts, as in ``CountDraws``."""
        parts = zip(*self._rows, strict=True) if self._rows else ((), (), ())
        sizes, candidates, counts = (np.concatenate([np.empty(0, np.int64), *part]) for part in parts)
        return sizes, candidates, counts

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Everything but the generator, as named arrays."""
        sizes, candidates, counts = self.count_rows
        held = {f"trace_{name}": self.trace(name) for name in TRACES}
        return held | {"now": self.counts, "sizes": sizes, "candidates": candidates, "counts": counts}

    def restore(self, held: Mapping[str, NDArray[Any]]) -> None:
        """Take the place of the chain whose ``arrays`` these are."""
        self.counts = held["now"]
        self._traces = {name: held[f"trace_{name}"].tolist() for name in TRACES}
        self._rows = [(held["sizes"], held["candidates"], held["counts"])]
