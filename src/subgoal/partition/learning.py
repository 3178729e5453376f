"""Sampling with nothing set by hand: the concentration and the noise of actions are drawn along with the subgoals."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from subgoal.partition.concentration import draw_concentration
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Chain, Sampler, Stretch, Table
from subgoal.runtime.checks import Bools, Floats, Ints

EVERY = 5
"""Sweeps over the assignment between two draws of the other numbers."""


class Noise(Protocol):
    """How exactly actions follow their subgoals, as numbers that are learned with a prior of their own."""

    @property
    def name(self) -> str:
        """What the numbers are, in ``Posterior.parameters``."""

    def start(self) -> Floats:
        """Where a chain begins."""

    def table(self, values: Floats) -> Table:
        """The likelihood at these numbers."""

    def draw(self, values: Floats, theta: Ints, generator: np.random.Generator) -> Floats:
        """One update given the candidate of each observation, which leaves their posterior invariant."""

    def log_density(self, values: Floats) -> float:
        """Log prior density."""

    def summary(self, values: Floats) -> Floats:
        """(...,) one number of the gate for each of ``values`` (..., M): by which convergence is judged."""


@dataclass(frozen=True, eq=False)
class Learning:
    """A sampler ``base`` for the assignment, between whose sweeps η and the noise are drawn given the assignment.

    Attributes
    ----------
    base:
        Invariant for the assignment given η and the noise.
    concentration:
        Prior of η; None leaves it as the chain has it.
    noise:
        None leaves the table as the chain has it.
    """

    base: Sampler
    concentration: Gamma | None = None
    noise: Noise | None = None

    @property
    def __name__(self) -> str:
        return self.base.__name__

    def bytes_needed(self, n: int, g_count: int) -> float:
        """Of one chain: what ``base`` holds, and a table of its own where the noise is learned."""
        own = self.base.bytes_needed(n, g_count) if hasattr(self.base, "bytes_needed") else 0.0
        return own + (16.0 * n * g_count if self.noise is not None else 0.0)

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance one chain; how the sweeps are cut into calls does not change the draws."""
        state = dict(chain.state or {})
        eta = float(state.pop("learned_concentration", [self._first_concentration(chain)])[0])
        start = self.noise.start() if self.noise else np.empty(0)
        values = np.asarray(state.pop("learned_noise", start), float)
        phase = int(state.pop("learned_phase", [0])[0])
        chain = replace(chain, state=state or None, concentration=eta, table=self._table(chain, values))
        parts: list[Stretch] = []
        done = 0
        while done < keep.size:
            block = keep[done : done + EVERY - phase]
            part = self._with_learned(self.base(chain, block), block, eta, values)
            parts.append(part)
            chain = replace(chain, state=part.state)
            done, phase = done + block.size, (phase + block.size) % EVERY
            if phase == 0:
                eta, values = self._draw(chain, values)
                table = self._table(chain, values) if self.noise else chain.table
                chain = replace(chain, concentration=eta, table=table)
        held = {"learned_concentration": np.array([eta]), "learned_noise": values, "learned_phase": np.array([phase])}
        return joined(parts, dict(chain.state or {}) | held)

    def _first_concentration(self, chain: Chain) -> float:
        return chain.concentration if self.concentration is None else self.concentration.start

    def _table(self, chain: Chain, values: Floats) -> Table:
        return chain.table if self.noise is None else self.noise.table(values)

    def _draw(self, chain: Chain, values: Floats) -> tuple[float, Floats]:
        state, eta = chain.state or {}, chain.concentration
        theta = assignment(state)
        if self.concentration is not None:
            counts = state["counts"] if "counts" in state else np.bincount(theta, minlength=chain.table.n_candidates)
            eta = draw_concentration(eta, self.concentration, counts, np.exp(chain.table.log_prior), chain.generator)
        if self.noise is not None:
            values = self.noise.draw(values, theta, chain.generator)
        return eta, values

    def _with_learned(self, part: Stretch, keep: Bools, eta: float, values: Floats) -> Stretch:
        extra, found = 0.0, dict(part.parameters)
        count = int(keep.sum())
        if self.concentration is not None:
            extra += self.concentration.log_density(eta)
            found["concentration"] = np.full(count, eta)
        if self.noise is not None:
            extra += self.noise.log_density(values)
            found[self.noise.name] = np.tile(values, (count, 1)) if values.size > 1 else np.full(count, values[0])
        return replace(part, log_joint=part.log_joint + extra, parameters=found)


def assignment(state: object) -> Ints:
    """(N,) θ of a sampler's state, kept as such or as tables with their candidates."""
    arrays: dict[str, Ints] = dict(state)  # type: ignore[call-overload]
    return arrays["theta"] if "theta" in arrays else arrays["dish"][arrays["label"]]


def joined(parts: list[Stretch], state: dict[str, Floats]) -> Stretch:
    """Consecutive stretches as one, ending in ``state``."""
    redraws = [part.redraws for part in parts if part.redraws is not None]
    return Stretch(
        state,
        np.concatenate([part.assignments for part in parts]),
        np.concatenate([part.n_active for part in parts]),
        np.concatenate([part.log_likelihood for part in parts]),
        np.concatenate([part.log_joint for part in parts]),
        {name: np.concatenate([part.parameters[name] for part in parts]) for name in parts[0].parameters},
        np.concatenate(redraws) if redraws else None,
    )
