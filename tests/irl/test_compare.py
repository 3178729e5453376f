"""Methods side by side: their floors by hand, what each may look at, what cannot be fitted, bad input."""

from __future__ import annotations

import signal
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.cloning import behaviour_cloning
from subgoal.irl.compare import compare
from subgoal.irl.rivals import (
    RIVALS,
    Fitted,
    error_rate,
    lasting_subgoals,
    merge_radius,
    second_order,
    subgoal_mixture,
)
from subgoal.mdp.grids.grid import GridWorld
from subgoal.options.tabular import execute, goal_option
from subgoal.plots.comparison import one_reward_words
from subgoal.runtime.errors import InputError, SubgoalError
from subgoal.runtime.progress import Silent
from tests.answers.made import posterior_of

GRID = GridWorld(np.ones((5, 5), bool), discount=0.9, moves=4)
CORNERS = [(0, 0), (4, 0), (4, 4), (0, 4)]


def rounds(count: int = 6) -> Demonstrations:
    """From corner to corner, one whole round in each trajectory: two goals ask for opposite steps in one cell."""
    states: list[int] = []
    actions: list[int] = []
    offset = [0]
    for k in range(count):
        for begin, end in zip(CORNERS, [*CORNERS[1:], CORNERS[0]], strict=True):
            leg = execute(
                goal_option(GRID.mdp, int(GRID.state(*end))), GRID.mdp, start=int(GRID.state(*begin)), steps=50, seed=k
            )
            states += leg.states.tolist()
            actions += leg.actions.tolist()
        offset.append(len(states))
    final = np.full(count, GRID.state(0, 0))
    return Demonstrations(np.array(states), np.array(actions), np.array(offset), final_states=final,
                          coordinates=GRID.coordinates)  # fmt: skip


DEMOS = rounds()


def test_floors_are_those_by_hand() -> None:
    found = {each.key: each for each in compare(DEMOS, GRID.mdp, methods=["cloning"], folds=3).methods}
    assert set(found) == {"chance", "cloning", "markov"}
    legal = GRID.mdp.available.sum(axis=1)[DEMOS.states]
    assert found["chance"].bits_per_decision == pytest.approx(-np.log2(legal).mean(), abs=1e-12)
    assert found["chance"].loss == pytest.approx(1 - (1 / legal).mean(), abs=1e-12)
    # Six equal rounds in three folds: each action was seen four times, in its cell once a round.
    table = {(s, a) for s, a in zip(DEMOS.states.tolist(), DEMOS.actions.tolist(), strict=True)}
    assert len(table) == 16
    wanted = np.mean([np.log2(5 / (4 + GRID.mdp.available[s].sum())) for s, _ in sorted(table)])
    assert found["cloning"].bits_per_decision == pytest.approx(wanted, abs=1e-12)
    assert found["cloning"].loss == 0


def test_every_method_gives_probabilities_and_is_scored_on_the_same_decisions() -> None:
    found = compare(DEMOS, GRID.mdp, folds=2, seed=3)
    assert not found.failed
    assert {each.key for each in found.methods} == set(RIVALS) - {"bayesian"}
    for each in found.methods:
        assert each.bits_per_decision <= 0
        assert 0 <= each.loss <= 1
        np.testing.assert_array_equal(each.decisions, np.diff(DEMOS.offset))
    bits = [each.bits_per_decision for each in found.methods]
    assert bits == sorted(bits, reverse=True)
    assert found.behind(found.best).bits_per_decision == 0


def test_lasting_subgoals_foretell_rounds_better_than_one_reward() -> None:
    found = {m.key: m for m in compare(DEMOS, GRID.mdp, methods=["bnirl-persistent", "margin"], folds=2).methods}
    assert found["bnirl-persistent"].loss < 0.2 < found["margin"].loss
    assert found["bnirl-persistent"].bits_per_decision > found["margin"].bits_per_decision + 0.3


def test_a_filter_never_looks_at_the_action_it_foretells() -> None:
    """Another last action leaves what was foretold for it as it was."""
    fitted = lasting_subgoals(DEMOS, GRID.mdp, 0)
    asked = Demonstrations(DEMOS.states[:3], DEMOS.actions[:3], np.array([0, 3]), coordinates=GRID.coordinates)
    other = np.array(DEMOS.actions[:3])
    other[2] = next(a for a in np.flatnonzero(GRID.mdp.available[DEMOS.states[2]]) if a != other[2])
    changed = Demonstrations(DEMOS.states[:3], other, np.array([0, 3]), coordinates=GRID.coordinates)
    np.testing.assert_allclose(fitted.foretell(asked), fitted.foretell(changed), atol=1e-8)
    table = fitted.foretell(DEMOS)
    np.testing.assert_allclose(table.sum(axis=1), 1)


def test_the_second_order_chain_is_that_by_hand() -> None:
    demos = Demonstrations(np.array([0, 1, 0, 1]), np.array([1, 1, 1, 0]), np.array([0, 2, 4]),
                           final_states=np.array([2, 6]))  # fmt: skip
    grid = GridWorld(np.ones((5, 5), bool), discount=0.9, moves=4)
    demos = Demonstrations(demos.states, demos.actions, demos.offset, final_states=demos.final_states)
    fitted = second_order(demos, grid.mdp, 0)
    asked = Demonstrations(np.array([0, 1]), np.array([1, 1]), np.array([0, 2]))
    legal = grid.mdp.available[1].sum()
    first_order = 2 / (2 + legal)
    assert fitted.foretell(asked)[1, 1] == pytest.approx((1 + first_order) / 3)
    first = 3 / (2 + grid.mdp.available[0].sum())
    assert fitted.foretell(asked)[0, 1] == pytest.approx((2 + first) / 3)
    alone = Demonstrations(np.array([1]), np.array([1]), np.array([0, 1]))
    assert fitted.foretell(alone)[0, 1] == pytest.approx(first_order)


def test_the_share_of_errors_is_the_likeliest() -> None:
    policy = np.zeros(GRID.mdp.available.shape)
    policy[DEMOS.states, DEMOS.actions] = 1
    policy = policy / np.maximum(policy.sum(axis=1, keepdims=True), 1)
    states, actions = np.array(DEMOS.states[:16]), np.array(DEMOS.actions[:16])
    wrong = next(a for a in np.flatnonzero(GRID.mdp.available[states[3]]) if a != actions[3])
    actions[3] = wrong
    demos = Demonstrations.from_arrays(states, actions)
    share = error_rate(policy, demos, GRID.mdp)

    def fit(e: float) -> float:
        own, even = policy[states, actions], 1 / GRID.mdp.available.sum(axis=1)[states]
        return float(np.log((1 - e) * own + e * even).sum())

    assert fit(share) >= max(fit(e) for e in np.linspace(0.01, 0.99, 99)) - 1e-9


def test_methods_of_ones_own_and_those_that_fail() -> None:
    def even(demos, mdp, seed):
        return Fitted(lambda asked: mdp.available[asked.states] / 5.0, 0, "")

    def broken(demos, mdp, seed):
        raise SubgoalError("no such luck")

    found = compare(DEMOS, GRID.mdp, methods={"mine": even, "other": broken}, folds=2)
    assert {each.name for each in found.methods} >= {"mine", "chance"}
    assert found.failed == {"other": "no such luck"}


def test_a_method_may_give_a_policy_or_a_learned_reward() -> None:
    even = GRID.mdp.available / GRID.mdp.available.sum(axis=1, keepdims=True)
    found = compare(
        DEMOS, GRID.mdp, folds=2,
        methods={"table": lambda d, m, s: even, "counts": lambda d, m, s: behaviour_cloning(d, m)},
    )  # fmt: skip
    bits = {each.key: each.bits_per_decision for each in found.methods}
    assert bits["table"] == bits["chance"]
    assert bits["counts"] == bits["cloning"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (lambda asked: np.full((asked.n_observations, 5), 1.0), "sum to 5"),
        (lambda asked: np.full((asked.n_observations, 5), np.nan), "finite"),
        (lambda asked: np.full((3, 5), 0.2), "shape"),
    ],
)
def test_what_is_no_probability_cannot_win(given, told: str) -> None:
    found = compare(DEMOS, GRID.mdp, methods={"mine": lambda d, m, s: Fitted(given)}, folds=2)
    assert told in found.failed["mine"]
    wrong = compare(DEMOS, GRID.mdp, methods={"mine": lambda d, m, s: "policy"}, folds=2)
    assert "SingleReward" in wrong.failed["mine"]


def test_what_ctrl_c_came_before_is_named() -> None:
    def stop(demos, mdp, seed):
        signal.raise_signal(signal.SIGINT)
        return GRID.mdp.available / 5.0

    found = compare(DEMOS, GRID.mdp, methods={"stops": stop, "never": stop}, folds=2)
    assert {each.key for each in found.methods} == {"chance", "cloning", "markov"}
    assert found.unfinished == ("stops", "never")


def test_neighbouring_cells_are_counted_as_one_subgoal(monkeypatch) -> None:
    """Within 3.5 cells; three candidates, two of them side by side, are two subgoals."""
    places = np.empty((GRID.n_states, 2))
    for x, y in np.ndindex(5, 5):
        places[GRID.state(x, y)] = 0.5 * x, 0.5 * y
    demos = replace(DEMOS, coordinates=places, names=("x", "y"))
    assert merge_radius(demos, GRID.mdp) == pytest.approx(5 * 0.5 / np.sqrt(2))
    assert merge_radius(DEMOS, GRID.mdp) == 0
    cells = [int(GRID.state(x, 0)) for x in (0, 1, 4)]
    held = np.repeat([[0, 1, 2]], [36, 30, 30], axis=1)
    made = posterior_of(held, Candidates.from_states(cells, coordinates=places))
    monkeypatch.setattr("subgoal.irl.rivals.bnirl", lambda *world, **settings: replace(made, demonstrations=demos))
    assert subgoal_mixture(DEMOS, GRID.mdp, 0).size == 2


def test_time_left_is_told_of_each_method_alone() -> None:
    class Kept(Silent):
        told: ClassVar[list[tuple[int, int, str]]] = []

        def update(self, done: int, total: int, note: str = "") -> None:
            self.told.append((done, total, note))

    compare(DEMOS, GRID.mdp, methods=["cloning"], folds=2, progress=Kept())
    assert [done for done, _, _ in Kept.told] == [0, 1, 2, 2, 3, 4, 4, 5, 6]
    assert [note for _, _, note in Kept.told[:3]] == ["chance", *["chance, 0 s left of it"] * 2]


def test_whether_one_reward_is_enough_is_a_paired_difference() -> None:
    found = compare(DEMOS, GRID.mdp, methods=["bnirl-persistent", "entropy"], folds=2)
    several, single, gap = found.one_reward()
    assert (several.key, single.key) == ("bnirl-persistent", "entropy")
    assert gap == several.difference(single)
    assert "One reward is not enough" in one_reward_words(found)
    assert compare(DEMOS, GRID.mdp, methods=["entropy"], folds=2).one_reward() is None


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="methods"):
        compare(DEMOS, GRID.mdp, methods=["gail"])
    with pytest.raises(InputError, match="folds"):
        compare(DEMOS, GRID.mdp, folds=7)
    for methods in ([], {}):
        with pytest.raises(InputError, match="methods: found none"):
            compare(DEMOS, GRID.mdp, methods=methods)
    with pytest.raises(InputError, match="found 'bnirl', wanted a list of some of chance"):
        compare(DEMOS, GRID.mdp, methods="bnirl")
    for mixed in (["bnirl", second_order], {"bnirl": "bnirl", "mine": second_order}):
        with pytest.raises(
            InputError, match=r"wanted (names in a list|a function).*RIVALS\['bnirl'\]\[1\], 'mine': mine"
        ):
            compare(DEMOS, GRID.mdp, methods=mixed)
    one = Demonstrations(DEMOS.states[:16], DEMOS.actions[:16], np.array([0, 16]))
    with pytest.raises(InputError, match="trajectory"):
        compare(one, GRID.mdp)
    with pytest.raises(InputError, match="observation"):
        compare(Demonstrations(np.array([0, 24]), np.array([0, 0]), np.array([0, 2])), GRID.mdp)
