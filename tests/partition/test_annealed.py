"""Chains that begin apart and are exact once the concentration has fallen."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.checks import check_sampler
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.annealed import Annealed, apart
from subgoal.partition.protocol import Chain
from subgoal.runtime.errors import InputError
from subgoal.samplers import annealed, collapsed_blocks

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")


def table(n=60, g=8):
    """Observations that speak for three candidates with one nat and a half each."""
    values = np.zeros((n, g))
    values[np.arange(n), np.arange(n) * 3 // n] = 1.5
    return LogLikelihood.from_table(values)


def chain(seed=0, concentration=0.001):
    return Chain(table(), concentration, np.random.default_rng(seed))


def sweeps(count, kept=0):
    return np.arange(count) >= count - kept


def test_observations_begin_apart():
    theta = apart(chain())
    assert np.unique(theta).size == 8
    many = np.array([apart(chain(seed)) for seed in range(2000)])
    share = np.exp(1.5) / (np.exp(1.5) + 7)
    assert (many[:, 0] == 0).mean() == pytest.approx(share, abs=5 * np.sqrt(share * (1 - share) / 2000))


def test_what_is_all_but_impossible_does_not_begin():
    values = np.zeros((4, 3))
    values[:, 1] = -np.inf
    hard = Chain(LogLikelihood.from_table(values), 1.0, np.random.default_rng(0))
    assert not (np.array([apart(hard) for _ in range(200)]) == 1).any()


def test_the_concentration_falls_from_a_quarter_of_the_candidates_to_its_value():
    seen = []

    def spy(chain, keep):
        seen.extend([chain.concentration] * keep.size)
        return collapsed_blocks(chain, keep)

    Annealed(4, spy)(chain(), sweeps(6, 2))
    np.testing.assert_allclose(seen, [2.0 * (0.001 / 2.0) ** (k / 4) for k in range(4)] + [0.001] * 2)


def test_a_pause_in_the_fall_changes_nothing():
    sampler = Annealed(10)
    whole = sampler(chain(), sweeps(16, 4))
    held = chain()
    first = sampler(held, sweeps(7))
    second = sampler(Chain(held.table, held.concentration, held.generator, first.state), sweeps(9, 4))
    np.testing.assert_array_equal(second.assignments, whole.assignments)
    np.testing.assert_array_equal(np.concatenate([first.log_joint, second.log_joint]), whole.log_joint)


def test_draws_of_the_fall_may_not_be_kept():
    with pytest.raises(InputError, match="at least 10 sweeps"):
        Annealed(10)(chain(), sweeps(12, 3))
    with pytest.raises(InputError, match="75 sweeps"):
        subgoal.sample(table(), sampler=annealed, chains=1, warmup=10, draws=5)


def test_afterwards_it_is_the_sampler_it_is_made_of():
    """Once fallen, the same state and the same stream give the same draws."""
    fallen = {"theta": np.zeros(60, np.int32), "fallen": np.array([75])}
    one = annealed(Chain(table(), 1.0, np.random.default_rng(4), fallen), sweeps(5, 5))
    two = collapsed_blocks(Chain(table(), 1.0, np.random.default_rng(4), {"theta": fallen["theta"]}), sweeps(5, 5))
    np.testing.assert_array_equal(one.assignments, two.assignments)


def test_it_leaves_one_cluster_where_others_stay():
    """Three groups of a hundred, a nat and a half each, and a concentration that makes a new cluster dear."""
    large = table(300)
    settings = {"concentration": 1e-6, "chains": 2, "warmup": 80, "draws": 10, "thin": 1, "seed": 0}
    stuck = subgoal.sample(large, sampler=collapsed_blocks, **settings).best_assignment
    free = subgoal.sample(large, sampler=annealed, **settings).best_assignment
    assert np.unique(free).size == 3
    assert np.unique(stuck).size < 3


@pytest.mark.t2
def test_it_passes_the_public_checks_once_fallen():
    def begun(theta, _):
        return {"theta": theta.astype(np.int32), "fallen": np.array([75])}

    def fallen(chain, keep):
        state = chain.state or begun(np.zeros(chain.table.n_observations), None)
        return annealed(Chain(chain.table, chain.concentration, chain.generator, state), keep)

    report = check_sampler(fallen, begin=begun)
    assert not [check for check in report.checks if check.passed is False], report


def test_settings_out_of_range_are_refused():
    with pytest.raises(InputError, match="sweeps"):
        Annealed(0)


def test_candidates_have_their_prior():
    weighted = LogLikelihood.from_table(
        np.zeros((1, 2)), candidates=Candidates(points=[[0.0], [1.0]], log_prior=np.log([0.9, 0.1]))
    )
    first = [apart(Chain(weighted, 1.0, np.random.default_rng(k)))[0] for k in range(2000)]
    assert np.mean(first) == pytest.approx(0.1, abs=0.035)
