"""Small streams against the enumerated posterior: in the middle, after lifting, after retuning, with new candidates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from subgoal.streaming import Stream
from tests.oracles.tables import assignment_posterior

pytestmark = pytest.mark.filterwarnings("ignore:NOT CONVERGED")
ETA = 0.8
DRAWS, THIN = 10_000, 2
WAYS = [[(0, 0), (1, 0.1), (2, 0), (2.1, 1.2)], [(0.5, 0.9), (1, 1.3)]]
"""Two trajectories of 6 pairs, and 4 candidates at radius 1.3: two visited, two ends."""
CHAINS = 6000


def small(**options: object) -> Stream:
    return Stream(2, radius=1.3, rate=None, concentration=ETA, confidence=2.5, **options)


def law_of(stream: Stream, eta: float | None = None) -> dict[tuple[int, ...], float]:
    """p(θ | O) over all assignments of the pairs so far."""
    table = stream.likelihood()
    return assignment_posterior(table.dense, stream.concentration if eta is None else eta, np.exp(table.log_prior))


def distance(draws: np.ndarray, law: dict[tuple[int, ...], float]) -> float:
    """Total variation of draws (S, N) from a law."""
    place = {theta: k for k, theta in enumerate(law)}
    reached = np.bincount([place[tuple(theta)] for theta in draws.tolist()], minlength=len(law)) / len(draws)
    return float(np.abs(reached - list(law.values())).sum() / 2)


def bound(law: dict[tuple[int, ...], float], draws: int) -> float:
    """What the expected total variation of half as many independent draws is at most: ½ Σ min(√(p(1 − p)/S), 2p)."""
    p = np.array(list(law.values()))
    return float(np.minimum(np.sqrt(p * (1 - p) / (draws / 2)), 2 * p).sum() / 2)


def moments(stream: Stream) -> Iterator[str]:
    """The stream after each sample that gave a pair, after each end, and after other settings."""
    for k, way in enumerate(WAYS):
        for time, place in enumerate(way):
            if stream.add(time, place) and stream.n_pairs > 1:
                yield f"pair {stream.n_pairs}"
        stream.lift()
        yield f"lift {k + 1}"
    stream.retune(confidence=1.0)
    yield "confidence"
    stream.retune(concentration=4.0)
    yield "concentration"


def test_the_posterior_of_a_stream_is_the_enumerated_one_at_every_moment() -> None:
    stream = small()
    seen = []
    for moment in moments(stream):
        draws = stream.posterior(DRAWS, warmup=20, thin=THIN).assignments
        law = law_of(stream)
        assert distance(draws.reshape(-1, stream.n_pairs), law) <= bound(law, 4 * DRAWS), moment
        seen.append((moment, stream.n_pairs, stream.candidates().n_candidates))
    assert [each[1:] for each in seen] == [(2, 1), (3, 2), (4, 3), (5, 3), (6, 4), (6, 4), (6, 4)]


def test_draws_of_another_law_are_noticed() -> None:
    """That the bound above is a bound of something: the same draws against the law of another concentration."""
    stream = small()
    for moment in moments(stream):
        if moment == "lift 2":
            break
    draws = stream.posterior(DRAWS, warmup=20, thin=THIN).assignments.reshape(-1, stream.n_pairs)
    law = law_of(stream, 3.0)
    assert distance(draws, law) > 3 * bound(law, len(draws))


def test_chains_are_near_the_posterior_without_a_sweep_of_their_own() -> None:
    """Where 6,000 chains stand after each pair: redrawing some old pairs, and a few moves, keeps up at this size."""
    stream = small(chains=CHAINS)
    for moment in moments(stream):
        law = law_of(stream)
        theta = stream._chains.theta
        assert distance(theta, law) <= bound(law, CHAINS), moment


def test_draws_of_late_are_of_the_posterior() -> None:
    """16 of each of 1,000 chains, after sweeps that replace all of them."""
    stream = small(chains=1000)
    for _ in moments(stream):
        pass
    stream.rejuvenate(40)
    latest = stream._chains.latest
    law = law_of(stream)
    assert distance(latest.reshape(-1, stream.n_pairs), law) <= bound(law, latest[..., 0].size)
