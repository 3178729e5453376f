"""Shipped likelihoods pass the public checks; with one planted fault each they do not."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import sparse

import subgoal
from subgoal.candidates import Candidates, every_state
from subgoal.checks import check_likelihood
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import normalisers
from subgoal.likelihood.planned_actions import PlannedActions, planned_actions
from subgoal.likelihood.source import Levels
from subgoal.likelihood.sources import Directions
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError
from tests.mdp.small_worlds import world


def demos(n: int = 40) -> Demonstrations:
    generator = np.random.default_rng(2)
    return Demonstrations.from_arrays(generator.uniform(0, 10, (n, 2)), generator.normal(size=(n, 2)))


def places(count: int = 7) -> Candidates:
    return Candidates(np.random.default_rng(3).uniform(0, 10, (count, 2)), radius=1.0)


def directions(confidence: float = 3.0, **fields) -> LogLikelihood:
    return subgoal.action_comparison(demos(), places(), confidence=confidence, **fields)


def planned(confidence: float = 4.0) -> LogLikelihood:
    mdp, _ = world(4, 0.95, n_states=8, illegal=True)
    return planned_actions(walks(mdp), every_state(mdp), mdp, confidence=confidence)


def walks(mdp: TabularMDP) -> Demonstrations:
    generator = np.random.default_rng(1)
    states = generator.choice(np.flatnonzero(~mdp.terminal), size=30)
    return Demonstrations.from_arrays(
        states, np.array([generator.choice(np.flatnonzero(mdp.available[s])) for s in states])
    )


def straight(state, goal):
    return goal - state


TABLE = LogLikelihood.from_table(np.random.default_rng(0).normal(size=(9, 4)))
RIGHT = {
    "directions": directions(),
    "one confidence each": directions(np.linspace(1, 5, 7)),
    "levels": replace(directions(), confidence=Levels(np.array([1.0, 8.0]), np.array([0.3, 0.7]))),
    "background": directions().with_background(0.2),
    "weighted": directions().weighted(0.5),
    "controller by direction": directions(controller=straight, compare="direction"),
    "planned": planned(),
    "planned, background": planned().with_background(0.1),
}
PARTLY = {"controller by action": directions(controller=straight), "own table": TABLE, "confident": directions(500.0)}


@pytest.mark.parametrize("likelihood", RIGHT.values(), ids=RIGHT.keys())
def test_shipped_likelihoods_pass(likelihood: LogLikelihood) -> None:
    report = check_likelihood(likelihood)
    assert all(check.passed for check in report.checks), str(report)
    assert len(report.checks) == 8


@pytest.mark.parametrize("likelihood", PARTLY.values(), ids=PARTLY.keys())
def test_what_cannot_be_summed_is_said_not_to_have_been(likelihood: LogLikelihood) -> None:
    report = check_likelihood(likelihood)
    assert report.passed, str(report)
    assert report["densities are complete"].passed is None
    assert sum(check.passed is None for check in report.checks) == 1
    assert "1 not run" in repr(report)


@dataclass(frozen=True, eq=False)
class Unnormalised(Directions):
    """−α‖u − û‖ alone: (5.1) as printed."""

    def log_density(self, start, stop, confidence):
        densities = super().log_density(start, stop, confidence)
        return densities + normalisers.log_direction_normaliser(float(confidence), 2)


@dataclass(frozen=True, eq=False)
class UnnormalisedPlan(PlannedActions):
    """α·Q alone: the sum over actions left out of (4.2)."""

    def log_density(self, start, stop, confidence):
        pairs = self.pair[start:stop]
        return confidence * self.plan.action_values[self.state_row[pairs], self.action[pairs]]


def spoiled(kind, likelihood: LogLikelihood) -> LogLikelihood:
    source = likelihood.source
    fields = {name: getattr(source, name) for name, field in source.__dataclass_fields__.items() if field.init}
    return replace(likelihood, source=kind(**fields))


@pytest.mark.parametrize("likelihood", [spoiled(Unnormalised, directions()), spoiled(UnnormalisedPlan, planned())])
def test_a_dropped_normaliser_is_noticed(likelihood: LogLikelihood) -> None:
    report = check_likelihood(likelihood)
    assert [check.name for check in report.failures] == ["densities are complete"], str(report)


@dataclass(frozen=True, eq=False)
class Faulty(Directions):
    fault = ""

    def log_density(self, start, stop, confidence):
        if self.fault == "deaf":
            confidence = 3.0
        densities = super().log_density(start, stop, confidence)
        if self.fault == "nan" and start <= 5 < stop:
            densities[5 - start, 2] = np.nan
        if self.fault == "infinite" and start <= 5 < stop:
            densities[5 - start, 2] = np.inf
        if self.fault == "impossible" and start <= 5 < stop:
            densities[5 - start] = -np.inf
        if self.fault == "by block":
            densities = densities + 1e-12 * np.arange(len(densities))[:, None]
        return densities[:, :-1] if self.fault == "narrow" else densities

    def arrived(self, start, stop):
        there = super().arrived(start, stop)
        return there.astype(float) if self.fault == "arrived" else there


FAULTS = {
    "nan": "values", "infinite": "values", "impossible": "values", "narrow": "shape of the rows",
    "by block": "rows one by one = all at once", "deaf": "another confidence and back", "arrived": "arrived",
}  # fmt: skip


@pytest.mark.parametrize(("fault", "name"), FAULTS.items(), ids=FAULTS.keys())
def test_each_rule_is_noticed_when_it_is_broken(fault: str, name: str) -> None:
    kind = dataclass(frozen=True, eq=False)(type("Spoiled", (Faulty,), {"fault": fault}))
    report = check_likelihood(spoiled(kind, directions()))
    assert report[name].passed is False, str(report)


def test_a_held_table_that_is_not_that_of_its_source_is_noticed() -> None:
    likelihood = directions()
    likelihood.hold(likelihood.rows(0, 40) + 1e-12)
    assert check_likelihood(likelihood)["tiles = whole table"].passed is False


def test_a_source_of_ones_own_is_summed_with_remake() -> None:
    def made(pairs: Demonstrations, area: float = 2 * np.pi) -> LogLikelihood:
        way = places().points[None] - np.asarray(pairs.states)[:, None]
        ahead = np.sum(way * np.asarray(pairs.actions)[:, None], axis=2) > 0
        return LogLikelihood.from_table(np.log(np.where(ahead, 1.5, 0.5) / area), demonstrations=pairs)

    for area, passed in ((2 * np.pi, True), (1.0, False)):
        report = check_likelihood(made(demos(), area), remake=lambda pairs, area=area: made(pairs, area))
        assert report["densities are complete"].passed is passed, str(report)


def test_a_prior_that_does_not_sum_to_one_is_noticed() -> None:
    likelihood = directions()
    likelihood.__dict__["log_prior"] = likelihood.log_prior + 0.1
    assert check_likelihood(likelihood)["prior"].passed is False


def test_arrived_must_be_sparse() -> None:
    likelihood = directions()
    likelihood.__dict__["arrived"] = likelihood.arrived.toarray()
    assert not sparse.issparse(likelihood.arrived)
    assert check_likelihood(likelihood)["arrived"].passed is False


def test_something_else_is_refused() -> None:
    with pytest.raises(InputError, match="LogLikelihood"):
        check_likelihood(np.zeros((3, 2)))  # type: ignore[arg-type]
