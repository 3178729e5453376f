"""Change points against true ones: one-to-one matching within a tolerance, F-score, and its interval over games."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.signal import find_peaks

from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

RESAMPLES, STREAM = 10_000, 301


class Tally(NamedTuple):
    """Change points of some games: true ones, found ones, and pairs of the two."""

    matched: int
    found: int
    true: int

    @property
    def f_score(self) -> float:
        """2·matched / (found + true); one where there are none of either."""
        return 2 * self.matched / (self.found + self.true) if self.found + self.true else 1.0

    @property
    def precision(self) -> float:
        """matched / found; one where none is found."""
        return self.matched / self.found if self.found else 1.0

    @property
    def recall(self) -> float:
        """matched / true; one where there is none."""
        return self.matched / self.true if self.true else 1.0


def matched(found: Floats, true: Floats, tolerance: float) -> int:
    """Most pairs (f, t), each point in one pair at most, with |f − t| ≤ ``tolerance``; both sorted.

    The earliest two points left are paired if they are near; if not, the earlier one has no partner. With one
    tolerance for all this is a maximum matching.
    """
    pairs = i = j = 0
    while i < len(found) and j < len(true):
        if abs(found[i] - true[j]) <= tolerance:
            pairs, i, j = pairs + 1, i + 1, j + 1
        elif found[i] < true[j]:
            i += 1
        else:
            j += 1
    return pairs


def tally(found: Floats, true: Floats, tolerance: float) -> Tally:
    """One game."""
    return Tally(matched(found, true, tolerance), len(found), len(true))


def total(tallies: Sequence[Tally]) -> Tally:
    """All games together."""
    return Tally(*(int(column) for column in np.sum(tallies, axis=0)))


def interval(tallies: Sequence[Tally], game: Sequence[object], seed: int) -> tuple[float, float]:
    """95 % interval of the F-score of all games together, resampling games: tallies of one game go together."""
    sums = by_game(tallies, game)
    low, high = np.quantile(f_scores(resampled(sums, seed)), [0.025, 0.975])
    return float(low), float(high)


def gap_interval(
    first: Sequence[Tally], second: Sequence[Tally], game: Sequence[object], seed: int
) -> tuple[float, float]:
    """95 % interval of the difference of two F-scores, both from the same resampled games."""
    gaps = f_scores(resampled(by_game(first, game), seed)) - f_scores(resampled(by_game(second, game), seed))
    low, high = np.quantile(gaps, [0.025, 0.975])
    return float(low), float(high)


def by_game(tallies: Sequence[Tally], game: Sequence[object]) -> Floats:
    """(games, 3) sums over the tallies of each game, games in the order in which they come."""
    order = {name: k for k, name in enumerate(dict.fromkeys(game))}
    sums = np.zeros((len(order), 3))
    np.add.at(sums, [order[name] for name in game], np.array(tallies, float))
    return sums


def resampled(sums: Floats, seed: int) -> Floats:
    """(resamples, 3) totals of as many games, drawn with replacement."""
    pick = stream(seed, STREAM).integers(0, len(sums), (RESAMPLES, len(sums)))
    return np.asarray(sums[pick].sum(axis=1))


def f_scores(totals: Floats) -> Floats:
    """(resamples,) F-scores."""
    return np.asarray(2 * totals[:, 0] / (totals[:, 1] + totals[:, 2]))


def cut_points(strength: Floats, least: float, only_peaks: bool) -> Ints:
    """Positions of at least ``least``: all, or only local maxima (ends included; of a level stretch the middle)."""
    if not only_peaks:
        return np.flatnonzero(strength >= least)
    return np.asarray(find_peaks(np.concatenate([[-1.0], strength, [-1.0]]), height=least)[0] - 1)
