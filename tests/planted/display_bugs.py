"""Small wrongs in what is told while work goes on, in the report and in errors, and the test that must notice each."""

from __future__ import annotations

from tests.planted.bug import Bug

PROGRESS, PACE = "runtime/progress.py", "runtime/test_progress.py::test_"
SIDES, SCENE, TABLES = "reporting/sides.py", "reporting/scene.py", "reporting/tables.py"
SHOWN = "reporting/test_scene.py::test_"
TRIED = "cli/test_learn_continuous.py::test_what_to_try_is_an_option"
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
    Bug("all axes share a scale", SIDES, "np.asarray(straight & same)", "np.full(3, True)",
        SHOWN + "what_is_no_length_fills_its_side"),
    Bug("no axes share a scale", SIDES, "np.asarray(straight & same)", "np.full(3, False)",
        SHOWN + "lengths_have_one_scale[measure1]"),
    Bug("an angle is taken for a length", SIDES, "np.asarray(straight & same)", "np.asarray(same)",
        SHOWN + "an_angle_fills_its_side_beside_lengths_of_one_scale[m]"),
    Bug("points lie on the walls", SIDES, "extent * (1 + 2 * MARGIN)", "extent",
        SHOWN + "all_is_within_the_box_and_the_box_within_view[stretch0-measure0]"),
    Bug("a long box is cut off", SIDES, ", LONGEST_SIDE / float(ratio.max()))", ", 9.0)",
        SHOWN + "all_is_within_the_box_and_the_box_within_view[stretch0-measure0]"),
    Bug("an axis that points down is forgotten", SCENE, 'if y_down and letter == "y" else', "if False else",
        SHOWN + "the_second_axis_may_point_down"),
    Bug("positions have no names", TABLES, "if named else", "if False else",
        SHOWN + "positions_name_their_dimensions_and_the_unit_where_there_is_one"),
    Bug("0 is told to be no dwell", "irl/gpsrl.py", 'positive("dwell", dwell, zero=True)', 'positive("dwell", dwell)',
        "irl/test_gpsrl.py::test_bad_input_is_refused"),
    Bug("a horizon too far is not told", "likelihood/gp_actions.py", "a shorter horizon= (it is", "a width (horizon",
        TRIED + "[words0-options0]"),
    Bug("slow samples held long are not told", "demonstrations/held.py", "a smaller every= or a higher rate= (a",
        "times (a", TRIED + "[words1-options1]"),
    Bug("bounds of actions have no option", "dynamics/protocol.py", "wider bounds (--action-bounds), or in Python ", "",
        TRIED + "[words2-options2]"),
]  # fmt: skip
