"""Errors travel between processes with all that they say."""

from __future__ import annotations

import pickle

import pytest

from subgoal.runtime.cluster import ClusterError
from subgoal.runtime.errors import BudgetError, InputError, MissingExtraError, StoppedError, StorageError, SubgoalError


@pytest.mark.parametrize("error", [
    InputError("rows", found=1, wanted="2", where="row 3", hint="another"), StorageError("file", found="a", wanted="b"),
    ClusterError("scheduler", found="silence", wanted="one"), MissingExtraError("distributed", "dask"),
    BudgetError("table", needed=2e9, budget=1e9, hint="less"), StoppedError("no draws"),
], ids=lambda error: type(error).__name__)  # fmt: skip
def test_an_error_is_the_same_in_another_process(error: SubgoalError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)
