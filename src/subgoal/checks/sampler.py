"""``check_sampler``: does a sampler draw from the posterior, and does it keep to what ``Sampler`` asks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import chi2

from subgoal.checks import conduct
from subgoal.checks.enumeration import TABLES, Enumerated, enumerated
from subgoal.checks.report import Check, Found, Report, tried
from subgoal.checks.starts import Begin, usual_begin
from subgoal.partition.protocol import Chain, Sampler
from subgoal.runtime.checks import Floats, positive, whole
from subgoal.runtime.errors import InputError

LEVEL = 3e-6
"""Chance that a right sampler fails the one-sweep checks, over all tables."""
RATIO = 3.0
WORTH = 10
"""Sweeps that are worth one independent draw."""
LEAST_EXPECTED = 5.0


def check_sampler(
    sampler: Sampler, *, begin: Begin | None = None, concentration: float = 1.0, sweeps: int = 100_000,
    starts: int = 20_000, seed: int = 0,
) -> Report:  # fmt: skip
    """Hold a sampler of the exchangeable posterior against enumeration and against what ``Sampler`` asks.

    Parameters
    ----------
    sampler:
        As passed to ``subgoal.sample``.
    begin:
        (θ, generator) -> a state of the sampler at assignment θ (N,), with whatever else it holds drawn from its law
        given θ. Not needed where the state is ``theta``, or ``label`` and ``dish``, or ``theta`` and ``hotter``.
    concentration:
        η.
    sweeps:
        Length of the run on each of three tables of 4 × 3. Its total variation from the posterior must be at most 3
        times that of a tenth as many independent draws, so a right sampler that hardly moves fails too.
    starts:
        Exact draws from which one sweep is made; a chi-square test, level 3e-6 over the tables.
    seed:
        Of everything; the same seed gives the same report.

    Returns a ``Report``; a check that fails, or a sampler that raises, is in it. Raises ``InputError`` only for
    arguments that are none.
    """
    if not callable(sampler):
        raise InputError("sampler", found=repr(sampler), wanted="a function of a chain and a mask of sweeps to keep")
    sweeps, starts = whole("sweeps", sweeps, least=100), whole("starts", starts, least=100)
    eta = positive("concentration", concentration)
    laws = {name: enumerated(table, eta) for name, table in TABLES.items()}
    checks = [_long_run(sampler, name, law, sweeps, seed) for name, law in laws.items()]
    checks += [_one_sweep(sampler, name, law, begin, starts, seed) for name, law in laws.items()]
    rules: list[tuple[str, str, Callable[[Sampler, int], Found]]] = [
        ("traces are those of the assignments", f"{conduct.ROUNDING:g}", conduct.traces),
        ("same seed, same draws", "no difference", conduct.repeats),
        ("goes on from its state", "no difference", conduct.resumes),
        ("global random state", "untouched", conduct.global_state),
        ("inputs", "not written", conduct.inputs),
        ("tiles = whole table", "no difference, or InputError", conduct.tiles),
    ]
    checks += [tried(name, allowed, lambda rule=rule: rule(sampler, seed)) for name, allowed, rule in rules]  # type: ignore[misc]
    return Report(getattr(sampler, "__name__", repr(sampler)), tuple(checks))


def _long_run(sampler: Sampler, name: str, law: Enumerated, sweeps: int, seed: int) -> Check:
    count = sweeps // WORTH
    independent = np.random.default_rng(8).multinomial(count, law.probability, size=200) / count
    allowed = RATIO * float(np.abs(independent - law.probability).sum(axis=1).mean() / 2)

    def measure() -> Found:
        chain = Chain(law.likelihood, law.concentration, np.random.default_rng(seed))
        reached = law.tally(sampler(chain, np.ones(sweeps, bool)).assignments) / sweeps
        distance = float(np.abs(reached - law.probability).sum() / 2)
        return distance <= allowed, f"total variation {distance:.4f} after {sweeps:,} sweeps"

    return tried(f"long run, {name} table", f"{allowed:.4f}", measure)


def _one_sweep(sampler: Sampler, name: str, law: Enumerated, begin: Begin | None, starts: int, seed: int) -> Check:
    level = LEVEL / len(TABLES)

    def measure() -> Found:
        generator, keep = np.random.default_rng([seed, 1]), np.ones(1, bool)
        probe = sampler(Chain(law.likelihood, law.concentration, np.random.default_rng(seed)), keep)
        start = begin or usual_begin(sampler, frozenset(probe.state), law)
        if start is None:
            return None, f"not run: a state of {', '.join(probe.state)}; give begin="
        after = [
            sampler(Chain(law.likelihood, law.concentration, generator, start(theta, generator)), keep).assignments[0]
            for theta in law.drawn(starts, generator)
        ]
        p = chi_square(law.tally(np.array(after)), starts * law.probability)
        return p >= level, f"p = {p:.2g} after {starts:,} single sweeps"

    return tried(f"one sweep from exact draws, {name} table", f"p >= {level:g}", measure)


def chi_square(observed: Any, expected: Floats) -> float:
    """p-value, with the cells of which fewer than 5 are expected taken together."""
    few = expected < LEAST_EXPECTED
    seen, wanted = np.asarray(observed, float)[~few], expected[~few]
    if few.any():
        seen, wanted = np.append(seen, np.asarray(observed)[few].sum()), np.append(wanted, expected[few].sum())
    return float(chi2.sf(((seen - wanted) ** 2 / wanted).sum(), max(seen.size - 1, 1)))
