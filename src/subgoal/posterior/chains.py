"""What each chain has given so far, round after round: the part of a run that a checkpoint holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal.partition.protocol import Arrays, Int32s, Stretch
from subgoal.runtime.checks import Floats, Ints

REDRAWS = ("redraw_sizes", "redraw_candidates", "redraw_counts")


class ChainRecord:
    """Traces, draws, counts and shares of one chain, added to in place; ``arrays`` and ``restore`` for checkpoints.

    ``room`` (draws, N) is where its assignments go, or None when they are not held.
    """

    def __init__(
        self, n_observations: int, n_candidates: int, generator: np.random.Generator, room: Int32s | None
    ) -> None:
        self.generator = generator
        self.state: Arrays | None = None
        self.shape = (n_observations, n_candidates)
        self.room = room
        self._traces: dict[str, list[NDArray[Any]]] = {"n_active": [], "log_likelihood": [], "log_joint": []}
        self._candidates: list[Ints] = []
        self._counts: list[Ints] = []
        self._sizes: list[int] = []
        self._parameters: list[Arrays] = []
        self._redraws: list[tuple[Ints, Ints, Ints]] = []
        self.tally = sparse.csr_array(self.shape, dtype=np.int64)
        self.best: tuple[float, Int32s] = (-np.inf, np.zeros(n_observations, np.int32))

    @property
    def sweeps(self) -> int:
        """Sweeps done."""
        return sum(part.size for part in self._traces["n_active"])

    def add(self, stretch: Stretch, kept_joint: Floats) -> None:
        """Take in a stretch; ``kept_joint`` is the log joint of its kept sweeps."""
        self.state = stretch.state
        for name, parts in self._traces.items():
            parts.append(getattr(stretch, name))
        draws = stretch.assignments
        if not len(draws):
            return
        if kept_joint.max() > self.best[0]:
            self.best = (float(kept_joint.max()), draws[int(np.argmax(kept_joint))].copy())
        if self.room is not None:
            self.room[len(self._sizes) : len(self._sizes) + len(draws)] = draws
        self._parameters.append(stretch.parameters)
        if stretch.redraws is not None:
            self._redraws.append(sparse_rows(stretch.redraws))
        for theta in draws:
            count = np.bincount(theta, minlength=self.shape[1])
            used = np.flatnonzero(count)
            self._candidates.append(used)
            self._counts.append(count[used])
            self._sizes.append(used.size)
        rows = np.tile(np.arange(self.shape[0]), len(draws))
        self.tally = self.tally + sparse.csr_array(
            (np.ones(rows.size, np.int64), (rows, draws.ravel())), shape=self.shape
        )

    def trace(self, name: str) -> NDArray[Any]:
        """(sweeps,) "n_active", "log_likelihood" or "log_joint"."""
        return _joined(self._traces[name], np.float64)

    @property
    def draws(self) -> Int32s:
        """(kept, N) assignments, a part of ``room``; (0, N) when they are not held."""
        return np.empty((0, self.shape[0]), np.int32) if self.room is None else self.room[: len(self._sizes)]

    @property
    def count_rows(self) -> tuple[Ints, Ints, Ints]:
        """Sizes per draw, candidates and counts, as in ``CountDraws``."""
        return np.asarray(self._sizes, np.int64), _joined(self._candidates, np.int64), _joined(self._counts, np.int64)

    @property
    def parameters(self) -> dict[str, NDArray[Any]]:
        """What else was sampled, each (kept, ...)."""
        names = self._parameters[0] if self._parameters else {}
        return {name: np.concatenate([part[name] for part in self._parameters]) for name in names}

    @property
    def redraw_rows(self) -> tuple[Ints, Ints, Ints] | None:
        """Like ``count_rows``, of the draws from the shared weights; None where that is the same."""
        if not self._redraws:
            return None
        sizes, candidates, counts = (np.concatenate(parts) for parts in zip(*self._redraws, strict=True))
        return sizes, candidates, counts

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Everything but the generator, as named arrays."""
        sizes, candidates, counts = self.count_rows
        held = {f"trace_{name}": self.trace(name) for name in self._traces}
        held |= {f"state_{name}": np.asarray(value) for name, value in (self.state or {}).items()}
        held |= {"draws": self.draws, "sizes": sizes, "candidates": candidates, "counts": counts}
        held |= {"tally_data": self.tally.data, "tally_indices": self.tally.indices, "tally_indptr": self.tally.indptr}
        held |= {f"parameter_{name}": values for name, values in self.parameters.items()}
        if self.redraw_rows is not None:
            held |= dict(zip(REDRAWS, self.redraw_rows, strict=True))
        return held | {"best": self.best[1], "best_joint": np.array([self.best[0]])}

    def restore(self, held: Mapping[str, NDArray[Any]]) -> None:
        """Take the place of the chain whose ``arrays`` these are."""
        self._traces = {name: [held[f"trace_{name}"]] for name in self._traces}
        self.state = {name[6:]: value for name, value in held.items() if name.startswith("state_")} or None
        self._sizes = held["sizes"].tolist()
        if len(held["draws"]) != len(self._sizes):
            self.room = None
        if self.room is not None:
            self.room[: len(self._sizes)] = held["draws"]
        self._candidates, self._counts = [held["candidates"]], [held["counts"]]
        mark = "parameter_"
        found = {name.removeprefix(mark): values for name, values in held.items() if name.startswith(mark)}
        self._parameters = [found] if self._sizes else []
        self._redraws = [(held[REDRAWS[0]], held[REDRAWS[1]], held[REDRAWS[2]])] if REDRAWS[0] in held else []
        self.tally = sparse.csr_array(
            (held["tally_data"], held["tally_indices"], held["tally_indptr"]), shape=self.shape
        )
        self.best = (float(held["best_joint"][0]), held["best"].astype(np.int32))


def _joined(parts: list[NDArray[Any]], dtype: Any) -> NDArray[Any]:
    return np.concatenate([np.empty(0, dtype), *parts]).astype(dtype)


def sparse_rows(table: Ints) -> tuple[Ints, Ints, Ints]:
    """Number of entries above zero in each row, their columns, and the entries."""
    rows, columns = np.nonzero(table)
    return np.bincount(rows, minlength=len(table)), columns, table[rows, columns]
