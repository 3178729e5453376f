"""How a deterministic search ended."""

from __future__ import annotations

import enum


class Outcome(enum.Enum):
    """How far the answer of a deterministic search may be trusted; the value says it in words."""

    CONVERGED = "converged: the wanted gap or tolerance is reached"
    OUT_OF_ITERATIONS = "NOT CONVERGED: the iterations ran out; raise most_iterations"
    STALLED = "NOT CONVERGED: no step improves any more at the rounding of these numbers; ask for a larger gap"
    INTERRUPTED = "INTERRUPTED before the wanted gap or tolerance was reached"
