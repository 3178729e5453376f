"""Small wrongs in what is shown while work goes on and in the report, and the test that must notice each."""

from __future__ import annotations

from tests.planted.bug import Bug

PROGRESS, PACE = "runtime/progress.py", "runtime/test_progress.py::test_"
THINNING, NET = "demonstrations/thinning.py", "demonstrations/test_thinning.py::test_"

DISPLAY_BUGS = [
    Bug("the start is part of the rate", PROGRESS, "(now, done) if done else None", "(now - now, 0)",
        PACE + "the_rate_is_that_after_the_first_step[start0]"),
    Bug("the first step is when nothing is done yet", PROGRESS, "(now, done) if done else None", "(now, done)",
        PACE + "the_rate_is_that_after_the_first_step[start1]"),
    Bug("a rate is told of a moment", PROGRESS, "now - begin >= RATE_AFTER", "now > begin",
        PACE + "a_moment_after_the_first_step_foretells_nothing"),
    Bug("what was done before counts in the rate", PROGRESS, "(done - first) / (now - begin)", "done / (now - begin)",
        PACE + "what_was_done_before_is_no_part_of_the_rate"),
    Bug("squares overflow aloud", THINNING, "        squared =", "    squared =",
        NET + "points_too_far_apart_are_refused_without_a_warning[1e+300-1.0]"),
]  # fmt: skip
