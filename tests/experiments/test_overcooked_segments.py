"""Matching against brute force, what is found in a made game, and the ways to cut a game against counts by hand."""

from __future__ import annotations

import itertools
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hmmlearn.hmm import CategoricalHMM

from experiments import overcooked_rivals as rivals
from experiments import overcooked_segments as segments
from experiments.change_points import Tally, by_game, cut_points, gap_interval, interval, matched, tally, total
from experiments.common import Options, find_data
from experiments.overcooked_sides import Side, ends_of_segments, side
from experiments.overcooked_world import INTERACT, read_games, read_kitchens
from tests.experiments.test_overcooked import folder

__all__ = ["folder"]
TINY: dict[str, Any] = {"draws": 30, "warmup": 60, "thin": 1, "chains": 2, "workers": 1}


def most_pairs(found: np.ndarray, true: np.ndarray, tolerance: float) -> int:
    """Every way to give each found point one true point or none."""
    if not len(found):
        return 0
    rest = most_pairs(found[1:], true, tolerance)
    near = [k for k in range(len(true)) if abs(found[0] - true[k]) <= tolerance]
    return max([rest, *(1 + most_pairs(found[1:], np.delete(true, k), tolerance) for k in near)])


def test_matching_is_the_largest_of_all_one_to_one_matchings() -> None:
    rng = np.random.default_rng(3)
    for _ in range(400):
        found, true = (np.sort(rng.integers(0, 14, rng.integers(0, 6))).astype(float) for _ in range(2))
        for tolerance in (0.0, 1.0, 3.0):
            assert matched(found, true, tolerance) == most_pairs(found, true, tolerance), (found, true, tolerance)


def test_scores_by_hand() -> None:
    one = tally(np.array([1.0, 2.0, 9.0]), np.array([1.0, 5.0]), 3.0)
    assert one == Tally(2, 3, 2)
    assert (one.f_score, one.precision, one.recall) == (4 / 5, 2 / 3, 1.0)
    assert total([one, Tally(0, 0, 2)]).f_score == 4 / 7
    assert tally(np.array([1.0, 1.0]), np.array([1.0]), 3.0).matched == 1
    assert Tally(0, 0, 0).f_score == 1


def test_interval_resamples_games_as_wholes() -> None:
    """Two games, one with all found by both cooks and one with nothing: F is 0, 1/2 or 1 with chances 1/4, 1/2, 1/4."""
    tallies, game = [Tally(5, 5, 5), Tally(0, 5, 5), Tally(5, 5, 5), Tally(0, 5, 5)], ["a", "b", "a", "b"]
    assert by_game(tallies, game).tolist() == [[10, 10, 10], [0, 10, 10]]
    assert interval(tallies, game, 0) == (0.0, 1.0)
    assert interval(tallies, ["a", "a", "b", "b"], 0) == (0.5, 0.5)
    assert gap_interval(tallies, tallies, game, 0) == (0.0, 0.0)


def test_all_above_or_the_highest_alone() -> None:
    strength = np.array([0.9, 0.2, 0.5, 0.6, 0.6, 0.6, 0.1, 0.7])
    assert cut_points(strength, 0.5, only_peaks=False).tolist() == [0, 2, 3, 4, 5, 7]
    assert cut_points(strength, 0.5, only_peaks=True).tolist() == [0, 4, 7]
    assert cut_points(strength, 0.65, only_peaks=True).tolist() == [0, 7]


def test_a_segment_ends_with_the_last_row_up_to_a_use() -> None:
    times = np.array([2.0, 5.0, 6.0, 9.0, 12.0])
    assert ends_of_segments(times, np.array([1.0, 5.0, 7.0, 8.0, 12.0, 20.0])).tolist() == [5, 6]
    assert ends_of_segments(times, np.array([])).tolist() == []


def made_side(folder: Path, hidden: bool, split: str = "train") -> Side:
    maps, table = read_kitchens(folder), read_games(folder, (segments.SCORED,))
    return side(maps, table, 1, split, hidden)


def test_true_change_points_are_the_uses_of_the_recording(folder: Path) -> None:
    table = read_games(folder, (segments.SCORED,))
    seen, hidden = made_side(folder, False), made_side(folder, True)
    assert len(seen.games) == len(seen.true) == len(seen.names) == 2
    for k, worker in enumerate((0, 1)):
        rows = table[(table["worker"] == worker) & (table["player"] == 1)]
        used = rows["t"].to_numpy(float)[(rows["event"] != "").to_numpy()]
        assert len(used) == 36
        assert seen.true[k].tolist() == used[:-1].tolist()
        moves = hidden.times[hidden.games[k]]
        assert hidden.true[k].tolist() == [moves[moves < use].max() for use in used[:-1] if use > moves[0]]
    assert not (hidden.actions == INTERACT).any()
    assert hidden.times.size == seen.times.size - (seen.actions == INTERACT).sum()


@pytest.mark.parametrize("model", list(segments.MODELS))
def test_boundaries_of_a_made_game_are_where_tiles_were_used(folder: Path, model: str) -> None:
    """Without presses, to the very step, two of three legs at least; learned transitions cut legs in two."""
    each = made_side(folder, True)
    points = segments.model_points(
        each, {"gamma": 0.9, "alpha": 30.0, "least": 0.5, "only_peaks": False}, model, tuple(TINY.items()), 0
    )
    found = total(segments.tallies([points], [each], 0.0))
    assert found.precision > (0.7 if "transitions" in model else 0.95)
    assert found.recall > 0.6


def test_everything_is_chosen_in_training_games_and_scored_in_test_games(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segments, "SHORT", TINY)
    monkeypatch.setattr(segments, "LEAST", (0.25, 0.5, 0.75))
    asked: list[list[int]] = []
    kept = segments.chosen

    def chosen(method: segments.Method, train: list[Side]) -> Any:
        asked.append([len(each.true) for each in train])
        return kept(method, train)

    monkeypatch.setattr(segments, "chosen", chosen)
    headline, figure = segments.experiment(Options(out=folder, quick=True, data=folder))
    assert asked == [[2, 2]] * (10 + 9)
    for keys in segments.KEYS:
        row = headline[keys]
        assert row["games"] == 1
        for name, each in row["methods"].items():
            assert each["low"] <= each["f_score"] <= each["high"], name
        assert set(row["gaps"]) == {
            f"{row['best_model_in_training']} over {name}" for name in row["methods"] if name not in segments.MODELS
        }
    assert headline["interact seen"]["methods"][segments.PRESSES]["f_score"] == 1
    assert segments.PRESSES not in headline["interact hidden"]["methods"]
    assert headline["interact seen"]["methods"]["subgoals that persist"]["f_score"] > 0.9
    assert len(figure.axes) == 4


def test_the_best_setting_wins() -> None:
    made: Any = [type("Made", (), {"true": (np.array([10.0, 20.0]),)})()]
    shifts = segments.settings(shift=(9.0, 2.0, 5.0))
    method = segments.Method(lambda each, setting: [each.true[0] + setting["shift"]], shifts)
    assert segments.chosen(method, made) == ({"shift": 2.0}, 1.0)


def test_change_probability_of_a_hidden_markov_model_is_a_sum_over_paths() -> None:
    model = CategoricalHMM(3)
    model.startprob_ = np.array([0.5, 0.3, 0.2])
    model.transmat_ = np.array([[0.8, 0.2, 0.0], [0.1, 0.7, 0.2], [0.3, 0.3, 0.4]])
    model.emissionprob_ = np.array([[0.7, 0.2, 0.1], [0.1, 0.1, 0.8], [0.3, 0.4, 0.3]])
    symbol = np.array([0, 2, 1, 1, 0])
    weight, changes = 0.0, np.zeros(4)
    for path in itertools.product(range(3), repeat=5):
        chance = model.startprob_[path[0]] * model.emissionprob_[path[0], symbol[0]]
        for t in range(1, 5):
            chance *= model.transmat_[path[t - 1], path[t]] * model.emissionprob_[path[t], symbol[t]]
        weight += chance
        changes += chance * (np.diff(path) != 0)
    np.testing.assert_allclose(rivals.two_slice_changes(model, symbol), changes / weight, atol=1e-12)


def test_trivial_rules_by_hand(folder: Path) -> None:
    each = made_side(folder, False)
    rows = each.games[0]
    times, actions, cells = each.times[rows], each.actions[rows], each.states[rows] // 4
    assert rivals.presses(each, {})[0].tolist() == [
        t for t, a in zip(times[:-1], actions[:-1], strict=True) if a == INTERACT
    ]
    assert rivals.turns(each, {})[0].tolist() == [
        times[k] for k in range(times.size - 1) if cells[k + 1] == cells[k] and actions[k] != INTERACT
    ]
    assert rivals.even_rows(each, {"gap": 4.0})[0].tolist() == times[2:-1:4].tolist()
    late: Any = SimpleNamespace(games=[slice(0, 3)], times=np.array([5.0, 6.0, 17.0]))
    assert rivals.even_times(late, {"gap": 4.0})[0].tolist() == [7, 11, 15]


def test_kernel_change_points_are_the_last_rows_before_a_change(folder: Path) -> None:
    """With next to no penalty every row that differs from the next in what is seen ends a segment."""
    each = made_side(folder, False)
    found = rivals.kernel_points(each, {"kernel": "linear", "penalty": 1e-9})
    for points, rows in zip(found, each.games, strict=True):
        seen = rivals.features(each, rows)
        assert points.tolist() == each.times[rows][:-1][(np.diff(seen, axis=0) != 0).any(axis=1)].tolist()


def test_recorded_games_have_all_their_uses() -> None:
    found, reason = find_data("overcooked_human", None)
    if found is None:
        pytest.skip(str(reason))
    maps, table = read_kitchens(found), read_games(found, (segments.SCORED,))
    for player, split, hidden, uses, games in (
        (0, "train", False, 1437, 9),
        (1, "train", False, 803, 9),
        (0, "test", True, 1305, 8),
        (1, "test", True, 719, 8),
    ):
        each = side(maps, table, player, split, hidden)
        assert (sum(map(len, each.true)), len(set(each.names))) == (uses, games)
