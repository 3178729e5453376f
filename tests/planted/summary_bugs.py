"""Planted bugs in what is said of a posterior: bounds and balls, live filters, folds, exports, files, reruns."""

from __future__ import annotations

from tests.planted.bug import Bug

LITERAL, NOISE, TOGETHER = "likelihood/maximum_literal.py", "likelihood/noise.py", "partition/together.py"
BALL, BEST, ONLINE = "answers/credible_ball.py", "answers/best_draw.py", "answers/online.py"
AGAIN, SEGMENTS, VALIDATION = "likelihood/again.py", "answers/segments.py", "answers/validation.py"
SCORES, EXPORT, BY_TRAJECTORY = "answers/trajectory_scores.py", "posterior/export.py", "posterior/trajectories.py"
MEMORY, ARCHIVE, ASSEMBLE = "posterior/memory.py", "posterior/archive.py", "posterior/assemble.py"
COLUMNS, GROUPING = "demonstrations/readers/columns.py", "demonstrations/readers/grouping.py"
SENSITIVITY, RERUNS, VARIATIONS = "irl/sensitivity.py", "irl/reruns.py", "irl/variations.py"
OF_LITERAL, OF_NOISE = "likelihood/test_maximum_literal.py::test_", "likelihood/test_noise.py::test_"
OF_BALL, OF_BEST = "answers/test_credible_ball.py::test_", "answers/test_best_draw.py::test_"
OF_ONLINE, OF_BOUNDARIES = "answers/test_online.py::test_", "answers/test_boundaries.py::test_"
OF_SCORES = "answers/test_trajectory_scores.py::test_"
OF_VALIDATION, OF_EXPORT = "answers/test_validation.py::test_", "posterior/test_export.py::test_"
OF_TRAJECTORIES, OF_POSTERIOR = "posterior/test_trajectories.py::test_", "posterior/test_learned_posterior.py::test_"
OF_GROUPS, OF_SENSITIVITY = "demonstrations/test_group_column.py::test_", "irl/test_sensitivity.py::test_"

LIKELIHOODS = [
    Bug("every direction is as good as the best", LITERAL, "replace(taken, taken=taken.asked)", "taken",
        OF_LITERAL + "of_directions_is_minus_the_chord"),
    Bug("planned actions are held against the worst", LITERAL, "taken.values.argmax(axis=1)",
        "taken.values.argmin(axis=1)", OF_LITERAL + "of_planned_actions_is_what_the_best_action_has_more"),
    Bug("all candidates have the confidence of the first", LITERAL, "np.full(n, each[g])", "np.full(n, each[0])",
        OF_LITERAL + "each_candidate_has_its_own_confidence"),
    Bug("the gate judges levels by the logarithm of their mean", NOISE, "values @ np.log(self.confidences)",
        "np.log(values @ self.confidences)", OF_NOISE + "the_gate_judges_noise_by_its_mean_logarithm"),
    Bug("the gate judges confidences themselves", NOISE, "np.log(values).mean(axis=-1)", "values.mean(axis=-1)",
        OF_NOISE + "the_gate_judges_noise_by_its_mean_logarithm"),
    Bug("bounds on a confidence forget its unit", NOISE, "math.log(SMALLEST * unit), math.log(LARGEST * unit)",
        "math.log(SMALLEST), math.log(LARGEST)",
        OF_NOISE + "a_confidence_can_start_and_move_whatever_its_unit[spec0-1e-12]"),
    Bug("sums of tables are those of their members", TOGETHER, "sums_of(seating.table_of[set_of], count)",
        "sums_of(set_of, candidate.size)",
        "exact/test_transition_groups.py::test_moves_of_tables_leave_the_posterior_invariant[seats0-True]"),
]  # fmt: skip
ANSWERS = [
    Bug("what is shared counts once in a distance", BALL, "- 2 * shared", "- shared",
        OF_BALL + "every_distance_is_the_variation_of_information"),
    Bug("a ball of one draw too few", BALL, "np.sort(distance)[enough - 1]", "np.sort(distance)[max(enough - 2, 0)]",
        OF_BALL + "rare_draws_are_outside"),
    Bug("all of a ball is its edge", BALL, "ball[distance >= distance.max() - TIE]", "ball[distance >= 0]",
        OF_BALL + "radius_and_bounds_are_those_of_the_enumeration[0-0.95]"),
    Bug("the gap is that after the search", BEST, "max(found.upper_bound - log_joint, 0.0)",
        "max(found.upper_bound - found.log_joint, 0.0)", OF_BEST + "search_mends_a_bad_draw"),
    Bug("the bound is given for every model", BEST, "if posterior.settings.model != EXCHANGEABLE:", "if False:",
        OF_BEST + "where_no_bound_is_known_there_is_no_gap[settings0-Persistent]"),
    Bug("the search begins without its background", BEST,
        "np.where(posterior.best_assignment < 0, places, posterior.best_assignment)",
        "np.maximum(posterior.best_assignment, 0)",
        OF_BEST + "the_background_is_minus_one_before_and_after_the_search"),
    Bug("a restart remembers", ONLINE, "self._entering: Floats | None = None",
        'self._entering: Floats | None = getattr(self, "_entering", None)', OF_ONLINE + "a_restart_forgets"),
    Bug("a step forgets the marginal", ONLINE, "log_total += table.log_marginal", "pass",
        OF_ONLINE + "steps_say_what_the_whole_recording_says[0.0-None-None]"),
    Bug("live steps never arrive", ONLINE, "if not self._laws.minds_arrival:", "if True:",
        OF_ONLINE + "steps_say_what_the_whole_recording_says[0.0-None-persistent until arrival]"),
    Bug("what is slow is asked of the recording at hand", AGAIN, "SLOW * pace.median",
        "SLOW * np.median(np.linalg.norm(actions * pace.weights, axis=1))",
        OF_ONLINE + "slowness_and_speed_are_those_of_the_posterior"),
    Bug("held-out rows have the weights of the posterior", AGAIN,
        "return replace(likelihood, source=fresh, demonstrations=demonstrations, weight=None)",
        "return replace(likelihood, source=fresh, demonstrations=demonstrations)",
        "answers/test_filtering.py::test_other_demonstrations_have_the_confidence_and_background_but_no_weights"),
    Bug("boundaries reach over trajectories", SEGMENTS, "np.flatnonzero(np.diff(trajectory) == 0) + 1",
        "np.arange(1, spoken.size)",
        OF_BOUNDARIES + "silence_at_the_beginning_hides_no_boundary_of_another_trajectory"),
    Bug("silent observations are boundaries", SEGMENTS, "spoken = np.flatnonzero(~silent)",
        "spoken = np.arange(silent.size)", OF_BOUNDARIES + "silent_observations_are_passed_over"),
    Bug("folds are foretold by what has seen them", VALIDATION, "np.flatnonzero(fold != k)", "np.arange(count)",
        OF_VALIDATION + "each_fold_is_scored_by_the_posterior_of_the_others[None]"),
    Bug("scores of trajectories are raised to their weight", VALIDATION, "seed=seed, weighted=False)", "seed=seed)",
        OF_VALIDATION + "leaving_one_out_of_the_exchangeable_model_is_the_exact_refit[0.5]"),
    Bug("draws that tell a trajectory well count for more", VALIDATION, "raised = column - column.min()",
        "raised = column.max() - column",
        OF_VALIDATION + "leaving_one_out_of_the_exchangeable_model_is_the_exact_refit[None]"),
    Bug("differences are not paired", SCORES, "error = standard_error(gained,",
        "error = standard_error(self.log_predictive,", OF_SCORES + "differences_are_paired"),
    Bug("the error of a score is that of all of them", SCORES, "np.sqrt(count / (count - 1) *", "np.sqrt(1.0 *",
        OF_SCORES + "the_standard_error_is_over_trajectories"),
]  # fmt: skip
FILES = [
    Bug("the background is exported as what is not", EXPORT, "(1 - served / n).reshape(shape)",
        "(served / n).reshape(shape)", OF_EXPORT + "summaries_of_each_draw_are_those_of_its_assignment"),
    Bug("powers of likelihoods are exported", EXPORT, "if is_weighted(posterior):", "if False:",
        OF_EXPORT + "what_is_no_probability_is_refused"),
    Bug("one draw's noise is that of all", BY_TRAJECTORY, "noise.table(drawn[row])", "noise.table(drawn[0])",
        OF_TRAJECTORIES + "each_draw_has_its_own_noise[confidence0]"),
    Bug("weights are never left out", BY_TRAJECTORY, "if not weighted:", "if False:",
        OF_TRAJECTORIES + "weights_are_powers_or_left_out"),
    Bug("memory of a model is not foreseen", MEMORY, "chain += sampler.bytes_needed(n, g_count)", "pass",
        "posterior/test_memory.py::test_what_a_sampler_holds_is_part_of_the_prediction"),
    Bug("redraws are not read back", ARCHIVE, "redraws=_redraws(arrays)", "redraws=None",
        OF_POSTERIOR + "a_file_gives_all_of_it_back[persistent-confidence0]"),
    Bug("groups are not saved", ARCHIVE, '"groups": demos.groups,', '"groups": (),',
        "answers/test_groups.py::test_groups_are_saved_with_a_posterior"),
    Bug("the background has a number in the draws", ASSEMBLE, "theta[theta >= places] = -1",
        "theta[theta > places] = -1", OF_POSTERIOR + "background_is_minus_one_and_what_the_shares_lack"),
    Bug("an animal's column tells trajectories apart", COLUMNS, ', _name("group", group)}', "}",
        OF_GROUPS + "the_groups_column_does_not_tell_trajectories_apart_unless_it_is_said_to"),
    Bug("groups go by trajectory and not by piece", COLUMNS, "tuple(of_each[g] for g in group[row][starts])",
        "tuple(of_each[: len(starts)])", OF_GROUPS + "pieces_of_a_clock_that_jumps_keep_their_group"),
    Bug("rows without a group are of some group", GROUPING, "if blank[rows].any():", "if False:",
        OF_GROUPS + "a_row_without_a_group_is_refused"),
    Bug("the first group of a trajectory wins", GROUPING, "if other.any():", "if False:",
        OF_GROUPS + "a_trajectory_with_two_groups_is_refused_with_its_row"),
]  # fmt: skip
OTHER_SETTINGS = [
    Bug("every fourth observation of the recording, not of each trajectory", VARIATIONS,
        " - np.repeat(demonstrations.offset[:-1], lengths)", "",
        OF_SENSITIVITY + "every_other_observation_from_the_first_of_each_trajectory"),
    Bug("weights are not thinned along", VARIATIONS, "table.weighted(weight[rows])",
        "table.weighted(weight[: rows.size])",
        OF_SENSITIVITY + "weights_that_differ_or_are_to_be_kept_are_thinned_along"),
    Bug("a rerun's places match from any distance", SENSITIVITY, "np.where(gap <= within, both * nearness, 0.0)",
        "both * np.maximum(nearness, 1e-9)",
        OF_SENSITIVITY + "places_are_the_same_within_a_reach_and_most_of_the_shares_is_matched"),
    Bug("of two that match as much the first is taken", SENSITIVITY, "1 - 0.5 * gap / within if within > 0 else ",
        "", OF_SENSITIVITY + "of_two_that_match_as_much_the_nearer_is_taken"),
    Bug("a mere repetition counts as another setting", RERUNS, "self.rows[1:] if row.kind != AGAIN", "self.rows[1:]",
        OF_SENSITIVITY + "what_is_said_when_all_stays"),
    Bug("a change of a share goes up only", RERUNS, "np.abs(self.change).max(initial=0.0)",
        "self.change.max(initial=0.0)", OF_SENSITIVITY + "what_is_said_when_it_does_not"),
]  # fmt: skip
SUMMARY_BUGS = [*LIKELIHOODS, *ANSWERS, *FILES, *OTHER_SETTINGS]
