"""Which account of a demonstrator foretells best what it has not seen: methods side by side, by whole trajectories."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from subgoal.answers.scores import likeliest, losses
from subgoal.answers.trajectory_scores import Difference, TrajectoryScores
from subgoal.answers.validation import some_trajectories
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.rivals import FLOORS, RIVALS, SEVERAL, SINGLE, Fitted, Rival, fitted
from subgoal.irl.single_reward import shown
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, Ints, real_array, whole
from subgoal.runtime.errors import InputError, StoppedError, SubgoalError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream

CLOSE = 1e-6
MOST_FOLDS = 5
"""Where no number is given."""
BOTH = "functions by name, those of the library as {'bnirl': subgoal.irl.rivals.RIVALS['bnirl'][1], 'mine': mine}"


@dataclass(frozen=True, eq=False, repr=False)
class Compared(TrajectoryScores):
    """How one method foretold the trajectories it had not seen.

    Attributes
    ----------
    key, name:
        Of ``RIVALS``, and in words.
    losses:
        (D,) expected 0-1 losses of its likeliest action, summed over each trajectory, ties split evenly.
    seconds:
        Of all fits.
    size, unit:
        How many subgoals, rewards or counts it has, in the mean over the folds.
    converged:
        In how many folds, of how many.
    notes:
        Of the fit to the last fold.
    """

    key: str
    name: str
    losses: Floats
    seconds: float
    size: float
    unit: str
    converged: tuple[int, int]
    notes: tuple[str, ...]

    @property
    def loss(self) -> float:
        """Share of the decisions in which the likeliest action was not taken."""
        return float(self.losses.sum() / self.decisions.sum())


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """All methods on the same folds, the best in bits per decision first.

    Attributes
    ----------
    methods:
        Scores of each.
    failed:
        Why others could not be fitted, by name.
    unfinished:
        Names of those that Ctrl-C came before.
    setting:
        What the world was made with, in words, where somebody has said it.
    folds:
        (D,) the fold of each trajectory.
    """

    methods: tuple[Compared, ...]
    failed: Mapping[str, str]
    folds: Ints
    unfinished: tuple[str, ...] = ()
    setting: str = ""

    def __repr__(self) -> str:
        told = ", ".join(f"{each.name} {each.bits_per_decision:.3f}" for each in self.methods[:3])
        return f"Comparison({told}; {len(self.methods)} methods, {int(self.folds.max()) + 1} folds)"

    @property
    def best(self) -> Compared:
        """Of the most bits per decision."""
        return self.methods[0]

    def one_reward(self) -> tuple[Compared, Compared, Difference] | None:
        """The best method with several subgoals, the best with one reward, and by how much the first is better.

        None where there is not one of each.
        """
        kinds = [[each for each in self.methods if each.key in keys] for keys in (SEVERAL, SINGLE)]
        if not all(kinds):
            return None
        several, single = kinds[0][0], kinds[1][0]
        return several, single, several.difference(single)

    def behind(self, method: Compared) -> Difference:
        """By how many bits per decision a method is behind the best, over the trajectories."""
        return self.best.difference(method)


def compare(
    demonstrations: Demonstrations,
    mdp: TabularMDP,
    *,
    methods: Sequence[str] | Mapping[str, Rival] | None = None,
    folds: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Comparison:
    """Fit methods to demonstrations of a discrete world and score each on trajectories that it has not seen.

    Parameters
    ----------
    demonstrations, mdp:
        D trajectories, two at least, of states and actions, and their world.
    methods:
        Keys of ``subgoal.irl.rivals.RIVALS``, or functions of one's own by name, from demonstrations, world and seed
        to a ``Fitted``, a ``SingleReward`` or a policy (S, A); not given: all but "bayesian", which
        takes minutes. The floors "chance", "cloning" (p(a | s)) and "markov" (p(a | state before, s)) are always there.
    folds:
        Of whole trajectories, by lot, at most D; not given: 5, or D if that is less. All methods get the same.
    seed:
        Of the folds and of the methods.
    progress:
        Told the fits.

    Returns
    -------
    Comparison. A method that cannot be fitted to some fold, as where features do not allow it, is in ``failed``.

    Raises
    ------
    InputError
        Fewer than two trajectories, more folds than these, methods that are not known, impossible demonstrations.
    StoppedError
        Ctrl-C before a method had been fitted to all folds; after that, what there is is given.
    """
    shown(demonstrations, mdp)
    rivals, count = _chosen(methods), demonstrations.n_trajectories
    folds = min(MOST_FOLDS, count) if folds is None else whole("folds", folds, least=2)
    if count < 2:
        raise InputError("demonstrations", found="one trajectory", wanted="two or more, to leave some out",
                         hint="trajectory='column', where the file has a column that tells them apart")  # fmt: skip
    if folds > count:
        raise InputError("folds", found=folds, wanted=f"at most {count}, the number of trajectories")
    fold = stream(whole("seed", seed, least=0), 36).permutation(np.arange(count) % folds)
    made: list[Compared] = []
    failed: dict[str, str] = {}
    with Interrupt() as interrupt, progress or Silent() as display:
        for k, (key, (name, rival)) in enumerate(rivals.items()):
            step = partial(_tell, display, k * folds, len(rivals) * folds, name)
            try:
                made.append(_scored(key, name, rival, demonstrations, mdp, fold, seed, interrupt, step))
            except StoppedError:
                break
            except SubgoalError as problem:
                failed[name] = str(problem)
    if not made:
        raise StoppedError("stopped before a method had been fitted to all folds")
    done = {each.name for each in made} | set(failed)
    unfinished = tuple(name for name, _ in rivals.values() if name not in done)
    return Comparison(tuple(sorted(made, key=lambda each: -each.bits_per_decision)), failed, fold, unfinished)


def _chosen(methods: Any) -> dict[str, tuple[str, Rival]]:
    """Names and functions by key. Raises ``InputError`` for what is neither keys alone nor functions alone."""
    if methods is None:
        return {key: rival for key, rival in RIVALS.items() if key != "bayesian"}
    if isinstance(methods, Mapping):
        return {key: RIVALS[key] for key in FLOORS} | _own(methods)
    names, known = [] if isinstance(methods, str) else list(methods), f"some of {', '.join(RIVALS)}"
    if not names:
        raise InputError("methods", found=repr(methods) if methods else "none", wanted=f"a list of {known}")
    for each in names:
        if not isinstance(each, str):
            raise InputError("methods", found=repr(each), wanted=f"names in a list, {known}", hint=BOTH)
        if each not in RIVALS:
            raise InputError("methods", found=repr(each), wanted=known)
    return {key: RIVALS[key] for key in RIVALS if key in (*FLOORS, *names)}


def _own(methods: Mapping[str, Any]) -> dict[str, tuple[str, Rival]]:
    if not methods:
        raise InputError("methods", found="none", wanted="functions by name")
    for key, rival in methods.items():
        if not callable(rival):
            raise InputError(f"methods[{key!r}]", found=repr(rival), wanted="a function", hint=BOTH)
    return {str(key): (str(key), rival) for key, rival in methods.items()}


def _tell(display: Progress, before: int, total: int, name: str, done: int, left: float | None = None) -> None:
    """``left`` are the seconds that the other folds of this method will take; what other methods will, nobody knows."""
    display.update(before + done, total, name if left is None else f"{name}, {left:.0f} s left of it")


def _scored(
    key: str, name: str, rival: Rival, demonstrations: Demonstrations, mdp: TabularMDP, fold: Ints, seed: int,
    interrupt: Interrupt, step: Callable[..., None],
) -> Compared:  # fmt: skip
    """One method over all folds. Raises ``StoppedError`` where Ctrl-C came between."""
    table = np.full((demonstrations.n_observations, mdp.n_actions), np.nan)
    fits: list[Fitted] = []
    seconds = 0.0
    folds = int(fold.max()) + 1
    step(0)
    for j in range(folds):
        if interrupt.requested:
            raise StoppedError("stopped")
        begin = time.monotonic()
        fits.append(fitted(name, rival(some_trajectories(demonstrations, np.flatnonzero(fold != j)), mdp, seed), mdp))
        seconds += time.monotonic() - begin
        left_out = np.flatnonzero(fold == j)
        rows = np.isin(demonstrations.trajectory, left_out)
        asked = some_trajectories(demonstrations, left_out)
        table[rows] = check_foretold(name, fits[-1].foretell(asked), (int(rows.sum()), mdp.n_actions))
        step(j + 1, seconds / (j + 1) * (folds - j - 1))
    log_taken, loss = _decisions(table, demonstrations)
    sums = [np.add.reduceat(values, demonstrations.offset[:-1]) for values in (log_taken, loss)]
    return Compared(
        log_predictive=sums[0], decisions=np.diff(demonstrations.offset), key=key, name=name, losses=sums[1],
        seconds=seconds, size=float(np.mean([each.size for each in fits])), unit=fits[-1].unit,
        converged=(sum(each.converged for each in fits), len(fits)), notes=fits[-1].notes,
    )  # fmt: skip


def check_foretold(name: str, given: Any, shape: tuple[int, int]) -> Floats:
    """Probabilities (N, A); raises ``InputError`` naming the method for rows that do not sum to one within 1e-6."""
    table = real_array(f"what {name} foretells", given, ndim=2)
    if table.shape != shape:
        raise InputError(f"what {name} foretells", found=f"shape {table.shape}", wanted=f"{shape}, a row a decision")
    off = ~((table >= 0).all(axis=1) & (np.abs(table.sum(axis=1) - 1) <= CLOSE))
    if off.any():
        row = int(np.argmax(off))
        found = f"numbers from {table[row].min():g} that sum to {table[row].sum():g}"
        raise InputError(f"what {name} foretells", where=f"decision {row}", found=found, wanted="probabilities")
    return table


def _decisions(table: Floats, demonstrations: Demonstrations) -> tuple[Floats, Floats]:
    """(N,) log probability of the action taken, and expected 0-1 loss."""
    actions = np.asarray(demonstrations.actions)
    with np.errstate(divide="ignore"):
        return np.log(table[np.arange(len(table)), actions]), losses(likeliest(table), actions)
