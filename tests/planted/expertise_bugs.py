"""Wrongs that somebody could write about the confidence and expertise, and the test that must notice each."""

from __future__ import annotations

from tests.planted.bug import Bug

SWEEP, RECORD = "irl/confidence_sweep.py", "irl/sweep_record.py"
SECOND, EXPERTISE, TABLE = "irl/second_subgoal.py", "irl/expertise.py", "irl/expertise_record.py"
LOOPS = "_kernels/persistence_sweeps.py"
IN_SWEEP, IN_SECOND = "irl/test_confidence_sweep.py::test_", "irl/test_second_subgoal.py::test_"
IN_EXPERTISE = "irl/test_expertise.py::test_"
DRAW_FOR_DRAW = "exact/test_persistence_sweeps.py::test_the_compiled_loop_makes_the_draws_of_the_sweeps_in_python"
STREAMS = IN_SWEEP + "each_trial_has_its_level_and_a_stream_of_its_own"

EXPERTISE_BUGS = [
    Bug("trials of all levels share their streams", SWEEP, "stream(seed, level, k)", "stream(seed, k)", STREAMS),
    Bug("every level is swept at the confidence of the likelihood", SWEEP, "likelihood.at(float(levels[level]))",
        "likelihood", STREAMS),
    Bug("subgoals of any share are counted", SWEEP, "x > 0 and reaches(x, share)", "x > 0",
        IN_SWEEP + "counted_are_distinct_subgoals_of_at_least_that_share"),
    Bug("no subgoal is counted as one", SWEEP, "minlength=places)[:places]", "minlength=places)",
        IN_SWEEP + "no_subgoal_is_none"),
    Bug("a plateau is the run of most levels", RECORD, "key=lambda run: run[1] / run[0]",
        "key=lambda run: sum(run[0] <= x <= run[1] for x in self.confidences.tolist())",
        IN_SWEEP + "a_plateau_is_the_longest_run_in_the_ratio_of_its_ends"),
    Bug("resuming begins anew", RECORD, 'self.done = len(arrays["counts"])', "self.done = 0",
        IN_SWEEP + "levels_that_are_done_are_not_done_again"),
    Bug("the second subgoal is where the step began", SECOND, "return SecondSubgoal(above[0], above[1].best",
        "return SecondSubgoal(1.05 * above[0], above[1].best",
        IN_SECOND + "it_is_where_the_best_pair_of_candidates_first_beats_one"),
    Bug("the goal is not summed out under its prior", EXPERTISE, "np.asarray(likelihood.log_prior[in_play] + np.array",
        "np.asarray(0 * likelihood.log_prior[in_play] + np.array",
        IN_EXPERTISE + "the_goal_is_summed_out_under_its_prior"),
    Bug("each observation counts as one", EXPERTISE, "scale = weight * (", "scale = 1.0 * (",
        IN_EXPERTISE + "an_action_that_is_repeated_counts_once"),
    Bug("a flat prior on α and not on its logarithm", EXPERTISE, "density / trapezoid(density, np.log(finer))",
        "density * finer / trapezoid(density * finer, np.log(finer))",
        IN_EXPERTISE + "median_and_interval_are_those_of_the_posterior"),
    Bug("test actions are always close enough", EXPERTISE, ">= RESOLVED", ">= 0.0",
        IN_EXPERTISE + "test_actions_too_far_apart_are_noticed_with_the_way_out"),
    Bug("rows of another group", EXPERTISE, "np.flatnonzero(group == k)", "np.flatnonzero(group >= k)",
        IN_EXPERTISE + "groups_are_demonstrators_and_get_what_each_would_get_alone"),
    Bug("less expert is more", TABLE, "distribution(a.confidences, a.density * below)",
        "distribution(a.confidences, a.density * (1 - below))",
        IN_EXPERTISE + "the_probability_that_one_is_more_expert_is_that_of_independent_draws"),
    Bug("weights of the compiled sweeps forget their counts", LOOPS, "concentration * prior + counts",
        "concentration * prior + 0 * counts", DRAW_FOR_DRAW),
    Bug("the joint of the compiled sweeps lacks its steps", LOOPS, "+ log_of_steps(steps, keep, keep_there)",
        "+ 0 * log_of_steps(steps, keep, keep_there)", DRAW_FOR_DRAW),
]  # fmt: skip
