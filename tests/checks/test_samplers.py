"""Shipped samplers pass the public checks; printed forms and samplers with one planted fault each do not."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from subgoal import samplers
from subgoal.checks import Report, check_sampler
from subgoal.checks.enumeration import TABLES, enumerated
from subgoal.partition.protocol import Chain
from subgoal.runtime.errors import InputError
from tests.oracles.tables import assignment_posterior

RIGHT = [
    samplers.collapsed_blocks, samplers.alg4_corrected, samplers.blocked, samplers.collapsed,
    samplers.cluster_collapsed, samplers.split_merge, samplers.tempered,
]  # fmt: skip
PRINTED = [samplers.alg4_literal, samplers.alg4_literal_fresh_draw, samplers.alg4_literal_sum]
SHORT = {"sweeps": 10_000, "starts": 2_000}
RULES = {
    "traces are those of the assignments", "same seed, same draws", "goes on from its state", "global random state",
    "inputs", "tiles = whole table",
}  # fmt: skip


def name_of(sampler) -> str:
    return sampler.__name__


@pytest.mark.parametrize("sampler", RIGHT, ids=name_of)
def test_shipped_samplers_pass(sampler) -> None:
    report = check_sampler(sampler, **SHORT)
    assert report.passed, str(report)
    assert all(check.passed for check in report.checks), str(report)
    assert len(report.checks) == 12


@pytest.mark.t2
@pytest.mark.parametrize("sampler", RIGHT, ids=name_of)
@pytest.mark.parametrize("eta", [0.3, 4.0])
def test_shipped_samplers_pass_in_full(sampler, eta: float) -> None:
    report = check_sampler(sampler, concentration=eta, seed=1)
    assert report.passed, str(report)


@pytest.mark.parametrize("sampler", PRINTED, ids=name_of)
def test_printed_forms_fail_by_their_law(sampler) -> None:
    """At the default lengths: (4.12) alone is 0.05 away on the peaked table."""
    report = check_sampler(sampler)
    failed = {check.name for check in report.failures}
    assert {"long run, peaked table", "one sweep from exact draws, peaked table"} <= failed
    assert failed - RULES


@pytest.mark.parametrize("table", TABLES)
def test_enumeration_is_that_of_the_oracle(table: str) -> None:
    law = enumerated(TABLES[table], 1.7)
    wanted = assignment_posterior(TABLES[table], 1.7, np.array([0.5, 0.3, 0.2]))
    found = {tuple(state): p for state, p in zip(law.states.tolist(), law.probability, strict=True)}
    for state, p in wanted.items():
        assert abs(found.get(state, 0.0) - p) <= 1e-14
    assert law.tally(law.states[::-1]).tolist() == [1] * len(law.states)


def shared_generator(chain: Chain, keep):
    np.random.rand()  # noqa: NPY002
    return samplers.collapsed(chain, keep)


def own_generator(chain: Chain, keep):
    return samplers.collapsed(replace(chain, generator=np.random.default_rng()), keep)


def forgetful(chain: Chain, keep):
    return samplers.collapsed(replace(chain, state=None), keep)


def writes_the_mask(chain: Chain, keep):
    stretch = samplers.collapsed(chain, keep)
    keep[:] = False
    return stretch


def wrong_joint(chain: Chain, keep):
    stretch = samplers.collapsed(chain, keep)
    return replace(stretch, log_joint=stretch.log_joint + 1e-6)


def wrong_count(chain: Chain, keep):
    stretch = samplers.collapsed(chain, keep)
    return replace(stretch, n_active=stretch.n_active + 1)


def differs_when_tiled(chain: Chain, keep):
    if chain.table.dense is None:
        chain.generator.random()
    return samplers.collapsed(chain, keep)


FAULTS = {
    "global random state": shared_generator,
    "same seed, same draws": own_generator,
    "goes on from its state": forgetful,
    "inputs": writes_the_mask,
    "traces are those of the assignments": wrong_joint,
    "tiles = whole table": differs_when_tiled,
}


@pytest.mark.parametrize(("name", "sampler"), FAULTS.items(), ids=FAULTS.keys())
def test_each_rule_is_noticed_when_it_is_broken(name: str, sampler) -> None:
    report = check_sampler(sampler, sweeps=1000, starts=200)
    assert report[name].passed is False, str(report)


def test_a_wrong_number_of_candidates_in_use_is_noticed() -> None:
    report = check_sampler(wrong_count, sweeps=1000, starts=200)
    told = report["traces are those of the assignments"]
    assert told.passed is False
    assert "n_active" in told.measured


class Powered:
    """A table whose likelihood is raised to a power."""

    def __init__(self, table, power: float) -> None:
        self.table, self.dense = table, power * table.dense
        likelihood = np.exp(self.dense)
        self.relative = likelihood / (likelihood @ np.exp(table.log_prior))[:, None]

    def __getattr__(self, name: str):
        return getattr(self.table, name)


def powered(chain: Chain, keep):
    return samplers.collapsed(replace(chain, table=Powered(chain.table, 0.8)), keep)


def stays(chain: Chain, keep):
    """A right kernel that never moves: invariant, but no sampler."""
    stretch = samplers.collapsed(chain, keep)
    if chain.state is None:
        return stretch
    theta = chain.state["theta"]
    return replace(stretch, state=dict(chain.state), assignments=np.tile(theta, (int(keep.sum()), 1)))


def test_a_likelihood_to_the_power_of_0_8_is_noticed() -> None:
    report = check_sampler(powered, sweeps=100_000, starts=20_000)
    assert report["one sweep from exact draws, generic table"].passed is False
    assert report["long run, peaked table"].passed is False


def test_one_sweep_that_leaves_the_posterior_alone_passes_that_check() -> None:
    assert check_sampler(stays, **SHORT)["one sweep from exact draws, generic table"].passed


def renamed(chain: Chain, keep):
    state = None if chain.state is None else {"theta": chain.state["mine"]}
    stretch = samplers.collapsed(replace(chain, state=state), keep)
    return replace(stretch, state={"mine": stretch.state["theta"]})


def test_another_state_needs_a_beginning() -> None:
    report = check_sampler(renamed, sweeps=1000, starts=200)
    assert report["one sweep from exact draws, peaked table"].passed is None
    assert "begin=" in str(report)
    assert report.passed
    told = check_sampler(renamed, sweeps=1000, starts=200, begin=lambda theta, _: {"mine": theta.astype(np.int32)})
    assert told["one sweep from exact draws, peaked table"].passed


def raises(chain: Chain, keep):
    raise RuntimeError("out of luck")


def test_a_sampler_that_raises_is_reported_not_raised() -> None:
    report = check_sampler(raises, sweeps=1000, starts=200)
    assert len(report.failures) == 12
    assert "RuntimeError: out of luck" in str(report)


def test_the_report_is_frozen_and_prints_a_line_for_each_check() -> None:
    report = check_sampler(samplers.collapsed, sweeps=1000, starts=200)
    assert isinstance(report, Report)
    assert len(str(report).splitlines()) == 13
    assert "\n" not in repr(report)
    with pytest.raises(FrozenInstanceError):
        report.subject = "other"  # type: ignore[misc]


def test_what_cannot_be_called_is_refused() -> None:
    with pytest.raises(InputError, match="sampler"):
        check_sampler("collapsed")  # type: ignore[arg-type]
