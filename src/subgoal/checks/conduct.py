"""How a sampler must behave apart from its law: traces, seeds, states, inputs, tiles."""

from __future__ import annotations

import pickle
import random
from typing import Any

import numpy as np

from subgoal.checks.enumeration import likelihood_of, log_urn
from subgoal.checks.report import Found
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Arrays, Chain, Sampler, Stretch
from subgoal.runtime.errors import InputError

ROUNDING = 1e-9
CONCENTRATION = 2.0
TRACES = ("assignments", "n_active", "log_likelihood", "log_joint")


def chain_of(likelihood: LogLikelihood, seed: int, state: Arrays | None = None) -> Chain:
    """A chain with a stream of its own."""
    return Chain(likelihood, CONCENTRATION, np.random.default_rng(seed), state)


def middling(n: int = 60, g_count: int = 17) -> LogLikelihood:
    """(N, G) with about a fifth of the entries impossible, no row entirely, and an uneven prior."""
    generator = np.random.default_rng(6)
    table = generator.normal(scale=2.0, size=(n, g_count))
    barred = generator.random(table.shape) < 0.2
    barred[np.arange(n), generator.integers(0, g_count, n)] = False
    prior = np.arange(1.0, g_count + 1)
    return likelihood_of(np.where(barred, -np.inf, table), prior / prior.sum())


def traces(sampler: Sampler, seed: int) -> Found:
    """Shapes, which sweeps are kept, K, log likelihood and log joint, recomputed from the assignments."""
    likelihood, keep = middling(), np.arange(20) % 3 == 1
    every = sampler(chain_of(likelihood, seed), np.ones(20, bool))
    some = sampler(chain_of(likelihood, seed), keep)
    n = likelihood.n_observations
    if every.assignments.shape != (20, n) or any(getattr(every, name).shape != (20,) for name in TRACES[1:]):
        return False, f"shapes {[getattr(every, name).shape for name in TRACES]}"
    if not np.array_equal(some.assignments, every.assignments[keep]):
        return False, "keep does not mark the sweeps that are kept"
    if not np.array_equal(every.n_active, [np.unique(theta).size for theta in every.assignments]):
        return False, "n_active is not the number of candidates in use"
    fit = np.asarray(likelihood.dense)[np.arange(n), every.assignments].sum(axis=1)
    if not np.isfinite(fit).all():
        return False, "an impossible assignment was drawn"
    prior = np.exp(likelihood.log_prior)
    joint = fit + np.array([log_urn(theta, CONCENTRATION, prior) for theta in every.assignments.astype(np.int64)])
    worst = float(max(np.abs(every.log_likelihood - fit).max(), np.abs(every.log_joint - joint).max()))
    return worst <= ROUNDING, f"largest gap {worst:.1e}"


def difference(one: Stretch, other: Stretch) -> Found:
    """Whether two stretches are the same bit for bit."""
    if set(one.state) != set(other.state):
        return False, "the states have different names"
    different = [name for name in TRACES if not np.array_equal(getattr(one, name), getattr(other, name))]
    different += [f"state {name}" for name in one.state if not np.array_equal(one.state[name], other.state[name])]
    return not different, f"different: {', '.join(different)}" if different else "identical"


def repeats(sampler: Sampler, seed: int) -> Found:
    """Twice from the same stream."""
    likelihood, keep = middling(), np.ones(12, bool)
    return difference(sampler(chain_of(likelihood, seed), keep), sampler(chain_of(likelihood, seed), keep))


def resumes(sampler: Sampler, seed: int) -> Found:
    """1, 4 and 7 sweeps, with states that were written down and read again, against 12 at once."""
    likelihood, keep, generator = middling(), np.ones(12, bool), np.random.default_rng(seed)
    state: Arrays = {}
    parts = []
    for some in (keep[:1], keep[1:5], keep[5:]):
        parts.append(sampler(Chain(likelihood, CONCENTRATION, generator, state or None), some))
        state = pickle.loads(pickle.dumps({name: np.asarray(value) for name, value in parts[-1].state.items()}))
    joined: Any = {name: np.concatenate([getattr(part, name) for part in parts]) for name in TRACES}
    return difference(Stretch(state, **joined), sampler(chain_of(likelihood, seed), keep))


def global_state(sampler: Sampler, seed: int) -> Found:
    """Python's and NumPy's shared generators before and after."""

    def now() -> bytes:
        return pickle.dumps((random.getstate(), np.random.get_state()))  # noqa: NPY002

    before = now()
    sampler(chain_of(middling(), seed), np.ones(5, bool))
    untouched = now() == before
    return untouched, "untouched" if untouched else "changed"


def inputs(sampler: Sampler, seed: int) -> Found:
    """The table, the prior, the mask and the state, byte for byte."""
    likelihood, keep = middling(), np.arange(5) % 2 == 0
    first = sampler(chain_of(likelihood, seed), np.ones(3, bool))
    state = {name: np.array(value) for name, value in first.state.items()}

    def now() -> dict[str, bytes]:
        held = {"dense": likelihood.dense, "relative": likelihood.relative, "log_prior": likelihood.log_prior}
        held |= {"keep": keep} | {f"state {name}": value for name, value in state.items()}
        return {name: np.asarray(value).tobytes() for name, value in held.items()}

    before = now()
    sampler(chain_of(likelihood, seed, state), keep)
    written = [name for name, value in now().items() if value != before[name]]
    return not written, f"written: {', '.join(written)}" if written else "not written"


def tiles(sampler: Sampler, seed: int) -> Found:
    """A table that is held whole and one that is computed in two tiles."""
    whole_table, keep = middling(700, 200), np.ones(3, bool)
    tiled = likelihood_of(np.asarray(whole_table.dense), np.exp(whole_table.log_prior), dense_entries=1)
    try:
        drawn = sampler(chain_of(tiled, seed), keep)
    except InputError as told:
        return True, f"refused: {str(told)[:60]}"
    return difference(drawn, sampler(chain_of(whole_table, seed), keep))
