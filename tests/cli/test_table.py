"""The table that ``learn`` prints: what is counted and what is only listed are told apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from subgoal.answers.segments import segments
from subgoal.answers.subgoals import subgoals
from subgoal.cli.table import print_results
from subgoal.reporting.results import Results
from tests.answers.made import posterior_of
from tests.reporting.made import PLACES


@pytest.mark.parametrize(
    ("few", "headline", "marked"),
    [
        (2, "1 subgoal with at least 5 % of 50 observations in 50 trajectories, and 1 smaller place (", 1),
        (5, "2 subgoals with at least 5 % of 50 observations in 50 trajectories (", 0),
    ],
)
def test_the_headline_and_the_rows_count_alike(
    few: int, headline: str, marked: int, capsys: pytest.CaptureFixture[str]
) -> None:
    posterior = posterior_of(np.array([[0] * (50 - few) + [1] * few] * 4), PLACES, offset=np.arange(51))
    found = subgoals(posterior)
    print_results(posterior, Results(Path("out"), found, segments(posterior, found)), Path("out"))
    told = capsys.readouterr().out
    assert headline in told
    assert told.count("* below 5 %: listed, not counted") == marked
    assert told.count("2*") == marked
    assert "1*" not in told
