"""Sampler ``tempered``: parallel tempering on the likelihood, with the moves of ``collapsed_blocks`` at every level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal._kernels import tempered as loops
from subgoal._kernels.directions import log_sum_tile, relative_tile
from subgoal.partition.protocol import FIRST_TABLES, Chain, Recorder, Stretch, Table, starting_assignment
from subgoal.partition.split_merge import held
from subgoal.runtime.checks import Bools, Floats, real_array
from subgoal.runtime.errors import InputError

LADDER = (1.0, 0.6, 0.36, 0.2)
"""Powers of the likelihood at the levels, each three fifths of the one before or a little less."""


@dataclass(frozen=True)
class Tempering:
    """A sampler with its ladder: ``Tempering((1.0, 0.5))`` is passed to ``subgoal.sample`` like any other.

    Attributes
    ----------
    powers:
        β of each level, falling from 1 to above 0. Level β has the law p(θ)·p(O | θ)^β; only β = 1 is reported.

    Raises ``InputError`` for powers that do not fall from 1 to above 0.
    """

    powers: tuple[float, ...] = LADDER

    def __post_init__(self) -> None:
        powers = real_array("powers", self.powers, ndim=1)
        if not powers.size or powers[0] != 1.0 or powers[-1] <= 0.0 or (np.diff(powers) >= 0.0).any():
            raise InputError("powers", found=self.powers, wanted="numbers falling from 1 to above 0")
        object.__setattr__(self, "powers", tuple(powers.tolist()))

    @property
    def __name__(self) -> str:
        """The word for provenance: ``tempered``, with the powers where they are not the usual ones."""
        return "tempered" if self.powers == LADDER else f"tempered({', '.join(f'{beta:g}' for beta in self.powers)})"

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance all levels of one chain by ``len(keep)`` sweeps.

        In a sweep every level makes one sweep of ``collapsed_blocks`` on its table β·ℓ, and then each pair of
        neighbours, from β = 1 down, is exchanged with probability min(1, e^{(β_a − β_b)(ℓ(θ_b) − ℓ(θ_a))}) (Geyer
        1991). Holds the table twice for every level.

        Raises ``InputError`` for a table that is not held whole.
        """
        table = chain.table
        dense, relative = held(table, "tempered")
        theta = self._begun(chain)
        record = Recorder(table, keep)
        scaled, ratios = levels_of(table, dense, relative, self.powers)
        loops.sweeps_dense(
            dense, np.array(self.powers), scaled, ratios, table.edges, np.exp(table.log_prior), table.log_prior,
            chain.concentration, theta, np.empty((FIRST_TABLES, table.n_candidates)), keep, record.kept,
            record.log_likelihood, record.log_joint, record.n_active, np.zeros(len(self.powers) - 1, np.int64),
            chain.generator,
        )  # fmt: skip
        return record.stretch({"theta": theta[0], "hotter": theta[1:]})

    def bytes_needed(self, n: int, g_count: int) -> float:
        """Of one chain: both tables at every level."""
        return 16.0 * len(self.powers) * n * g_count

    def _begun(self, chain: Chain) -> np.ndarray[tuple[int, int], np.dtype[np.int32]]:
        """(levels, N) from the state, or every level from a start of its own."""
        if chain.state is None:
            return np.array([starting_assignment(chain.table, chain.generator) for _ in self.powers])
        return np.concatenate([chain.state["theta"][None], chain.state["hotter"]]).astype(np.int32)


def levels_of(table: Table, dense: Floats, relative: Floats, powers: tuple[float, ...]) -> tuple[Floats, Floats]:
    """(levels, N, G) tables β·ℓ, and L^β over its mean under the prior. Level 0 is as given."""
    scaled, ratios = np.empty((len(powers), *dense.shape)), np.empty((len(powers), *dense.shape))
    scaled[0], ratios[0] = dense, relative
    marginal = np.empty(len(dense))
    for level, beta in enumerate(powers[1:], 1):
        np.multiply(dense, beta, out=scaled[level])
        log_sum_tile(scaled[level], table.log_prior, marginal)
        relative_tile(scaled[level], marginal, ratios[level])
    return scaled, ratios


tempered = Tempering()
