"""Testing the tests: every planted bug is noticed by the test that is named for it, and without it that test passes."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from tests.planted.bugs import BUGS, Bug
from tests.planted.process import ELSEWHERE, ROOT, run_tests

LEAST = 25
LONGEST, LONGEST_OF_ALL = 300, 1200
"""Seconds after which a run is stopped, so that no bug runs on for ever; and the run of all named tests without one."""
TESTS_FAILED = 1
"""pytest's exit status when tests ran and some failed; errors of collection or usage have others."""


def test_the_library_is_large_and_names_each_bug_once() -> None:
    assert len(BUGS) >= LEAST
    assert len({bug.name for bug in BUGS}) == len(BUGS)


@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.name)
def test_every_bug_still_has_its_place(bug: Bug) -> None:
    text = (ROOT / "src" / "subgoal" / bug.file).read_text()
    assert text.count(bug.right) == 1
    assert bug.wrong != bug.right
    assert (ROOT / "tests" / bug.test.split("::")[0]).exists()


CALLED_BY_OTHER_LOOPS = tuple(f"_kernels/{name}.py" for name in ("counts", "draws", "seating", "rank_updates"))
"""Their compiled callers keep what they were compiled with, so that bugs in them are tested without compilation."""


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package, with the loops that the named tests need compiled once in ``loops`` beside it."""
    folder = tmp_path_factory.mktemp("planted")
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))
    named = sorted({bug.test for bug in BUGS})
    done = run_tests(folder, folder / "loops", folder / "log", *named, longest=LONGEST_OF_ALL)
    assert done.status == 0, done.printed[-3000:]
    return folder


@pytest.mark.t2
def test_a_package_from_another_place_is_not_taken_for_the_copy(tmp_path: Path) -> None:
    done = run_tests(tmp_path, tmp_path / "loops", tmp_path / "log", "runtime", longest=LONGEST)
    assert done.status == ELSEWHERE


@pytest.mark.t2
@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.name)
def test_every_bug_is_noticed(bug: Bug, copy: Path, tmp_path: Path) -> None:
    """The loops compiled for the copy are given to each run anew: only those of a changed file are compiled again."""
    place = copy / "src" / "subgoal" / bug.file
    right, when = place.read_text(), place.stat().st_mtime_ns
    loops = shutil.copytree(copy / "loops", tmp_path / "loops", copy_function=os.link)
    compiled = bug.file not in CALLED_BY_OTHER_LOOPS
    try:
        place.write_text(right.replace(bug.right, bug.wrong))
        done = run_tests(copy, loops, tmp_path / "log", bug.test, longest=LONGEST, compiled=compiled)
    finally:
        place.write_text(right)
        os.utime(place, ns=(when, when))
    assert done.status == TESTS_FAILED, done.printed[-3000:]
