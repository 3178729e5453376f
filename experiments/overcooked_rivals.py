"""Other ways to cut a cook's game: kernel change points (``ruptures``), a hidden Markov model, and two trivial ones.

All see the same rows: position, facing and action of every step in which something was done.
"""

from __future__ import annotations

import logging
from functools import cache
from typing import Any

import numpy as np

from experiments.change_points import cut_points
from experiments.common import Headline
from experiments.overcooked_sides import Side
from experiments.overcooked_world import ACTIONS, INTERACT
from subgoal.runtime.checks import Floats, Ints

KERNELS, PENALTIES = ("linear", "rbf"), tuple(np.geomspace(0.03, 30.0, 19).tolist())
STATES = (2, 3, 4, 6, 8, 12, 16)
ITERATIONS = 100


def kernel_points(side: Side, setting: Headline) -> list[Floats]:
    """``ruptures.KernelCPD`` on each game: a change point is the last row before the change."""
    import ruptures

    found = []
    for rows in side.games:
        path = ruptures.KernelCPD(kernel=setting["kernel"], min_size=1).fit(features(side, rows))
        ends = path.predict(pen=setting["penalty"])[:-1]
        found.append(side.times[rows][np.array(ends, int) - 1])
    return found


def features(side: Side, rows: slice) -> Floats:
    """(n, 11) position in standard deviations, facing and action as indicators."""
    state, action = side.states[rows], side.actions[rows]
    places = side.places[rows]
    spread = np.where(places.std(axis=0) > 0, places.std(axis=0), 1.0)
    return np.hstack([(places - places.mean(axis=0)) / spread, np.eye(4)[state % 4], np.eye(len(ACTIONS))[action]])


def cut(side: Side, strength: Floats, setting: Headline) -> list[Floats]:
    """Where the probability of a boundary, (N,) with the last row of each game unused, is high enough."""
    return [
        side.times[rows][cut_points(strength[rows][:-1], setting["least"], setting["only_peaks"])]
        for rows in side.games
    ]


def hidden_markov_points(side: Side, setting: Headline, starts: int, seed: int) -> list[Floats]:
    """From P(z_t ≠ z_{t+1} | all rows of the game) of a ``hmmlearn.CategoricalHMM`` over (state, action)."""
    strength = change_probability(side, setting["states"], starts, seed)
    return cut(side, strength, setting)


@cache
def change_probability(side: Side, states: int, starts: int, seed: int) -> Floats:
    """(N,) P(z_t ≠ z_{t+1} | game), 0 at the last row of a game, of the start with the best fit."""
    from hmmlearn.hmm import CategoricalHMM

    logging.getLogger("hmmlearn").setLevel(logging.ERROR)
    symbol = side.states * len(ACTIONS) + side.actions
    sizes = [rows.stop - rows.start for rows in side.games]
    fits = [
        CategoricalHMM(states, n_iter=ITERATIONS, random_state=seed + k).fit(symbol[:, None], sizes)
        for k in range(starts)
    ]
    best = max(fits, key=lambda model: float(model.score(symbol[:, None], sizes)))
    changes = np.zeros(symbol.size)
    for rows in side.games:
        changes[rows][:-1] = two_slice_changes(best, symbol[rows])
    return changes


def two_slice_changes(model: Any, symbol: Ints) -> Floats:
    """(n − 1,) P(z_t ≠ z_{t+1} | all n symbols).

    With f_t(j) the filtered and s_t(j) the smoothed probability of state j and A the transitions,
    P(z_t = z_{t+1} = j | all) = s_{t+1}(j) · f_t(j) A_jj / Σ_i f_t(i) A_ij.
    """
    emission, transition = model.emissionprob_[:, symbol].T, model.transmat_
    smoothed = model.predict_proba(symbol[:, None])
    filtered = model.startprob_ * emission[0]
    stays = np.empty(symbol.size - 1)
    for t in range(symbol.size - 1):
        filtered = filtered / filtered.sum()
        ahead = filtered @ transition
        kept = np.divide(filtered * np.diag(transition), ahead, out=np.zeros_like(ahead), where=ahead > 0)
        stays[t] = smoothed[t + 1] @ kept
        filtered = ahead * emission[t + 1]
    return np.asarray(1 - stays)


def even_times(side: Side, setting: Headline) -> list[Floats]:
    """A change point every so many game steps."""
    gap, found = setting["gap"], []
    for rows in side.games:
        first, last = side.times[rows][[0, -1]]
        found.append(np.arange(first + gap / 2, last, gap))
    return found


def even_rows(side: Side, setting: Headline) -> list[Floats]:
    """A change point every so many rows, standing about not counted."""
    gap, found = setting["gap"], []
    for rows in side.games:
        n = rows.stop - rows.start
        found.append(side.times[rows][np.arange(gap / 2, n - 1, gap).astype(int)])
    return found


def presses(side: Side, setting: Headline) -> list[Floats]:
    """Every row in which the key "interact" is pressed, the last of a game left out as for all others."""
    return [side.times[rows][:-1][side.actions[rows][:-1] == INTERACT] for rows in side.games]


def turns(side: Side, setting: Headline) -> list[Floats]:
    """Every step against a tile, which only turns the cook."""
    found = []
    for rows in side.games:
        cell = side.states[rows] // 4
        found.append(side.times[rows][:-1][(cell[1:] == cell[:-1]) & (side.actions[rows][:-1] != INTERACT)])
    return found
