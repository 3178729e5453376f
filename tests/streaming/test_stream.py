"""What a stream says: the batch's subgoals, the same for the same seed, whole posteriors, nothing before it moves."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.demonstrations.records import Demonstrations
from subgoal.streaming import Stream, warm
from subgoal.streaming.chains import KEPT, ROUNDS
from tests.streaming.made import tell, uneven

pytestmark = pytest.mark.filterwarnings("ignore:NOT CONVERGED")


def hand_held(seed: int, rounds: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Round a square of 1.5 m at 0.4 m/s, corners rounded over 8 cm, trembling 5 mm at 8 to 12 Hz, 100 a second."""
    from scipy.signal import butter, sosfiltfilt

    corners = 1.5 * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])[np.arange(4 * rounds + 1) % 4]
    way = [corners[0]]
    for before, corner, after in zip(corners[:-2], corners[1:-1], corners[2:], strict=True):
        a, b = (corner + 0.08 * (each - corner) / 1.5 for each in (before, after))
        s = np.linspace(0, 1, 30)[:, None]
        way += list((1 - s) ** 2 * a + 2 * s * (1 - s) * corner + s**2 * b)
    way = np.array([*way, corners[-1]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    at = np.arange(0, length[-1], 0.004)
    places = np.stack([np.interp(at, length, column) for column in way.T], axis=1)
    shaken = np.random.default_rng(seed).normal(size=places.shape)
    shaken = sosfiltfilt(butter(2, (8, 12), "bandpass", fs=100, output="sos"), shaken, axis=0)
    return np.arange(len(at)) / 100, places + 0.005 * shaken / shaken.std(axis=0)


def batch(stream: Stream) -> subgoal.Posterior:
    table = subgoal.action_comparison(stream.demonstrations(), stream.candidates(), confidence=stream.confidence)
    return subgoal.sample(table, concentration=stream.concentration, draws=400, warmup=400, thin=5)


@pytest.mark.parametrize("seed", [0, 1])
def test_round_the_square_it_finds_the_four_corners_that_the_batch_finds(seed: int) -> None:
    stream = tell(Stream(2, radius=0.05), hand_held(seed))
    wanted = subgoal.subgoals(batch(stream))
    for found in (stream.subgoals(), subgoal.subgoals(stream.posterior())):
        assert found.n_subgoals == wanted.n_subgoals == 4
        for corner in 1.5 * np.array([[0, 0], [1, 0], [1, 1], [0, 1]]):
            near = [min(np.linalg.norm(item.position - corner) for item in each) for each in (found, wanted)]
            assert max(near) < 0.12
        for item, other in zip(_ordered(found), _ordered(wanted), strict=True):
            assert np.linalg.norm(item.position - other.position) < 0.1
            assert abs(item.share - other.share) < 0.03


def _ordered(found: subgoal.subgoals) -> list:
    """Those that count, from the lower left round."""
    return sorted(list(found)[: found.n_subgoals], key=lambda item: np.arctan2(*(item.position - 0.75)))


def test_while_it_goes_on_it_finds_the_corners_passed_so_far() -> None:
    times, places = hand_held(0)
    stream = Stream(2, radius=0.05)
    passed = []
    for k, (time, place) in enumerate(zip(times, places, strict=True)):
        stream.add(time, place)
        if (k + 1) % (len(times) // 4) == 0:
            passed.append(1.5 * np.array([[0, 1, 1, 0], [0, 0, 1, 1]]).T[(len(passed) + 1) % 4])
            at = [item.position for item in stream.subgoals()]
            assert all(min(np.linalg.norm(place - corner) for place in at) < 0.15 for corner in passed)
    assert len(passed) == 4


def test_shares_agree_with_the_batch_candidate_by_candidate() -> None:
    stream = tell(Stream(2, radius=0.3, confidence=2.0, concentration=2.0), uneven(0), uneven(1))
    found, wanted = stream.posterior(2000), batch(stream)
    np.testing.assert_allclose(found.shares.toarray(), wanted.shares.toarray(), atol=0.06)
    np.testing.assert_allclose(found.expected_shares, wanted.expected_shares, atol=0.015)
    errors = [each.log_joint.std() / each.diagnostics["log joint"].ess_bulk ** 0.5 for each in (found, wanted)]
    assert found.log_joint.mean() == pytest.approx(wanted.log_joint.mean(), abs=4 * np.hypot(*errors))
    assert found.settings.likelihood == wanted.settings.likelihood
    assert found.settings.data == wanted.settings.data


def test_the_same_in_the_same_order_gives_the_same() -> None:
    first, again, other = (tell(Stream(2, radius=0.3, seed=seed), uneven(0), uneven(1)) for seed in (1, 1, 2))
    for each in (first, again, other):
        each.rejuvenate(3)
    np.testing.assert_array_equal(first.posterior(20).assignments, again.posterior(20).assignments)
    np.testing.assert_array_equal(first._chains.latest, again._chains.latest)
    assert not np.array_equal(first._chains.latest, other._chains.latest)


def test_chains_differ() -> None:
    stream = tell(Stream(2, radius=0.3, chains=3), uneven(0))
    a, b, c = stream._chains.latest
    assert not np.array_equal(a, b)
    assert not np.array_equal(b, c)


def test_looking_changes_nothing() -> None:
    seen, unseen = Stream(2, radius=0.3), Stream(2, radius=0.3)
    for time, place in zip(*uneven(0), strict=True):
        if seen.add(time, place) and seen.n_pairs > 3:
            seen.segments(seen.subgoals())
            seen.demonstrations(), seen.candidates(), seen.likelihood(), repr(seen)
        unseen.add(time, place)
    np.testing.assert_array_equal(seen._chains.latest, unseen._chains.latest)


def test_draws_of_late_hold_every_pair_and_only_candidates_there_are() -> None:
    stream = Stream(2, radius=0.2, chains=2)
    for time, place in zip(*uneven(0), strict=True):
        if stream.add(time, place):
            latest = stream._chains.latest
            drawn = ROUNDS * stream.n_pairs
            assert latest.shape == (2, min(drawn, KEPT), stream.n_pairs)
            assert latest.max() < stream.candidates().n_candidates
            newest = (drawn - 1 - np.arange(ROUNDS)) % KEPT
            np.testing.assert_array_equal(latest[:, newest[0]], stream._chains.theta)
            older = np.setdiff1d(np.arange(latest.shape[1]), newest)
            assert (latest[:, older, -1] == latest[:, newest[-1:], -1]).all()


def test_shares_of_late_are_those_of_the_draws() -> None:
    stream = tell(Stream(2, radius=0.05), uneven(0))
    posterior, latest = stream._of_late(), stream._chains.latest
    g_count = stream.candidates().n_candidates
    assert np.unique(latest).size < g_count
    wanted = (latest.reshape(-1, stream.n_pairs)[..., None] == np.arange(g_count)).mean(axis=0)
    np.testing.assert_allclose(posterior.shares.toarray(), wanted)
    np.testing.assert_allclose(posterior.expected_shares, wanted.mean(axis=0))
    assert sum(item.share for item in stream.subgoals().items) == pytest.approx(1, abs=0.05)


def test_segments_cover_every_pair() -> None:
    stream = tell(Stream(2, radius=0.3), uneven(0), uneven(1))
    found = stream.segments()
    assert [item.start for item in found][1:] == [item.stop for item in found][:-1]
    assert found.items[-1].stop == stream.n_pairs == found.labels.size
    assert {item.trajectory for item in found} == {0, 1}


def test_another_confidence_and_concentration_count_at_once() -> None:
    stream = tell(Stream(2, radius=0.3), uneven(0))
    before = np.unique(stream._chains.latest[0]).size
    stream.retune(concentration=200.0)
    assert stream.concentration == 200.0
    assert stream._chains.latest.shape[1] == KEPT
    assert np.unique(stream._chains.latest[0]).size > before
    stream.retune(confidence=8.0)
    assert (stream.confidence, stream.concentration) == (8.0, 200.0)
    assert stream.posterior(8).settings.confidence == 8.0


def test_a_posterior_is_a_whole_one(tmp_path: Path) -> None:
    stream = tell(Stream(names=("x", "y"), radius=0.3, units="m"), uneven(0))
    posterior = stream.posterior(300, warmup=7, thin=3)
    assert posterior.assignments.shape == (4, 300, stream.n_pairs)
    assert (posterior.settings.draws, posterior.settings.warmup, posterior.settings.thin) == (300, 7, 3)
    assert posterior.traces["n_active"].shape == (4, 907)
    assert np.isfinite(posterior.log_joint).all()
    subgoal.save(posterior, tmp_path / "posterior.npz")
    again = subgoal.load(tmp_path / "posterior.npz")
    np.testing.assert_array_equal(again.assignments, posterior.assignments)
    assert subgoal.subgoals(again).n_subgoals == subgoal.subgoals(posterior).n_subgoals
    assert again.demonstrations.units == "m"
    subgoal.report(posterior, tmp_path / "report.html")
    assert (tmp_path / "report.html").stat().st_size > 100_000


def test_what_did_not_converge_says_so() -> None:
    stream = tell(Stream(2, radius=0.3), uneven(0))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        posterior = stream.posterior(5)
    assert posterior.status is subgoal.Status.NOT_CONVERGED
    assert [each.category.__name__ for each in told] == ["ConvergenceWarning"]


def test_chains_go_on_from_the_posterior_that_was_asked_for() -> None:
    stream = tell(Stream(2, radius=0.3), uneven(0))
    posterior = stream.posterior(12)
    np.testing.assert_array_equal(stream._chains.theta, posterior.assignments[:, -1])


def test_before_anything_moves_there_are_no_subgoals() -> None:
    stream = Stream(2, radius=0.3, rate=None)
    assert len(stream.subgoals()) == stream.subgoals().n_subgoals == 0
    assert len(stream.segments()) == 0
    stream.rejuvenate()
    stream.retune(confidence=2.0)
    for k in range(4):
        stream.add(k, [1.0, 1.0])
    assert stream.n_pairs == 3
    assert len(stream.subgoals()) == 0
    assert stream.subgoals().group.tolist() == [-1]
    assert stream.segments().labels.tolist() == [-1, -1, -1]
    assert isinstance(stream.demonstrations(), Demonstrations)
    stream.rejuvenate()
    stream.add(4, [2.0, 1.0])
    assert len(stream.subgoals()) > 0


def test_it_prints_as_one_line() -> None:
    stream = tell(Stream(names=("x", "y"), radius=5.0, rate=None), uneven(0))
    assert repr(stream) == "Stream(330 pairs of (x, y), 2 candidates, 4 chains)"


def test_warming_loads_the_loops() -> None:
    from subgoal._kernels.streaming import move_table, redraw_some

    warm()
    for loop in (move_table, redraw_some):
        assert not hasattr(loop, "signatures") or loop.signatures
