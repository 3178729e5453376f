"""What cooks are after (thesis chapter 4 on real people): are the tiles found that they go to and use?

The learner sees steps, turns and key presses; it is not told which tiles matter, nor when one was used. The recording
knows: each successful use names its tile.

* Layout asymmetric_advantages, one model for each of the two rooms, all games of a cook's side together; random0 is
  shown beside it. Candidates are all tiles and counters that can be faced, each a set of states.
* The goal is rewarded at every visit ("continuing"): at the goal tile, "interact" keeps what is had and is optimal.
* The data set's own division is kept: γ and α are those of a grid with the best agreement (adjusted Rand index of
  assigned and true next tile, mean over both rooms) in the games marked "train"; all scores are of games marked
  "test", whose labels are used for nothing else. Beside them: the library's defaults, for which no label was used, and
  γ and α by which the training games are fitted best (bits per decision), again without labels.
* A tile is found if it has 5 % of the observations in expectation, and true if it has 5 % of the successful uses.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.overcooked_picture import picture
from experiments.overcooked_world import (
    INTERACT,
    STEPS,
    Kitchen,
    Shown,
    kitchen,
    read_games,
    read_kitchens,
    shown,
    start_of,
)
from subgoal.answers.predictions import predict_mixture
from subgoal.answers.scores import adjusted_rand, bits_per_decision, identified
from subgoal.answers.subgoals import COUNTED_FROM, reaches
from subgoal.likelihood.planned_actions import DEFAULT_CONFIDENCE, planned_actions
from subgoal.mdp.grids.maps import TextMap
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats, Ints

SCORED, ILLUSTRATED = "asymmetric_advantages", "random0"
GAMMAS, ALPHAS = (0.8, 0.9, 0.95), (1.0, 3.0, 10.0, 30.0, 100.0)
DEFAULT_GAMMA = 0.9
FOUND_FROM = TRUE_FROM = COUNTED_FROM
LONG: dict[str, Any] = {"draws": 1000, "warmup": 500, "thin": 4}
SHORT: dict[str, Any] = {"draws": 100, "warmup": 100, "thin": 2}


@dataclass(frozen=True, eq=False)
class Side:
    """One cook's room in one division of the games, what was learned of it, and its scores."""

    layout: str
    player: int
    room: Kitchen
    seen: Shown
    posterior: Posterior
    scores: Headline

    @property
    def shares(self) -> Floats:
        """(G,) expected share of the observations."""
        return self.posterior.expected_shares


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Choose on the training games, score on the test games."""
    folder, quick = options.recordings, options.quick
    maps, table = read_kitchens(folder), read_games(folder, (SCORED, ILLUSTRATED))
    length = SHORT if quick else LONG
    tried = [
        row(maps, table, "train", gamma, alpha, options.seed)
        for gamma in ((DEFAULT_GAMMA,) if quick else GAMMAS)
        for alpha in ((3.0, 10.0) if quick else ALPHAS)
    ]
    best = max(tried, key=lambda entry: entry["assignment_ari"])
    foretelling = max(tried, key=lambda entry: entry["bits_per_decision"])
    settings = {"gamma": best["gamma"], "alpha": best["alpha"]}
    sides = [learn(maps, table, SCORED, player, "test", settings, options.seed, length) for player in (0, 1)]
    beside = [learn(maps, table, ILLUSTRATED, player, "test", settings, options.seed, length) for player in (0, 1)]
    headline = {
        **summary(sides),
        **settings,
        "convention": "continuing",
        "status": [side.posterior.status.name for side in sides],
        "sides": [entry(side) for side in sides],
        "without_labels": {
            "library defaults": row(maps, table, "test", DEFAULT_GAMMA, DEFAULT_CONFIDENCE, options.seed),
            "chosen by prediction": row(maps, table, "test", foretelling["gamma"], foretelling["alpha"], options.seed),
        },
        "illustration": {**summary(beside), "sides": [entry(side) for side in beside]},
        "tried": tried,
    }
    return headline, picture({SCORED: (maps[SCORED], sides), ILLUSTRATED: (maps[ILLUSTRATED], beside)}, headline)


def learn(
    maps: dict[str, TextMap], table: Any, layout: str, player: int, split: str, settings: Headline, seed: int,
    length: dict[str, Any],
) -> Side:  # fmt: skip
    """One cook's side: plan, sample, score."""
    rows = table[(table["layout"] == layout) & (table["player"] == player) & (table["split"] == split)]
    room = kitchen(maps[layout], start_of(rows), settings["gamma"])
    seen = shown(rows, room)
    likelihood = planned_actions(seen.demonstrations, room.candidates, room.mdp, confidence=settings["alpha"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(likelihood, seed=seed, **length)
    return Side(layout, player, room, seen, posterior, scores(posterior, room, seen))


def scores(posterior: Posterior, room: Kitchen, seen: Shown) -> Headline:
    """Tiles against true tiles, assignments against the tile that was used next, and the bits of these very actions."""
    demos, likelihood = seen.demonstrations, posterior.likelihood
    found = np.array([reaches(share, FOUND_FROM) for share in posterior.expected_shares])
    true = np.array([reaches(share, TRUE_FROM) for share in seen.use_shares])
    assigned, labelled = assignment(posterior), seen.next_tile >= 0
    told = labelled.copy()
    if likelihood is not None:
        told &= identified(likelihood, np.maximum(seen.next_tile, 0), assigned)
    ahead = straight_ahead(room, demos.states, demos.actions)
    return {
        "found": int(found.sum()),
        "true": int(true.sum()),
        "both": int((found & true).sum()),
        "assignment_ari": adjusted_rand(seen.next_tile[labelled], assigned[labelled]),
        "assignment_ari_identified": adjusted_rand(seen.next_tile[told], assigned[told]),
        "assignment_ari_straight_ahead": adjusted_rand(seen.next_tile[labelled], ahead[labelled]),
        "labelled": int(labelled.sum()),
        "identified": int(told.sum()),
        "bits_per_decision": bits_per_decision(predict_mixture(posterior, demos.states), demos.actions),
    }


def assignment(posterior: Posterior) -> Ints:
    """(N,) the most probable candidate of each observation."""
    return np.asarray(np.asarray(posterior.shares.todense()).argmax(axis=1))


def straight_ahead(room: Kitchen, states: Ints, actions: Ints) -> Ints:
    """(N,) the tile one sees first, looking ahead after the action: what could be guessed without any learning."""
    places = {(int(x), int(y)): g for g, (x, y) in enumerate(room.candidates.points)}
    cells = list(room.cells)
    seen = np.empty(len(states), np.int64)
    for i, (state, action) in enumerate(zip(states, actions, strict=True)):
        (x, y), facing = cells[state // 4], state % 4 if action == INTERACT else action
        while (x, y) in room.cells:
            x, y = x + STEPS[facing][0], y + STEPS[facing][1]
        seen[i] = places[x, y]
    return seen


def summary(sides: list[Side]) -> Headline:
    """Precision and recall over the tiles of both rooms, and the mean agreement of the two."""
    total = {name: sum(side.scores[name] for side in sides) for name in ("found", "true", "both")}
    means = ("assignment_ari", "assignment_ari_identified", "assignment_ari_straight_ahead", "bits_per_decision")
    return {
        "precision": total["both"] / total["found"] if total["found"] else 1.0,
        "recall": total["both"] / total["true"],
        **{name: float(np.mean([side.scores[name] for side in sides])) for name in means},
    }


def row(maps: dict[str, TextMap], table: Any, split: str, gamma: float, alpha: float, seed: int) -> Headline:
    """The scored layout with other settings, from shorter chains."""
    settings = {"gamma": gamma, "alpha": alpha}
    sides = [learn(maps, table, SCORED, player, split, settings, seed, SHORT) for player in (0, 1)]
    return {**settings, **summary(sides)}


def entry(side: Side) -> Headline:
    """One room in numbers: every tile that was found or truly used, and what was left out of the recording."""
    listed = np.flatnonzero(np.maximum(side.shares, side.seen.use_shares) >= 0.01)
    return {
        "layout": side.layout,
        "player": side.player,
        "games": side.seen.demonstrations.n_trajectories,
        "pairs": side.seen.demonstrations.n_observations,
        "left_out": side.seen.demonstrations.source.notes,
        **side.scores,
        "tiles": [
            {"tile": side.room.candidates.names[g], "share": side.shares[g], "share_of_uses": side.seen.use_shares[g]}
            for g in listed[np.argsort(-side.shares[listed])]
        ],
    }


if __name__ == "__main__":
    run("overcooked", experiment, needs="overcooked_human")
