"""Random streams that hang on identity (chain k), never on how many workers there are."""

from __future__ import annotations

import numpy as np

from subgoal.runtime.checks import whole


def stream(seed: int, *identity: int) -> np.random.Generator:
    """The generator of one named stream, e.g. ``stream(seed, chain)``: independent of every other stream."""
    sequence = np.random.SeedSequence(whole("seed", seed, least=0), spawn_key=identity)
    return np.random.Generator(np.random.PCG64(sequence))
