"""BNIRL end to end: the posterior it samples is the one that enumeration gives, and it finds goals in a grid world."""

from __future__ import annotations

from itertools import product
from math import exp, lgamma

import numpy as np
import pytest
from scipy.special import log_softmax, logsumexp

from experiments.fig_4_1 import SETTING
from experiments.grid_worlds import demonstrate, state, table, world
from subgoal import samplers
from subgoal.candidates import Candidates, visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bnirl import bnirl
from subgoal.posterior.sample import sample
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent
from tests.mdp.small_worlds import corridor
from tests.oracles.subgoal_planning import subgoal_values

pytestmark = pytest.mark.filterwarnings("ignore")
STATES, ACTIONS = np.array([1, 3, 4, 2]), np.array([1, 1, 2, 0])
ETA, ALPHA = 1.5, 4.0


def shares_by_enumeration() -> np.ndarray:
    """(4, 5) P(θ_i = g | O) over all 5⁴ assignments, with dense planning and no code of ours."""
    mdp = corridor(5, 0.8)
    dense = mdp.matrix.toarray().reshape(5, 3, 5), mdp.available, mdp.terminal
    q = [subgoal_values(*dense, [g], 0.8, "continuing")[1] for g in range(5)]
    values = np.array([log_softmax(ALPHA * each[STATES], axis=1)[np.arange(4), ACTIONS] for each in q]).T
    thetas = np.array(list(product(range(5), repeat=4)))
    prior = [sum(lgamma(np.sum(t == g) + ETA / 5) - lgamma(ETA / 5) for g in range(5)) for t in thetas]
    joint = np.array(prior) + values[np.arange(4), thetas].sum(axis=1)
    weight = np.exp(joint - logsumexp(joint))
    return np.array([[weight[thetas[:, i] == g].sum() for g in range(5)] for i in range(4)])


@pytest.mark.parametrize("sampler", [samplers.collapsed_blocks, samplers.alg4_corrected], ids=lambda s: s.__name__)
def test_shares_are_those_of_enumeration(sampler) -> None:
    demos = Demonstrations.from_arrays(STATES, ACTIONS)
    posterior = bnirl(
        demos, corridor(5, 0.8), candidates=Candidates.from_states(np.arange(5)), confidence=ALPHA, concentration=ETA,
        sampler=sampler, draws=5000, warmup=200, thin=2,
    )  # fmt: skip
    # 20,000 draws, at worst worth a tenth as many: 5 standard errors of a share of one half
    np.testing.assert_allclose(posterior.shares.toarray(), shares_by_enumeration(), atol=5 * 0.5 / 2000**0.5)


def test_candidates_are_the_visited_states_unless_told_otherwise() -> None:
    demos = Demonstrations.from_arrays(STATES, ACTIONS)
    posterior = bnirl(demos, corridor(5, 0.8), draws=10, warmup=5)
    assert [int(s[0]) for s in posterior.candidates.goal_sets] == [1, 2, 3, 4]
    np.testing.assert_allclose(np.exp(posterior.candidates.log_prior), 0.25)
    assert posterior.settings.confidence == 10.0
    assert posterior.settings.likelihood == "planned actions"


def test_the_three_subgoals_of_figure_4_1_are_found_and_the_printed_sum_smears_them() -> None:
    """Product against sum in (4.11): the printed form needs twice as many subgoals for the same pairs."""
    grid = world(0)
    shown = demonstrate(grid, SETTING.start, SETTING.subgoals, seed=0)
    likelihood = table(shown.demonstrations, grid, visited(shown.demonstrations))
    short = {"draws": 200, "warmup": 200, "thin": 2, "seed": 1}
    right = sample(likelihood, **short)
    wrong = sample(likelihood, sampler=samplers.alg4_literal_sum, **short)
    true = {state(grid, cell) for cell in SETTING.subgoals}
    top = np.argsort(-right.expected_shares)[:3]
    assert {int(likelihood.candidates.goal_sets[g][0]) for g in top} == true
    largest = [np.sort(each.expected_shares)[::-1][:3].sum() for each in (right, wrong)]
    assert largest[0] > 0.85 > largest[1] + 0.2


def test_the_confidence_of_the_table_is_that_of_the_softmax() -> None:
    """One pair, two candidates: the posterior odds are the ratio of the two softmax probabilities."""
    mdp = corridor(5, 0.8)
    demos = Demonstrations.from_arrays(np.array([2]), np.array([1]))
    posterior = bnirl(
        demos, mdp, candidates=Candidates.from_states([0, 4]), confidence=1.0, draws=5000, warmup=10, thin=1
    )
    right, left, still = (0.8 * v / 0.2 for v in (0.8, 0.8**3, 0.8**2))
    chances = [exp(v) / (exp(right) + exp(left) + exp(still)) for v in (left, right)]
    wanted = chances[1] / sum(chances)
    assert posterior.expected_shares[1] == pytest.approx(wanted, abs=5 * 0.5 / 20_000**0.5)


def test_arguments_in_the_wrong_place_are_told() -> None:
    demos, grid = Demonstrations.from_arrays(STATES, ACTIONS), world(0)
    for given, match in (
        ((grid.mdp, demos), "demonstrations: found TabularMDP"),
        ((demos, grid.free), r"mdp: found ndarray, wanted a TabularMDP, GridWorld"),
    ):
        with pytest.raises(InputError, match=match):
            bnirl(*given)
    with pytest.raises(InputError, match="candidates: found list"):
        bnirl(demos, grid.mdp, candidates=[1, 2])


class Told(Silent):
    """Keeps what it was told."""

    def __init__(self) -> None:
        self.steps: list[tuple[int, int]] = []

    def update(self, done: int, total: int, note: str = "") -> None:
        self.steps.append((done, total))


def test_planning_and_sampling_tell_how_far_they_are() -> None:
    grid, planning, sampling = world(0), Told(), Told()
    shown = demonstrate(grid, SETTING.start, SETTING.subgoals, seed=0)
    posterior = bnirl(
        shown.demonstrations, grid.mdp, planning_progress=planning, progress=sampling, draws=20, warmup=20, thin=1
    )
    g_count = posterior.candidates.n_candidates
    assert g_count > 20
    assert planning.steps[-1] == (g_count, g_count)
    assert len(planning.steps) > 1
    assert sampling.steps[-1] == (4 * 40, 4 * 40)
