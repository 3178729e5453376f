"""What a chain keeps of its stretches."""

from __future__ import annotations

import numpy as np

from subgoal.partition.protocol import Stretch
from subgoal.posterior.chains import ChainRecord


def stretch(*rows: tuple[int, ...]) -> Stretch:
    theta = np.array(rows, np.int32)
    trace = np.zeros(len(rows))
    return Stretch({"theta": theta[-1]}, theta, trace.astype(np.int64), trace, trace)


def test_the_best_draw_is_kept_through_stretches_without_a_better_one() -> None:
    record = ChainRecord(3, 2, np.random.default_rng(0), None)
    for rows, joint in ((((0, 0, 1), (0, 1, 1)), (-3.0, -1.0)), (((1, 1, 1),), (-2.0,)), (((0, 0, 0),), (-0.5,))):
        record.add(stretch(*rows), np.array(joint))
        if joint == (-2.0,):
            np.testing.assert_array_equal(record.best[1], (0, 1, 1))
            assert record.best[0] == -1.0
    np.testing.assert_array_equal(record.best[1], (0, 0, 0))
