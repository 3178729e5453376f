"""Subgoals that persist: the sweeps that never leave the compiled loop are those in Python, draw for draw."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal import Demonstrations, LogLikelihood
from subgoal.partition.persistence import Persistent, _Steps
from subgoal.partition.priors import Beta
from subgoal.partition.protocol import Chain

OFFSET = np.array([0, 25, 60])


class Placed(LogLikelihood):
    """A table that knows which observation is at which candidate."""

    @property
    def arrived(self):
        from scipy import sparse

        there = np.zeros((60, 7), bool)
        there[np.arange(0, 60, 4), np.arange(0, 60, 4) % 7] = True
        return sparse.csr_array(there)


def table() -> LogLikelihood:
    values = 2 * np.random.default_rng(0).normal(size=(60, 7))
    demos = Demonstrations.from_arrays(np.arange(60.0), np.zeros(60), OFFSET)
    return Placed.from_table(values, demonstrations=demos)


def run(model: Persistent, sweeps: int = 200, state=None):
    chain = Chain(table(), 0.3, np.random.default_rng(1), state)
    return model(chain, np.arange(sweeps) % 3 == 0)


@pytest.mark.parametrize("keeps", [(0.8, None), (0.0, None), (0.7, 0.3), (0.9, 0.0)])
def test_the_compiled_loop_makes_the_draws_of_the_sweeps_in_python(keeps, monkeypatch) -> None:
    model = Persistent(*keeps)
    fast = run(model)
    again = run(model, 50, fast.state)
    monkeypatch.setattr(_Steps, "in_one_loop", property(lambda _: False))
    slow = run(model)
    for name in ("assignments", "n_active", "redraws"):
        np.testing.assert_array_equal(getattr(fast, name), getattr(slow, name))
    for name in ("log_likelihood", "log_joint"):
        np.testing.assert_allclose(getattr(fast, name), getattr(slow, name), atol=1e-10)
    for name, column in slow.parameters.items():
        np.testing.assert_array_equal(fast.parameters[name], column)
    for name, array in slow.state.items():
        np.testing.assert_array_equal(fast.state[name], array)
    np.testing.assert_array_equal(again.assignments, run(model, 50, slow.state).assignments)
    assert len(np.unique(slow.n_active)) > 1


def test_what_is_learned_or_in_several_blocks_is_swept_in_python() -> None:
    def in_one_loop(model: Persistent, likelihood: LogLikelihood) -> bool:
        return _Steps(Chain(likelihood, 0.3, np.random.default_rng(1)), model).in_one_loop

    assert in_one_loop(Persistent(0.8), table())
    assert not in_one_loop(Persistent(), table())
    assert not in_one_loop(Persistent(0.8, Beta()), table())
    long = LogLikelihood.from_table(np.zeros((30_000, 7)))
    assert long.edges.size > 2 and not in_one_loop(Persistent(0.8), long)
