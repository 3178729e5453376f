"""``learn`` on its way to the weight: it shows what it does, and stops when it is asked."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest

from subgoal.answers.evidence import Evidence
from subgoal.irl import learn as module
from subgoal.irl.learn import learn
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.archive import load, save
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.progress import Silent
from tests.posterior.worlds import corner_likelihood


class Heard(Silent):
    """Remembers the notes, and presses Ctrl-C at one of them."""

    def __init__(self, pressed: str = "never") -> None:
        self.notes: list[str] = []
        self._pressed = pressed

    def update(self, done: int, total: int, note: str = "") -> None:
        self.notes.append(note)
        if self._pressed in note:
            self._pressed = "never"
            signal.raise_signal(signal.SIGINT)


@pytest.mark.filterwarnings("ignore")
def test_ctrl_c_while_the_weight_is_found_stops_all() -> None:
    heard = Heard("round 1")
    with pytest.raises(StoppedError, match=r"worth|warm-up"):
        learn(corner_likelihood(), draws=20, warmup=10, thin=1, workers=1, progress=heard)
    assert {note for note in heard.notes if note} == {"what an observation is worth, round 1"}


@pytest.mark.filterwarnings("ignore")
def test_every_round_is_shown_and_then_the_run() -> None:
    heard = Heard()
    learn(corner_likelihood(), draws=20, warmup=10, thin=1, workers=1, progress=heard)
    assert heard.notes[0] == "what an observation is worth, round 1"
    assert heard.notes[-1] == ""
    told = [note for note in dict.fromkeys(heard.notes) if note]
    assert told == [f"what an observation is worth, round {k}" for k in range(1, len(told) + 1)]


@pytest.mark.filterwarnings("ignore")
def test_a_weight_that_settles_is_said_to_have() -> None:
    assert learn(corner_likelihood(), draws=8, warmup=4, thin=1, workers=1).weight_settled is True


def test_a_weight_that_does_not_settle_is_said_not_to_have(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """With one round only, and errors whose weight is far from the first guess of 1."""
    monkeypatch.setattr(module, "ROUNDS", 1)
    monkeypatch.setattr(module, "evidence", lambda trial: Evidence(np.ones(1), 4.0, 0.25))
    with pytest.warns(ConvergenceWarning, match="has not settled"):
        made = learn(corner_likelihood(), draws=8, warmup=4, thin=1, workers=1)
    assert made.weight_settled is False
    assert made.likelihood.weight[0] == 0.25
    assert load(save(made, tmp_path / "made.npz")).weight_settled is False


@pytest.mark.filterwarnings("ignore")
def test_weights_that_were_given_are_not_sought() -> None:
    made = learn(corner_likelihood().weighted(0.5), draws=8, warmup=4, thin=1, workers=1)
    assert made.weight_settled is None


def test_a_plain_table_is_sent_to_sample() -> None:
    table = LogLikelihood.from_table(np.zeros((4, 2)))
    with pytest.raises(InputError, match=r"likelihood: found a plain table.*Try: subgoal\.sample\(likelihood"):
        learn(table)
    with pytest.raises(InputError, match="likelihood: found a plain table"):
        learn(table, confidence=None)


@pytest.mark.filterwarnings("ignore")
def test_a_plain_table_with_weights_and_no_noise_to_learn_is_fine() -> None:
    table = LogLikelihood.from_table(np.zeros((4, 2))).weighted(0.5)
    made = learn(table, confidence=None, model=None, chains=1, draws=4, warmup=0, thin=1, workers=1)
    assert made.n_draws == 4
