"""What tests of the page share: a small posterior with times, and the cells of a table."""

from __future__ import annotations

import numpy as np

from subgoal.candidates import Candidates
from subgoal.posterior.posterior import Posterior
from tests.answers.made import posterior_of

PLACES = Candidates(np.array([[0.0], [9.0]]), radius=0.1)


def changing() -> Posterior:
    """Two trajectories of 3 and 6; only the second changes its subgoal, twice."""
    draws = np.array([[0, 0, 0, 1, 1, 0, 0, 1, 1]] * 4)
    return posterior_of(draws, PLACES, offset=[0, 3, 9], times=np.array([0.0, 1, 2, 5, 6, 7, 8, 9, 10]))


def cells(html: str, label: str) -> list[str]:
    """Contents of the cells under one head, in order."""
    return [part.split("<span>", 1)[1].split("</span></td>")[0] for part in html.split(f'data-label="{label}"')[1:]]
