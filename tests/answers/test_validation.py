"""Scores of trajectories that were left out: folds by hand, and leaving one out against enumerated refits."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.answers import validation as module
from subgoal.answers.filtering import filtering
from subgoal.answers.validation import cross_validate, leave_one_out, some_trajectories
from subgoal.demonstrations.records import Demonstrations
from subgoal.models import Gamma, Grouped, NoiseLevels, Persistent, StickyHMM
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError
from tests.oracles import persistence as oracle
from tests.oracles.partitions import urn_probability
from tests.posterior.worlds import quiet_sample

PLACES = subgoal.Candidates(np.array([[0.0, 0.0], [10.0, 0.0], [5.0, 8.0]]), [-0.5, -1.0, -1.5], radius=1.0)
PRIOR, ETA, KEEP = np.exp(PLACES.log_prior), 1.3, 0.6
LENGTH = {"chains": 2, "draws": 30, "warmup": 20, "thin": 1}


def walks(lengths: list[int], seed: int = 0) -> Demonstrations:
    """Trajectories that head for a place, a new one now and then; blurred."""
    generator = np.random.default_rng(seed)
    states, actions = [], []
    for length in lengths:
        goal = PLACES.points[generator.integers(3)]
        for _ in range(length):
            if generator.random() < 0.3:
                goal = PLACES.points[generator.integers(3)]
            state = generator.uniform(1, 9, 2)
            way = (goal - state) / np.linalg.norm(goal - state)
            states.append(state)
            actions.append(way + generator.normal(scale=0.5, size=2))
    offset = np.concatenate([[0], np.cumsum(lengths)])
    names = tuple("abcdefghij"[: len(lengths)])
    return Demonstrations.from_arrays(np.array(states), np.array(actions), offset, trajectory_names=names)


def fit(demos: Demonstrations, model=None, **settings) -> Posterior:
    return quiet_sample(subgoal.action_comparison(demos, PLACES), model=model, **{**LENGTH, **settings})


# Cross-validation


@pytest.mark.parametrize("model", [None, Persistent(), StickyHMM()])
def test_each_fold_is_scored_by_the_posterior_of_the_others(model) -> None:
    demos = walks([4, 5, 3, 6, 4])
    seen: list[Demonstrations] = []

    def make(some: Demonstrations) -> Posterior:
        seen.append(some)
        return fit(some, model)

    found = cross_validate(make, demos, folds=2, seed=7, draws=20)
    assert sorted(np.bincount(found.fold).tolist()) == [2, 3]
    for k, training in enumerate(seen):
        inside = np.flatnonzero(found.fold != k)
        assert training.trajectory_names == tuple("abcde"[d] for d in inside)
        posterior = fit(training, model)
        for d in np.flatnonzero(found.fold == k):
            alone = filtering(posterior, some_trajectories(demos, np.array([d])), draws=20, seed=7)
            assert found.log_predictive[d] == pytest.approx(alone.log_predictive.sum(), abs=1e-10)
    assert found.decisions.tolist() == [4, 5, 3, 6, 4]
    assert found.statuses == (Status.FEW_CHAINS,) * 2
    assert found.bits_per_decision == pytest.approx(found.log_predictive.sum() / 22 / math.log(2))


def test_folds_hang_on_the_seed_alone_and_share_out_all_trajectories() -> None:
    demos = walks([1] * 7)
    one, two, other = (cross_validate(fit, demos, folds=3, seed=s, draws=2).fold for s in (1, 1, 2))
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()
    assert sorted(np.bincount(one).tolist()) == [2, 2, 3]
    assert sorted(cross_validate(fit, demos, folds=7, draws=2).fold.tolist()) == list(range(7))


@pytest.mark.t1
def test_learning_everything_is_scored_too() -> None:
    def make(some: Demonstrations) -> Posterior:
        return subgoal.learn(subgoal.action_comparison(some, PLACES), draws=20, warmup=20, chains=2, workers=1)

    with pytest.warns(UserWarning, match="chains"):
        found = cross_validate(make, walks([6, 6, 6]), folds=3)
    assert np.isfinite(found.log_predictive).all()


def test_trajectories_keep_all_that_is_theirs() -> None:
    demos = replace(
        walks([2, 3, 4]), times=np.arange(9.0), final_states=np.arange(6.0).reshape(3, 2), groups=("u", "v", "w"),
        truncated=np.array([True, False, True]),
    )  # fmt: skip
    some = some_trajectories(demos, np.array([2, 0]))
    rows = [5, 6, 7, 8, 0, 1]
    np.testing.assert_array_equal(some.states, demos.states[rows])
    np.testing.assert_array_equal(some.actions, demos.actions[rows])
    np.testing.assert_array_equal(some.times, [5, 6, 7, 8, 0, 1])
    np.testing.assert_array_equal(some.final_states, [[4, 5], [0, 1]])
    assert some.offset.tolist() == [0, 4, 6]
    assert (some.trajectory_names, some.groups, some.truncated.tolist()) == (("c", "a"), ("w", "u"), [True, True])


def test_what_cannot_be_cross_validated() -> None:
    demos = walks([2, 2, 2])
    for folds in (1, 4):
        with pytest.raises(InputError, match="folds"):
            cross_validate(fit, demos, folds=folds)
    with pytest.raises(InputError, match="make"):
        cross_validate(lambda some: 3, demos, folds=2)
    with pytest.raises(InputError, match="groups"):
        cross_validate(lambda some: fit(some, Grouped([0] * some.n_trajectories)), demos, folds=3)


# Leaving one out


def evidence(log_table: np.ndarray) -> float:
    """log p(O) of the exchangeable model: the sum over all assignments."""
    total = 0.0
    for theta in itertools.product(range(3), repeat=len(log_table)):
        total += oracle.fit(theta, log_table) * urn_probability(theta, ETA, PRIOR.tolist())
    return math.log(total)


def persistent_evidence(log_table: np.ndarray, starts: list[int]) -> float:
    """The same where subgoals are kept with probability KEEP."""
    nowhere = np.zeros(log_table.shape, bool)
    total = 0.0
    for state in oracle.paths(len(log_table), 3, starts):
        step = oracle.step_probability(state, starts, KEEP, KEEP, nowhere)
        total += oracle.fit(state[0], log_table) * step * oracle.redraw_probability(state, ETA, PRIOR.tolist())
    return math.log(total)


def assert_close(found: module.LeaveOneOut, wanted: np.ndarray) -> None:
    """Within 4.7 standard deviations (level 3e-6), which are 0.017 nats at most over twelve repetitions."""
    assert (found.pareto_k < found.most_k).all()
    np.testing.assert_allclose(found.log_predictive, wanted, rtol=0, atol=0.08)


@pytest.mark.parametrize("weight", [None, 0.5])
def test_leaving_one_out_of_the_exchangeable_model_is_the_exact_refit(weight: float | None) -> None:
    """Against p(O_d | others): sums over 3⁸ assignments with all, over 3⁶ without each pair of steps."""
    demos = walks([2, 2, 2, 2], seed=5)
    likelihood = subgoal.action_comparison(demos, PLACES, confidence=1.5)
    plain = likelihood.dense
    power = plain if weight is None else weight * plain
    if weight is not None:
        likelihood = likelihood.weighted(weight)
    posterior = quiet_sample(likelihood, concentration=ETA, chains=4, draws=2000, warmup=200, thin=2, seed=1)
    found = leave_one_out(posterior, draws=8000)
    wanted = np.empty(4)
    for d in range(4):
        own = np.arange(2 * d, 2 * d + 2)
        others = np.delete(power, own, axis=0)
        wanted[d] = evidence(np.vstack([others, plain[own]])) - evidence(others)
    assert_close(found, wanted)
    assert found.decisions.tolist() == [2, 2, 2, 2]
    assert found.effective_parameters > 0.1
    assert np.ptp(wanted) > 0.5


@pytest.mark.t1
def test_leaving_one_out_of_subgoals_that_persist_is_the_exact_refit() -> None:
    demos = walks([2, 2, 2], seed=2)
    likelihood = subgoal.action_comparison(demos, PLACES, confidence=1.5)
    posterior = quiet_sample(
        likelihood, model=Persistent(keep=KEEP), concentration=ETA, chains=4, draws=2000, warmup=200, thin=2, seed=1
    )
    found = leave_one_out(posterior, draws=8000)
    everything = persistent_evidence(likelihood.dense, [0, 2, 4])
    wanted = [
        everything - persistent_evidence(np.delete(likelihood.dense, [2 * d, 2 * d + 1], axis=0), [0, 2])
        for d in range(3)
    ]
    assert_close(found, np.array(wanted))


@pytest.mark.filterwarnings("ignore:Estimated shape parameter")
@pytest.mark.parametrize("model", [None, Persistent(), StickyHMM()])
def test_it_is_what_arviz_says_of_the_same_draws(model) -> None:
    """Up to how much the draws are taken to depend on each other, which the tail's length hangs on a little."""
    from arviz_stats import loo

    posterior = fit(walks([4, 5, 3, 6]), model, draws=100, concentration=Gamma(), confidence=NoiseLevels())
    found = leave_one_out(posterior, draws=200)
    arviz = loo(posterior.to_arviz(log_likelihood=True), pointwise=True, reff=1.0)
    np.testing.assert_allclose(found.log_predictive, arviz.elpd_i, rtol=0, atol=0.02)
    assert found.effective_parameters == pytest.approx(arviz.p, abs=0.06)


def test_a_trajectory_unlike_all_others_is_doubtful() -> None:
    """Four walks straight to one place and one to another: without it, its place is all but never served."""
    states = np.tile(np.linspace(1, 9, 12), 5)[:, None] * [[1.0, 0.0]]
    actions = np.repeat([[1.0, 0.0]], 60, axis=0)
    actions[48:] = [-1.0, 0.0]
    demos = Demonstrations.from_arrays(states, actions, [0, 12, 24, 36, 48, 60])
    likelihood = subgoal.action_comparison(demos, PLACES, confidence=8.0)
    found = leave_one_out(quiet_sample(likelihood, concentration=0.1, draws=200, warmup=100, chains=4, thin=1))
    assert found.doubtful.tolist() == [4]
    assert found.pareto_k[4] > found.most_k
    assert found.most_k == pytest.approx(min(0.7, 1 - 1 / math.log10(800)))


def test_huge_and_flat_likelihoods_are_weighed() -> None:
    flat = np.zeros((100, 2))
    flat[:, 1] = np.linspace(-3000, -2000, 100)
    with np.errstate(over="raise", invalid="raise"):
        log_weight, pareto_k = module._smoothed(flat, 2)
    np.testing.assert_allclose(np.logaddexp.reduce(log_weight, axis=0), 0, atol=1e-9)
    np.testing.assert_allclose(log_weight[:, 0], -math.log(100))
    assert pareto_k[0] == -np.inf
    assert pareto_k[1] > 0.7


def test_what_cannot_be_left_out() -> None:
    posterior = fit(walks([3, 3, 3]), draws=60)
    with pytest.raises(InputError, match="one trajectory"):
        leave_one_out(fit(walks([6]), draws=60))
    with pytest.raises(InputError, match="100"):
        leave_one_out(fit(walks([3, 3, 3]), draws=20))
    with pytest.raises(InputError, match="draws"):
        leave_one_out(posterior, draws=50)
    with pytest.raises(InputError, match="groups"):
        leave_one_out(fit(walks([3, 3, 3]), Grouped([0, 1, 1]), draws=60))
    with pytest.raises(InputError, match="likelihood"):
        leave_one_out(replace(posterior, likelihood=None))
    with pytest.raises(InputError, match="weighed"):
        leave_one_out(fit(walks([3, 3, 3]), draws=60, sampler=subgoal.samplers.alg4_literal))


def test_leaving_one_out_needs_no_extra() -> None:
    """In a process that has none of the packages of the extra ``arviz``."""
    code = """
import sys


class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("xarray", "arviz_base", "xarray_einstats"):
            raise ModuleNotFoundError(name)


sys.meta_path.insert(0, Missing())
from tests.answers.test_validation import fit, walks
from subgoal.answers.validation import leave_one_out

print(leave_one_out(fit(walks([4, 5, 3]), draws=60)).pareto_k.size, "xarray" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[2], capture_output=True, text=True)
    assert done.stdout.split() == ["3", "False"], done.stderr[-2000:]
