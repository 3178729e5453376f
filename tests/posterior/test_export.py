"""A posterior as ArviZ takes it: what stands in it, by which names, and what is refused."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import subgoal
from subgoal.demonstrations.records import Demonstrations
from subgoal.models import Beta, Gamma, Grouped, NoiseLevels, OwnConfidence, Persistent, StickyHMM
from subgoal.posterior.export import RANKS
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError, MissingExtraError
from tests.posterior.worlds import corner_likelihood, quiet_sample

LENGTH = {"chains": 2, "draws": 60, "warmup": 30, "thin": 2, "seed": 3}
GOALS = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])


def four_walks(background: float = 0.0) -> subgoal.LogLikelihood:
    """Four short walks along the first side, blurred."""
    generator = np.random.default_rng(0)
    states = np.tile(np.linspace(1, 9, 5), 4)[:, None] * [[1.0, 0.0]]
    actions = np.column_stack([np.ones(20), generator.normal(scale=0.6, size=20)])
    demos = Demonstrations.from_arrays(states, actions, [0, 5, 10, 15, 20], trajectory_names=("a", "b", "c", "d"))
    places = subgoal.Candidates(GOALS, [0.2, 0.9, 0.4], radius=4.0)
    return subgoal.action_comparison(demos, places, confidence=2.0).with_background(background)


def posterior_of(model=None, likelihood: subgoal.LogLikelihood | None = None, **settings) -> Posterior:
    return quiet_sample(likelihood or four_walks(), model=model, **{**LENGTH, **settings})


def test_summaries_of_each_draw_are_those_of_its_assignment() -> None:
    posterior = posterior_of(None, four_walks(0.3), concentration=Gamma())
    tree = posterior.to_arviz()
    theta, found = posterior.assignments, tree["posterior"]
    used = [[np.unique(row[row >= 0]).size for row in chain] for chain in theta]
    np.testing.assert_array_equal(found["n_subgoals"], used)
    counts = np.stack([(theta == g).sum(axis=2) for g in range(3)], axis=2)
    np.testing.assert_allclose(found["share"], -np.sort(-counts, axis=2) / 20, atol=1e-15)
    np.testing.assert_allclose(found["background_share"], (theta < 0).mean(axis=2), atol=1e-15)
    np.testing.assert_array_equal(found["log_likelihood_total"], posterior.log_likelihood)
    np.testing.assert_array_equal(found["concentration"], posterior.parameters["concentration"])
    np.testing.assert_array_equal(tree["sample_stats"]["lp"], posterior.log_joint)
    assert np.ptp(np.asarray(used)) > 0


def test_dimensions_have_names_and_coordinates() -> None:
    levels = posterior_of(Persistent(keep_there=Beta()), confidence=NoiseLevels((0.5, 2.0, 8.0))).to_arviz()
    found = levels["posterior"]
    assert found["noise_levels"].dims == ("chain", "draw", "confidence_level")
    assert found["confidence_level"].values.tolist() == [0.5, 2.0, 8.0]
    assert found["persistence_at_the_subgoal"].dims == ("chain", "draw")
    assert found["share"].dims == ("chain", "draw", "rank")
    assert found["rank"].values.tolist() == [1, 2, 3]
    own = posterior_of(None, confidence=OwnConfidence()).to_arviz()["posterior"]
    assert own["confidence_of_each_candidate"].dims == ("chain", "draw", "candidate")
    for background, last in ((0.0, "candidate"), (0.2, "candidate_or_background")):
        groups = posterior_of(Grouped([0, 0, 1, 1]), four_walks(background)).to_arviz()["posterior"]
        assert groups["group_counts"].dims == ("chain", "draw", "group", last)
    data = levels["constant_data"]
    assert data["state"].dims == ("observation", "state_dimension")
    assert data["state_dimension"].values.tolist() == ["x0", "x1"]
    assert data["candidate_position"].dims == ("candidate", "place_dimension")
    np.testing.assert_array_equal(levels["observed_data"]["action"], four_walks().demonstrations.actions)
    timed = quiet_sample(corner_likelihood(), **LENGTH).to_arviz()
    assert timed["posterior"].sizes["rank"] == RANKS
    assert timed["constant_data"]["time"].dims == ("observation",)


def test_provenance_stands_with_it() -> None:
    posterior = posterior_of(StickyHMM())
    told = posterior.to_arviz().attrs
    settings = posterior.settings
    wanted = (settings.version, 3, settings.data, settings.model, posterior.status.name)
    names = ("inference_library_version", "seed", "data_checksum", "model", "status")
    assert tuple(told[name] for name in names) == wanted
    assert all(isinstance(value, (str, int, float)) for value in told.values())


def test_a_posterior_from_a_file_gives_the_same(tmp_path) -> None:
    posterior = posterior_of(Persistent(), confidence=NoiseLevels())
    again = subgoal.load(subgoal.save(posterior, tmp_path / "posterior.npz"))
    one, two = (each.to_arviz(log_likelihood=True) for each in (posterior, again))
    for group in ("posterior", "sample_stats", "log_likelihood", "constant_data"):
        for name, values in one[group].data_vars.items():
            np.testing.assert_allclose(values, two[group][name], rtol=0, atol=1e-9, err_msg=name)


def test_arviz_leaves_out_trajectories() -> None:
    from arviz_stats import loo, rhat

    tree = posterior_of(Persistent(), draws=200, chains=4).to_arviz(log_likelihood=True)
    values = tree["log_likelihood"]["trajectory_actions"]
    assert values.dims == ("chain", "draw", "trajectory")
    assert values["trajectory"].values.tolist() == ["a", "b", "c", "d"]
    found = loo(tree, pointwise=True)
    assert found.n_data_points == 4
    assert np.isfinite(found.elpd)
    assert float(rhat(tree["posterior"].to_dataset()[["persistence"]])["persistence"]) < 1.1


def test_what_is_no_probability_is_refused() -> None:
    with pytest.raises(InputError, match="weighted"):
        posterior_of(None, four_walks().weighted(0.5)).to_arviz(log_likelihood=True)
    assert "log_likelihood" in posterior_of(None, four_walks().weighted(1.0)).to_arviz(log_likelihood=True)
    with pytest.raises(InputError, match="groups"):
        posterior_of(Grouped([0, 0, 1, 1])).to_arviz(log_likelihood=True)
    lost = replace(posterior_of(), likelihood=None)
    assert "log_likelihood" not in lost.to_arviz()
    with pytest.raises(InputError, match="likelihood"):
        lost.to_arviz(log_likelihood=True)


def test_without_arviz_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    posterior = posterior_of()
    monkeypatch.setitem(sys.modules, "arviz_base", None)
    with pytest.raises(MissingExtraError, match=r"subgoal\[arviz\]"):
        posterior.to_arviz()


def test_arviz_is_not_loaded_before_it_is_asked_for() -> None:
    code = "import sys, subgoal, subgoal.posterior.posterior; print([m for m in sys.modules if 'arviz' in m])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"
