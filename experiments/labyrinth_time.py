"""Do a mouse's subgoals last? Four models of how they follow each other, and Markov chains, on held-out bouts.

The models are the exchangeable mixture, subgoals that persist, subgoals that persist until they are reached, and the
sticky hidden Markov model. Fixed before the test bouts were looked at with these models:

* Training bouts, held-out quarter, candidates, convention and scored decisions are those of ``experiments.labyrinth``.
* α, η and how long subgoals last are learned (``OneConfidence``, Gamma(1, 1), uniform priors).
* γ of the exchangeable and of the persistent model is that of five which foretells the folds of the training bouts of
  each session best; the models of arrival and of transitions take that of the persistent one.
* A held-out turn is foretold from the turns before it in its bout (``filtering``). Gaps between models are per turn,
  with a 95 % interval by a paired bootstrap over the held-out bouts.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from experiments.labyrinth import CONVENTION, GAMMAS, OTHERS, SESSION, best_smoothing, bits, folds, listed, quarters
from experiments.labyrinth_world import Maze, chance, decisions, markov, read_maze, walks, world
from subgoal.answers.filtering import filtering
from subgoal.candidates import visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.noise import OneConfidence
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.partition.persistence import Persistent
from subgoal.partition.priors import Beta, Gamma
from subgoal.partition.protocol import Sampler
from subgoal.partition.sticky_hmm import StickyHMM
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

MODELS: dict[str, Sampler | None] = {
    "exchangeable": None,
    "persistent": Persistent(),
    "persistent until arrival": Persistent(keep_there=Beta()),
    "sticky transitions": StickyHMM(),
}
OWN_GAMMA = ("exchangeable", "persistent")
CHAINS = ("chance", "Markov chain, first order", "Markov chain, second order")
LONG: dict[str, Any] = {"draws": 500, "warmup": 500, "thin": 4}
SHORT: dict[str, Any] = {"draws": 50, "warmup": 150, "thin": 3, "chains": 2}
QUICK: dict[str, Any] = {"draws": 50, "warmup": 100, "thin": 1, "chains": 2}
QUICK_FOLDS = 2
"""Of the training bouts, foretold to choose γ."""
RESAMPLES = 10_000


def experiment(options: Options) -> tuple[Headline, Figure]:
    """All sessions (D9a alone in a quick run)."""
    maze = read_maze(options.recordings)
    names = (SESSION,) if options.quick else (SESSION, *OTHERS)
    rows = {name: session(options, name, maze) for name in names}
    return {"sessions": rows, "convention": CONVENTION}, picture(rows)


def session(options: Options, name: str, maze: Maze) -> Headline:
    """One session: choose γ on the training bouts, learn, foretell the held-out quarter."""
    train, asked = quarters(walks(options.recordings, name, maze), 3)
    gammas = chosen_gammas(train, maze, options)
    values: dict[str, Floats] = {"chance": bits(chance(asked), asked)}
    for order in (1, 2):
        values[CHAINS[order]] = bits(markov(train, asked, order, best_smoothing(train, order)), asked)
    found: dict[str, Any] = {}
    for model in MODELS:
        posterior = learn(train, maze, gammas[model], model, options.seed, QUICK if options.quick else LONG)
        values[model] = foretold(posterior, asked, options.seed)
        found[model] = {
            "gamma": gammas[model], "status": posterior.status.name, "subgoals": listed(posterior)[:6],
            **{what: float(each.mean()) for what, each in posterior.parameters.items()},
        }  # fmt: skip
    bout = asked.trajectory[decisions(asked)]
    return {
        "bits_per_decision": {what: float(each.mean()) for what, each in values.items()},
        "models": found,
        "persistent_over_exchangeable": gap(values["persistent"], values["exchangeable"], bout, options.seed),
        "persistent_over_second_order": gap(values["persistent"], values[CHAINS[2]], bout, options.seed),
        "sticky_over_second_order": gap(values["sticky transitions"], values[CHAINS[2]], bout, options.seed),
        "held_out": {"bouts": asked.n_trajectories, "decisions": int(decisions(asked).sum())},
    }


def chosen_gammas(train: Demonstrations, maze: Maze, options: Options) -> dict[str, float]:
    """γ of each model, by the folds of the training bouts."""
    quick = options.quick
    tried, length = (GAMMAS[::4], QUICK) if quick else (GAMMAS, SHORT)
    parted = folds(train)[: QUICK_FOLDS if quick else None]
    best = {}
    for model in OWN_GAMMA:
        score = []
        for gamma in tried:
            parts = [
                foretold(learn(learned, maze, gamma, model, options.seed, length), asked, options.seed)
                for learned, asked in parted
            ]
            score.append(float(np.concatenate(parts).mean()))
        best[model] = tried[int(np.argmax(score))]
    return {model: best.get(model, best["persistent"]) for model in MODELS}


def learn(demos: Demonstrations, maze: Maze, gamma: float, model: str, seed: int, length: dict[str, Any]) -> Posterior:
    """α and η learned."""
    likelihood = planned_actions(demos, visited(demos), world(gamma, maze), convention=CONVENTION)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return sample(
            likelihood, model=MODELS[model], concentration=Gamma(), confidence=OneConfidence(), seed=seed, **length
        )


def foretold(posterior: Posterior, asked: Demonstrations, seed: int) -> Floats:
    """log₂ p(turn | turns before it in the bout) of each decision."""
    return np.asarray(filtering(posterior, asked, seed=seed).log_predictive[decisions(asked)] / np.log(2))


def gap(first: Floats, second: Floats, bout: Ints, seed: int) -> Headline:
    """Mean difference in bits per decision, with a 95 % interval by resampling bouts."""
    members = np.unique(bout)
    total = np.array([(first - second)[bout == k].sum() for k in members])
    size = np.array([(bout == k).sum() for k in members])
    pick = stream(seed, 116).integers(0, members.size, (RESAMPLES, members.size))
    resampled = total[pick].sum(axis=1) / size[pick].sum(axis=1)
    low, high = np.quantile(resampled, [0.025, 0.975])
    return {"mean": float((first - second).mean()), "low": float(low), "high": float(high)}


def picture(rows: dict[str, Headline]) -> Figure:
    """Bits gained on chance, one panel per session."""
    figure = sheet(4.6 * len(rows) + 2.2, 3.6)
    axes = np.atleast_1d(figure.subplots(1, len(rows), sharey=True))
    for axis, (name, row) in zip(axes, rows.items(), strict=True):
        values = row["bits_per_decision"]
        shown = [each for each in values if each != "chance"]
        gains = [values[each] - values["chance"] for each in shown]
        axis.barh(shown, gains, color=[GREY if each in CHAINS else PALETTE[0] for each in shown], height=0.6)
        for k, each in enumerate(shown):
            axis.annotate(f"{values[each]:.3f}", (max(gains[k], 0), k), xytext=(5, 0), textcoords="offset points",
                          va="center", fontsize=9)  # fmt: skip
        axis.axvline(0, color=INK, lw=1)
        axis.grid(visible=False, axis="y")
        axis.margins(x=0.2)
        held_out = row["held_out"]
        axis.set(title=f"Session {name}: {held_out['decisions']} turns of {held_out['bouts']} bouts",
                 xlabel=f"bits gained on chance ({values['chance']:.3f}) per turn")  # fmt: skip
    axes[0].invert_yaxis()
    figure.suptitle("How well a mouse's next turn is foretold, with goals that may last and without", x=0.01, ha="left")
    return figure


if __name__ == "__main__":
    run("labyrinth_time", experiment, needs="mouse_labyrinth")
