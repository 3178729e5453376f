"""Sampler ``annealed``: observations begin apart, and the concentration falls to its value before anything is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.protocol import Chain, Int32s, Sampler, Stretch
from subgoal.runtime.checks import Bools, whole
from subgoal.runtime.errors import InputError

WARM_UP = 75
SHARE = 0.25
"""Of the candidates: the concentration from which it falls."""


@dataclass(frozen=True)
class Annealed:
    """A sampler whose chains do not begin in one cluster, for posteriors where one cluster is hard to leave.

    Each observation begins at a candidate drawn from its own posterior, and the concentration falls geometrically from
    a quarter of the candidates to η within the first ``sweeps``. From then on it is ``sampler``, as exact, and draws
    may be kept: the warm-up must be at least as long.

    Attributes
    ----------
    sweeps:
        Length of the fall.
    sampler:
        Of the exchangeable model, whose state has an array ``theta``.
    """

    sweeps: int = WARM_UP
    sampler: Sampler = field(default=collapsed_blocks)

    def __post_init__(self) -> None:
        object.__setattr__(self, "sweeps", whole("sweeps", self.sweeps))

    @property
    def __name__(self) -> str:
        """The word for provenance: ``annealed``, with its settings where they are not the usual ones."""
        usual = self.sweeps == WARM_UP and self.sampler is collapsed_blocks
        return "annealed" if usual else f"annealed({self.sweeps}, {self.sampler.__name__})"

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance one chain; see ``Sampler``. Raises ``InputError`` if a draw of the fall is to be kept."""
        state: dict[str, Any] = dict(chain.state or {"theta": apart(chain), "fallen": np.zeros(1, np.int64)})
        done = int(state.pop("fallen")[0])
        falling = min(self.sweeps - done, keep.size) if done < self.sweeps else 0
        if keep[:falling].any():
            raise InputError("warmup", found="draws kept while the concentration falls",
                             wanted=f"at least {self.sweeps} sweeps before the first that is kept")  # fmt: skip
        top = max(SHARE * chain.table.n_candidates, chain.concentration)
        parts = []
        for k in range(falling):
            share = (done + k) / self.sweeps
            warm = replace(chain, concentration=top * (chain.concentration / top) ** share, state=state)
            parts.append(self.sampler(warm, keep[k : k + 1]))
            state = dict(parts[-1].state)
        if falling < keep.size:
            parts.append(self.sampler(replace(chain, state=state), keep[falling:]))
            state = dict(parts[-1].state)
        return _joined(parts, {**state, "fallen": np.array([done + falling], np.int64)})


def apart(chain: Chain) -> Int32s:
    """(N,) a candidate for each observation, drawn from its posterior on its own."""
    table, theta = chain.table, np.empty(chain.table.n_observations, np.int32)
    prior = np.exp(table.log_prior)
    for start, tile in table.tiles():
        mass = np.cumsum(table.relative_tile(start, tile) * prior, axis=1)
        level = chain.generator.random(len(tile)) * mass[:, -1]
        theta[start : start + len(tile)] = np.minimum((mass <= level[:, None]).sum(axis=1), prior.size - 1)
    return theta


def _joined(parts: list[Stretch], state: Mapping[str, Any]) -> Stretch:
    arrays = ("assignments", "n_active", "log_likelihood", "log_joint")
    whole: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in arrays}
    return Stretch(state=dict(state), **whole)


annealed = Annealed()
