"""From a drawing to a posterior: quickly at pen-up, in full once there is time, by the way of ``subgoal learn``."""

from __future__ import annotations

from dataclasses import dataclass

from subgoal.answers.segments import Segments, segments
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.candidates import epsilon_net
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import sample
from subgoal.runtime.errors import InputError
from subgoal.teach.drawing import stroke_of

RATE = 20.0
"""Pairs per second that are learned from."""
DRAWING, SETTLED, FULL = "drawing", "settled", "full"
"""Stages of an answer: while the pen is down; after pen-up, of few draws; of the default run."""


@dataclass(frozen=True)
class Tuning:
    """Confidence α, nats per unit of direction, and concentration η."""

    confidence: float = 3.0
    concentration: float = 1.0


@dataclass(frozen=True)
class Run:
    """How many draws of how many chains."""

    chains: int = 4
    draws: int = 1000
    warmup: int = 1000
    thin: int = 10


RUNS = {DRAWING: Run(draws=100, warmup=100, thin=2), SETTLED: Run(draws=200, warmup=200, thin=5), FULL: Run()}


@dataclass(frozen=True, eq=False)
class Answer:
    """What is known of a drawing at a stage.

    Attributes
    ----------
    found, cut:
        Subgoals and segments.
    strokes:
        The stroke (from 0) of each trajectory: strokes of one point are none.
    pairs:
        State-action pairs learned from.
    radius:
        ε of the candidates.
    posterior:
        Where there is one: not while the pen is down.
    """

    stage: str
    found: Subgoals
    cut: Segments
    strokes: tuple[int, ...]
    pairs: int
    radius: float
    posterior: Posterior | None = None

    @property
    def status(self) -> Status | None:
        """That of the posterior."""
        return None if self.posterior is None else self.posterior.status


def demonstrations_of(recording: Recording, pairs: int | None = None) -> Demonstrations:
    """As ``demonstrate`` with 20 samples a second where there are seconds; raises ``InputError`` above ``pairs``."""
    demos = demonstrate(recording, rate=RATE if recording.time_unit == "s" else None)
    if pairs is not None and demos.n_observations > pairs:
        raise InputError("recording", found=f"{demos.n_observations:,} samples", wanted=f"at most {pairs:,}",
                         hint="subgoal learn, or a shorter piece")  # fmt: skip
    return demos


def learn(demos: Demonstrations, tuning: Tuning, stage: str = FULL) -> Answer:
    """The posterior of ``demos`` and what it says. Raises ``InputError`` where nothing moves.

    Not converging is told by the answer's status, and warned of by ``sample``.
    """
    likelihood = action_comparison(demos, epsilon_net(demos), confidence=tuning.confidence)
    run = RUNS[stage]
    posterior = sample(
        likelihood, concentration=tuning.concentration, chains=run.chains, draws=run.draws, warmup=run.warmup,
        thin=run.thin, seed=0, workers=1,
    )  # fmt: skip
    found = subgoals(posterior)
    strokes = tuple(stroke_of(name) for name in demos.trajectory_names)
    cut = segments(posterior, found)
    return Answer(stage, found, cut, strokes, demos.n_observations, posterior.candidates.radius, posterior)
