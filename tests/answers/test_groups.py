"""Shares of groups from hand-made draws, and groups from names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.answers.groups import group_shares
from subgoal.candidates import Candidates
from subgoal.demonstrations.groups import groups_by_name
from subgoal.demonstrations.records import Demonstrations
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError
from tests.answers.made import posterior_of

PLACES = Candidates(np.array([[0.0], [1.0], [50.0]]), radius=1.0)
"""The first two are one subgoal."""
OFFSET = [0, 4, 6, 10]
DRAWS = np.array(
    [
        [0, 1, 2, 2, 0, 0, 2, 2, 2, 2],
        [1, 1, 1, 2, 1, 1, 2, 2, 2, 0],
        [0, 0, 0, 0, 0, 0, 2, 2, 0, 0],
        [0, 0, 2, 2, 1, 0, 0, 1, 0, 1],
    ]
)


def test_shares_and_differences_by_hand() -> None:
    """Groups: the first two trajectories (6 observations) and the last (4)."""
    posterior = posterior_of(DRAWS, PLACES, chains=2, offset=OFFSET)
    found = group_shares(posterior, [0, 0, 1])
    near = np.array([[4, 5, 6, 4], [0, 1, 2, 4]]).T / [6, 4]
    far = np.array([[2, 1, 0, 2], [4, 3, 2, 0]]).T / [6, 4]
    assert [item.members.tolist() for item in found.subgoals.listed] == [[0, 1], [2]]
    assert found.sizes.tolist() == [6, 4]
    assert found.per_draw.shape == (2, 2, 2, 2)
    assert np.allclose(found.per_draw.reshape(4, 2, 2), np.stack([near, far], axis=2), atol=1e-15)
    assert np.allclose(found.share, [[near[:, k].mean(), far[:, k].mean()] for k in (0, 1)], atol=1e-15)
    assert np.allclose(found.interval[1, 0], np.quantile(near[:, 1], [0.05, 0.95]))
    assert found.pairs.tolist() == [[0, 1]]
    gap = near[:, 0] - near[:, 1]
    assert found.difference[0, 0] == pytest.approx(gap.mean())
    assert found.difference_interval[0, 0] == pytest.approx(np.quantile(gap, [0.05, 0.95]))
    assert found.larger.tolist() == [[0.75, 0.25]]
    assert repr(found) == "GroupShares(2 groups, 2 subgoals)"


def test_nothing_hangs_on_labels() -> None:
    """Exchanging two candidates of one subgoal in some draws changes nothing; equal shares count half."""
    posterior = posterior_of(DRAWS, PLACES, offset=OFFSET)
    other = DRAWS.copy()
    other[1:3] = np.array([1, 0, 2])[other[1:3]]
    found, again = (
        group_shares(posterior, [0, 1, 2]),
        group_shares(posterior_of(other, PLACES, offset=OFFSET), [0, 1, 2]),
    )
    assert np.array_equal(found.per_draw, again.per_draw)
    assert found.pairs.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert found.larger[0, 0] == 0.5 * 1 / 4


def test_background_and_unlisted_places_are_in_no_share() -> None:
    draws = np.repeat(np.array([[2] * 150 + [0] + [2] * 49]), 3, axis=0)
    places = Candidates(np.array([[50.0], [0.0], [1.0]]), radius=1.0)
    posterior = posterior_of(draws, places, offset=[0, 100, 200])
    hidden = np.array(posterior.assignments)
    hidden[:, :, :30] = -1
    found = group_shares(replace(posterior, assignments=hidden), [1, 0])
    assert found.share == pytest.approx(np.array([[0.99], [0.7]]))


def test_given_subgoals_are_used() -> None:
    posterior = posterior_of(DRAWS, PLACES, offset=OFFSET)
    apart = subgoal.subgoals(posterior, merge_radius=0.0)
    assert group_shares(posterior, [0, 0, 1], apart).share.shape == (2, 3)


def test_one_group_has_no_pairs() -> None:
    found = group_shares(posterior_of(DRAWS, PLACES, offset=OFFSET), [0, 0, 0])
    assert (found.pairs.shape, found.difference.shape, found.larger.shape) == ((0, 2), (0, 2), (0, 2))
    assert found.share[0] == pytest.approx([item.share for item in found.subgoals.listed])


def test_assignments_must_have_been_kept() -> None:
    posterior = replace(posterior_of(DRAWS, PLACES, offset=OFFSET), assignments=None)
    with pytest.raises(InputError, match="no assignments"):
        group_shares(posterior, [0, 0, 1])


@pytest.mark.parametrize("group", [[0, 1], [0.0, 1.0, 1.0], [0, -1, 1], [0, 2, 2], [0, 1, 9], "abc"])
def test_bad_groups_are_refused(group) -> None:
    with pytest.raises(InputError, match="group"):
        group_shares(posterior_of(DRAWS, PLACES, offset=OFFSET), group)


def named(*names: str) -> Demonstrations:
    count = len(names)
    return Demonstrations.from_arrays(np.zeros((count, 1)), np.ones((count, 1)), trajectory_names=names)


@pytest.mark.parametrize("of", [r"^(.*)_", r"^[a-z]+", lambda name: name.split("_")[0]])
def test_groups_by_name(of) -> None:
    number, names = groups_by_name(named("fox_1", "cat_1", "fox_2"), of)
    assert number.tolist() == [1, 0, 1]
    assert names == ("cat", "fox")


@pytest.mark.parametrize(("of", "message"), [("(", "regular"), (r"^f", "'cat_1'"), (lambda name: 3, "found 3")])
def test_names_without_a_group_are_refused(of, message: str) -> None:
    with pytest.raises(InputError, match=message):
        groups_by_name(named("fox_1", "cat_1"), of)


def with_groups(*names: str) -> Posterior:
    posterior = posterior_of(DRAWS, PLACES, offset=OFFSET)
    return replace(posterior, demonstrations=replace(posterior.demonstrations, groups=names))


def test_groups_of_the_demonstrations_are_the_default() -> None:
    found = group_shares(with_groups("fox", "fox", "cat"))
    wanted = group_shares(posterior_of(DRAWS, PLACES, offset=OFFSET), [1, 1, 0])
    assert found.names == ("cat", "fox")
    assert wanted.names == ("0", "1")
    assert np.array_equal(found.per_draw, wanted.per_draw)
    by_name = group_shares(posterior_of(DRAWS, PLACES, offset=OFFSET), ["fox", "fox", "cat"])
    assert by_name.names == ("cat", "fox")
    assert np.array_equal(found.per_draw, by_name.per_draw)


def test_without_groups_one_is_told_where_to_get_them() -> None:
    with pytest.raises(InputError, match="group='animal'"):
        group_shares(posterior_of(DRAWS, PLACES, offset=OFFSET))


def test_groups_are_saved_with_a_posterior(tmp_path: Path) -> None:
    back = subgoal.load(subgoal.save(with_groups("fox", "fox", "cat"), tmp_path / "p.npz"))
    assert back.demonstrations.groups == ("fox", "fox", "cat")


def test_printed_shares_and_differences() -> None:
    """By hand: the cat's share of the first subgoal is 0, 1, 2, 4 of its 4 observations, the fox's 4, 5, 6, 4 of 6."""
    found = group_shares(with_groups("fox", "fox", "cat"))
    lines = str(found).splitlines()
    assert len(lines) == 1 + 4 + 1 + 2
    gap = np.array([0 / 4 - 4 / 6, 1 / 4 - 5 / 6, 2 / 4 - 6 / 6, 4 / 4 - 4 / 6])
    low, high = np.quantile(gap, [0.05, 0.95])
    assert lines[1].split() == ["cat:", "subgoal", "1", "43.8", "[3.8,", "92.5]"]
    told = f"{100 * gap.mean():.1f} [{100 * low:.1f}, {100 * high:.1f}] (may be none)"
    assert " ".join(lines[6].split()) == f"cat − fox: subgoal 1 {told}"
    assert found.differs.tolist() == [[bool(low > 0 or high < 0)] * 2]


def test_a_difference_whose_interval_leaves_zero_out_is_told_as_sure() -> None:
    found = group_shares(posterior_of(np.array([[0, 0, 2, 2]] * 4), PLACES, offset=[0, 2, 4]), ["a", "b"])
    assert found.differs.tolist() == [[True, True]]
    assert "may be none" not in str(found)
