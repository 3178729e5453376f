"""Action comparison against the slow oracle, and the compiled path against the generic one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import normalisers
from subgoal.runtime.errors import InputError
from tests.oracles import directions as oracle

TURN = 2 * math.pi
METRICS = {
    "plain 2-D": Metric.euclidean(2),
    "weights": Metric.of(2, [0.3, 7.0]),
    "angle": Metric.of(2, [1.0, 2.0], [np.inf, TURN]),
    "two angles": Metric.of(2, [1.0, 0.5], [TURN, 3.0]),
    "plain 1-D": Metric.euclidean(1),
    "3-D, an angle": Metric.of(3, [1.0, 0.2, 3.0], [np.inf, np.inf, TURN]),
    "4-D": Metric.euclidean(4),
}


def scene(metric: Metric, seed: int = 0, n: int = 12, g_count: int = 7, radius: float = 1.0):
    """States and candidates that lie turns apart on wrapped axes; the third candidate is at the fourth state."""
    generator = np.random.default_rng(seed)
    d = metric.dimension
    states, points = generator.uniform(-6, 6, (n, d)), generator.uniform(-6, 6, (g_count, d))
    points[2] = states[3] + 0.1 * radius / metric.weights / d
    demos = Demonstrations.from_arrays(states, generator.normal(size=(n, d)))
    return demos, Candidates(points, radius=radius, metric=metric)


@pytest.mark.parametrize("name", METRICS)
def test_directions_against_the_oracle(name: str) -> None:
    metric = METRICS[name]
    demos, candidates = scene(metric)
    table = subgoal.action_comparison(demos, candidates, confidence=2.5).dense
    wanted = [
        [oracle.log_direction_density(s, a, g, 2.5, metric.weights, metric.period, 1.0) for g in candidates.points]
        for s, a in zip(demos.states, demos.actions, strict=True)
    ]
    np.testing.assert_allclose(table, wanted, atol=1e-9)
    assert table[3, 2] == pytest.approx(-math.log(oracle.sphere_area(metric.dimension)), abs=1e-12)


@pytest.mark.parametrize("name", METRICS)
def test_compiled_directions_are_the_generic_path(name: str) -> None:
    metric = METRICS[name]
    demos, candidates = scene(metric, seed=1, n=40, g_count=30)
    compiled = subgoal.action_comparison(demos, candidates)
    way = subgoal.controllers.straight_to_goal(metric)
    generic = subgoal.action_comparison(demos, candidates, controller=way, compare="direction")
    assert (compiled.source.kind, generic.source.kind) == ("directions", "controller")
    np.testing.assert_allclose(compiled.dense, generic.dense, atol=1e-13)
    np.testing.assert_array_equal(compiled.arrived.toarray(), generic.arrived.toarray())
    np.testing.assert_allclose(compiled.log_marginal, generic.log_marginal, atol=1e-13)
    assert compiled.arrived[3, 2]


@pytest.mark.parametrize("seed", range(5))
def test_density_integrates_to_one_over_weighted_directions(seed: int) -> None:
    """u is the weighted action normalised: integrate over the angle of u, whatever the weights are."""
    generator = np.random.default_rng(seed)
    metric = Metric.of(2, generator.uniform(0.1, 10, 2))
    states, points = generator.normal(size=(1, 2)), generator.normal(size=(3, 2))
    angle = (np.arange(20_000) + 0.5) * TURN / 20_000
    u = np.column_stack([np.cos(angle), np.sin(angle)])
    demos = Demonstrations.from_arrays(np.repeat(states, len(u), axis=0), u / metric.weights)
    table = subgoal.action_comparison(demos, Candidates(points, metric=metric), confidence=3.0).dense
    # The midpoint rule on a kink of slope α leaves an error of order α·h² = 3e-7.
    np.testing.assert_allclose(np.exp(table).sum(axis=0) * TURN / len(u), 1.0, atol=1e-6)


def straight(state, goal):
    return goal - state


@pytest.mark.parametrize("k", [1, 2])
def test_action_density_integrates_to_one(k: int) -> None:
    """At a fixed scale (the source is given the pace), over R^k by quadrature."""
    weights = np.array([3.0, 0.5])[:k]
    metric = Metric.of(k, weights)
    demos = Demonstrations.from_arrays(np.zeros((9, k)), np.vstack([np.zeros((1, k)), np.eye(k)[[0] * 8] * 2.0]))
    candidates = Candidates(np.full((1, k), 0.4), metric=metric)
    source = subgoal.action_comparison(demos, candidates, controller=straight, confidence=2.0).source

    def density(*action: float) -> float:
        source.actions[0], source.pace.slow[0] = action, False  # type: ignore[attr-defined]
        return math.exp(source.log_density(0, 1, 2.0)[0, 0])

    object.__setattr__(source, "actions", np.array(demos.actions))
    reach = 30 * 2.0 * weights[0] / 2.0 / weights
    if k == 1:
        total = quad(density, -reach[0], reach[0], points=[0.4], epsrel=1e-9, limit=200)[0]
    else:
        total = sum(
            dblquad(density, *ys, *xs, epsabs=1e-5)[0]
            for xs in ((-reach[0], 0.4), (0.4, reach[0]))
            for ys in ((-reach[1], 0.4), (0.4, reach[1]))
        )
    assert total == pytest.approx(1.0, abs=1e-3 if k == 2 else 1e-8)


def test_arrived_actions_are_compared_with_standing_still() -> None:
    demos = Demonstrations.from_arrays([[0.0, 0.0], [5.0, 0.0]], [[1.0, 0.0], [1.0, 0.0]])
    candidates = Candidates([[0.1, 0.0], [9.0, 0.0]], radius=1.0)
    table = subgoal.action_comparison(demos, candidates, controller=lambda s, g: 0 * (g - s) + 1.0, confidence=2.0)
    log_z = normalisers.log_action_normaliser(2.0, 2, 1.0, 0.0)
    np.testing.assert_allclose(table.dense, [[-2 - log_z, -2 - log_z], [-2 - log_z, -2 - log_z]], atol=1e-12)
    other = subgoal.action_comparison(demos, candidates, controller=lambda s, g: 0 * (g - s) + [3.0, 0.0], confidence=2)
    np.testing.assert_allclose(other.dense, [[-2 - log_z, -4 - log_z], [-4 - log_z, -4 - log_z]], atol=1e-12)


@pytest.mark.parametrize("compare", ["direction", "action"])
def test_slow_pairs_are_uniform_and_counted(compare) -> None:
    generator = np.random.default_rng(2)
    actions = generator.normal(size=(11, 2))
    speed = np.linalg.norm(actions, axis=1)
    actions[[4, 7]] = [[0.0, 0.0], [0.0099 * np.median(np.r_[speed[:4], speed[5:]]), 0.0]]
    demos = Demonstrations.from_arrays(generator.normal(size=(11, 2)), actions)
    table = subgoal.action_comparison(demos, scene(METRICS["plain 2-D"])[1], controller=straight, compare=compare)
    flat = -math.log(TURN) if compare == "direction" else -math.log(math.pi * (actions**2).sum(axis=1).max())
    assert table.source.uninformative.tolist() == [i in (4, 7) for i in range(11)]
    np.testing.assert_allclose(table.dense[[4, 7]], flat, atol=1e-12)
    if compare == "direction":
        compiled = subgoal.action_comparison(demos, scene(METRICS["plain 2-D"])[1])
        np.testing.assert_allclose(compiled.dense, table.dense, atol=1e-13)
        assert (compiled.source.uninformative == table.source.uninformative).all()


def test_the_scale_of_actions_changes_no_direction() -> None:
    demos, candidates = scene(METRICS["angle"])
    for factor in (1e-9, 0.1, 1e12):
        scaled = Demonstrations.from_arrays(demos.states, np.asarray(demos.actions) * factor)
        np.testing.assert_allclose(
            subgoal.action_comparison(scaled, candidates).dense,
            subgoal.action_comparison(demos, candidates).dense,
            atol=1e-12,
        )
    assert demos.actions.flags.writeable is False


def test_a_whole_turn_changes_nothing() -> None:
    demos, candidates = scene(METRICS["angle"])
    turned = Demonstrations.from_arrays(np.asarray(demos.states) + np.array([0, 3 * TURN]), demos.actions)
    moved = subgoal.action_comparison(turned, candidates).dense
    np.testing.assert_allclose(moved, subgoal.action_comparison(demos, candidates).dense, atol=1e-12)
    plain = Candidates(candidates.points, radius=candidates.radius)
    assert np.abs(subgoal.action_comparison(turned, plain).dense - moved).max() > 0.1


@pytest.mark.parametrize(
    ("controller", "message"),
    [(lambda s, g: np.zeros(3), "shape"), (lambda s, g: (g - s)[..., :1, None, :], "shape"),
     (lambda s, g: (g - s) * np.nan, "non-finite"), (lambda s, g: (g - s) / 0.0, "non-finite")],
)  # fmt: skip
def test_bad_controllers_are_named(controller, message: str) -> None:
    demos, candidates = scene(METRICS["plain 2-D"])
    with np.errstate(all="ignore"), pytest.raises(InputError, match=f"controller.*{message}"):
        subgoal.action_comparison(demos, candidates, controller=controller)


def test_a_controller_that_breaks_later_names_the_pair() -> None:
    demos, candidates = scene(METRICS["plain 2-D"])
    bad = demos.states[5]

    def controller(state, goal):
        return np.where((state == bad).all(axis=-1, keepdims=True), np.inf, goal - state)

    table = subgoal.action_comparison(demos, candidates, controller=controller)
    with pytest.raises(InputError, match="observation 5, candidate 0"):
        table.log_marginal  # noqa: B018


def test_bad_requests_are_named() -> None:
    demos, candidates = scene(METRICS["plain 2-D"])
    still = Demonstrations.from_arrays(demos.states, np.zeros((12, 2)))
    flat = Demonstrations.from_arrays(np.arange(4), np.arange(4))
    narrow = Demonstrations.from_arrays(demos.states, np.ones(12))
    for settings, message in [
        ({"compare": "angle"}, "compare"), ({"compare": "action"}, "controller"), ({"confidence": 0.0}, "confidence"),
        ({"confidence": np.nan}, "confidence"), ({"confidence": -1}, "confidence"), ({"confidence": "x"}, "confidence"),
    ]:  # fmt: skip
        with pytest.raises(InputError, match=message):
            subgoal.action_comparison(demos, candidates, **settings)
    for other, message in ((still, "only zeros"), (flat, "found integers"), (narrow, "1 columns")):
        with pytest.raises(InputError, match=message):
            subgoal.action_comparison(other, candidates)
    with pytest.raises(InputError, match="candidates: found 1 dimensions"):
        subgoal.action_comparison(demos, Candidates([1.0]))


@pytest.mark.parametrize("factor", [1e155, 1e-160])
def test_numbers_whose_squares_are_none_are_refused(factor: float) -> None:
    states, actions = np.random.default_rng(0).normal(size=(2, 20, 2))
    places = Candidates(states[:5] * factor)
    with pytest.raises(InputError, match="range of"):
        subgoal.action_comparison(subgoal.Demonstrations.from_arrays(states * factor, actions), places)
    with pytest.raises(InputError, match="range of"):
        subgoal.action_comparison(subgoal.Demonstrations.from_arrays(states, actions * factor), Candidates(states))
