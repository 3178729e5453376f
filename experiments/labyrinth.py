"""What mice are after in a labyrinth (thesis chapter 4 on real walks): does BNIRL find the water port and the way home?

Nobody tells the learner where the water is. It sees which way a mouse turned at each junction and nothing else.

* The first three quarters of a session's bouts are for training, the last quarter is held out.
* γ and α are those of a grid that predict best inside the training bouts of session D9a: five folds (bout k in fold
  k mod 5), mean log₂ p(action) under the mixture predictive. The other sessions take them over.
* The goal ends the episode ("absorbing"). A mouse cannot stay at a node, but home it can, so with a reward at every
  visit home would be worth another number of rewards than any node: α would differ between candidates by a factor
  that depends on how the end is modelled. Rewarded once, all goals are worth the same.
* Candidates are the visited nodes and home. Decisions with one legal action are in no score.

That the water port comes first hangs on choices that were settled after looking at session D9a: the convention, the
range of the grid and the quarter held out. Over 25 settings of γ and α each, on the same training bouts, it is first
in 17 when a goal ends the episode and in 4 when it is rewarded at every visit (α from 1 to 10 there); else mostly home,
the node before the port, or another corner. Without γ = 0.5 the same rule picks γ = 0.6, α = 10, where node 35 is.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.labyrinth_picture import picture
from experiments.labyrinth_world import (
    Maze,
    chance,
    decisions,
    markov,
    read_maze,
    some_bouts,
    walks,
    water_deliveries,
    world,
)
from subgoal.answers.predictions import predict_literal, predict_mixture, predict_nearby, predict_waypoints
from subgoal.answers.scores import bits_per_decision, zero_one_loss
from subgoal.answers.subgoals import subgoals
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bnirl import bnirl
from subgoal.mdp.planners.subgoal_plan import Convention
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats

SESSION, OTHERS = "D9a", ("A1b", "D9b")
CONVENTION: Convention = "absorbing"
GAMMAS, ALPHAS = (0.5, 0.6, 0.7, 0.8, 0.9), (3.0, 10.0, 30.0, 100.0)
"""Below γ = 0.5 a goal four corridors away would be worth less than 6 % of one at hand. D9a prefers that edge."""
SMOOTHINGS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
FOLDS = 5
LONG: dict[str, Any] = {"draws": 2000, "warmup": 2000, "thin": 25}
SHORT: dict[str, Any] = {"draws": 100, "warmup": 100, "thin": 1}
QUICK: dict[str, Any] = {"draws": 200, "warmup": 200, "thin": 3}


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Session D9a in detail; the other sessions, and other quarters held out, in a full run."""
    folder, quick = options.recordings, options.quick
    maze = read_maze(folder)
    demos = walks(folder, SESSION, maze)
    train, held_out = quarters(demos, 3)
    settings, tried = choose(train, maze, options.seed, quick)
    posterior = learn(train, maze, settings, options.seed, QUICK if quick else LONG)
    scores = compare(posterior, train, held_out)
    headline = {
        "session": SESSION,
        "subgoals": listed(posterior),
        "water_port": maze.water,
        "water_deliveries": water_deliveries(folder, SESSION),
        **settings,
        "convention": CONVENTION,
        "status": posterior.status.name,
        **scores,
        "training": {"bouts": train.n_trajectories, "decisions": int(decisions(train).sum())},
        "held_out": {"bouts": held_out.n_trajectories, "decisions": int(decisions(held_out).sum())},
        "tried": tried,
    }
    if not quick:
        headline["other_quarters"] = [row(demos, maze, settings, options.seed, quarter) for quarter in range(3)]
        headline["other_sessions"] = {
            name: {
                "water_deliveries": water_deliveries(folder, name),
                **row(walks(folder, name, maze), maze, settings, options.seed, 3),
            }
            for name in OTHERS
        }
    return headline, picture(maze, posterior, headline)


def quarters(demos: Demonstrations, held_out: int) -> tuple[Demonstrations, Demonstrations]:
    """The bouts outside one quarter of the session, and those in it (0 is the first quarter, 3 the last)."""
    edge = np.round(np.linspace(0, demos.n_trajectories, 5)).astype(int)
    inside = np.arange(edge[held_out], edge[held_out + 1])
    outside = np.setdiff1d(np.arange(demos.n_trajectories), inside)
    return some_bouts(demos, outside), some_bouts(demos, inside)


def learn(demos: Demonstrations, maze: Maze, settings: Headline, seed: int, length: dict[str, Any]) -> Posterior:
    """The default sampler with its four chains."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return bnirl(
            demos, world(settings["gamma"], maze), confidence=settings["alpha"], convention=CONVENTION,
            seed=seed, **length,
        )  # fmt: skip


def choose(train: Demonstrations, maze: Maze, seed: int, quick: bool) -> tuple[Headline, list[Headline]]:
    """γ and α that predict the left-out folds of the training bouts best, and the bits of all that were tried."""
    gammas, alphas = ((0.5, 0.8), (10.0, 30.0)) if quick else (GAMMAS, ALPHAS)
    tried = []
    for gamma in gammas:
        for alpha in alphas:
            settings = {"gamma": gamma, "alpha": alpha}
            parts = []
            for learned, asked in folds(train):
                posterior = learn(learned, maze, settings, seed, SHORT)
                parts.append(bits(predict_mixture(posterior, asked.states), asked))
            tried.append({**settings, "bits_per_decision": float(np.concatenate(parts).mean())})
    best = max(tried, key=lambda entry: entry["bits_per_decision"])
    return {name: best[name] for name in ("gamma", "alpha")}, tried


def folds(demos: Demonstrations) -> list[tuple[Demonstrations, Demonstrations]]:
    """Bouts outside and inside each fold."""
    fold = np.arange(demos.n_trajectories) % FOLDS
    return [
        (some_bouts(demos, np.flatnonzero(fold != k)), some_bouts(demos, np.flatnonzero(fold == k)))
        for k in range(FOLDS)
    ]  # fmt: skip


def bits(probabilities: Floats, demos: Demonstrations) -> Floats:
    """log₂ p(action) of each decision."""
    rows = np.flatnonzero(decisions(demos))
    return np.asarray(np.log2(probabilities[rows, demos.actions[rows]]))


def best_smoothing(train: Demonstrations, order: int) -> float:
    """That of the Markov chain which predicts the left-out folds of the training bouts best."""
    score = [
        np.concatenate([bits(markov(learned, asked, order, each), asked) for learned, asked in folds(train)]).mean()
        for each in SMOOTHINGS
    ]
    return SMOOTHINGS[int(np.argmax(score))]


def compare(posterior: Posterior, train: Demonstrations, held_out: Demonstrations) -> dict[str, Any]:
    """Bits per decision, their standard error over bouts, and 0-1 loss, of each model on the held-out bouts."""
    smoothing = {order: best_smoothing(train, order) for order in (1, 2)}
    tables = {
        "chance": chance(held_out),
        "Markov chain, first order": markov(train, held_out, 1, smoothing[1]),
        "Markov chain, second order": markov(train, held_out, 2, smoothing[2]),
        "BNIRL, mixture": predict_mixture(posterior, held_out.states),
        "BNIRL, nearby": predict_nearby(posterior, held_out.states),
        "BNIRL, waypoints": predict_waypoints(posterior, held_out),
        "BNIRL, as printed (4.14)": predict_literal(posterior, held_out.states),
    }
    counted = decisions(held_out)
    return {
        "bits_per_decision": {
            name: bits_per_decision(table, held_out.actions, counted=counted) for name, table in tables.items()
        },
        "standard_error": {name: standard_error(table, held_out) for name, table in tables.items()},
        "zero_one_loss": {
            name: zero_one_loss(table, held_out.actions, counted=counted) for name, table in tables.items()
        },
        "markov_smoothing": smoothing,
    }


def standard_error(probabilities: Floats, demos: Demonstrations) -> float:
    """Of the mean bits per decision, bouts being independent and decisions within a bout not."""
    values, counted = bits(probabilities, demos), decisions(demos)
    off = np.bincount(demos.trajectory[counted], values - values.mean(), minlength=demos.n_trajectories)
    return float(np.sqrt((off**2).sum()) / values.size)


def listed(posterior: Posterior) -> list[Headline]:
    """Subgoals with at least 1 % of the observations, by falling expected share."""
    sets: Any = posterior.candidates.goal_sets
    return [
        {"node": int(sets[item.candidate][0]), "share": item.share, "share_interval": item.share_interval}
        for item in subgoals(posterior, merge_radius=0.0)
    ]


def row(demos: Demonstrations, maze: Maze, settings: Headline, seed: int, held_out: int) -> Headline:
    """The same for other bouts, from the default draws."""
    train, asked = quarters(demos, held_out)
    posterior = learn(train, maze, settings, seed, {})
    scores = compare(posterior, train, asked)
    return {
        "held_out_quarter": held_out + 1,
        "subgoals": listed(posterior)[:5],
        "status": posterior.status.name,
        "bits_per_decision": scores["bits_per_decision"],
    }


if __name__ == "__main__":
    run("labyrinth", experiment, needs="mouse_labyrinth")
