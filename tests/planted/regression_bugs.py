"""Small wrongs in Gaussian-process regression, its sparse form, and the thinning of trajectories by it."""

from __future__ import annotations

from tests.planted.bug import Bug

REGRESSION, EVIDENCE = "gaussian/regression.py", "gaussian/evidence.py"
FACTOR, COVARIANCES = "gaussian/factor.py", "gaussian/covariances.py"
FITTED = "gaussian/test_fitted.py"
SPARSE, BOUND, INDUCING = "gaussian/sparse.py", "gaussian/evidence_bound.py", "gaussian/inducing.py"
THINNING, THIN = "gaussian/trajectory_thinning.py", "gaussian/test_trajectory_thinning.py"
NAIVE = THIN + "::test_rows_and_mean_against_the_naive_greedy_choice"
EACH = THIN + "::test_every_trajectory_is_thinned_by_itself_and_its_ends_stay"
TEST, SLOPE, SPARSELY = (f"gaussian/test_{name}.py" for name in ("regression", "evidence", "sparse"))
EXACT = TEST + "::test_mean_variance_weights_and_evidence_against_explicit_inverses"
MERGED = TEST + "::test_repeated_points_that_agree_are_merged_without_noise_and_said_to_be"
GRADIENT = SLOPE + "::test_gradient_is_that_of_central_differences"
ONE_POINT = FITTED + "::test_one_point_tells_no_length_and_the_one_given_stays"
INVERSES = SPARSELY + "::test_against_explicit_inverses"
DENSE = SPARSELY + "::test_with_every_point_it_is_the_dense_form"
RISING = SPARSELY + "::test_gradient_of_the_bound_is_that_of_central_differences"
JITTERED = TEST + "::test_a_singular_covariance_is_jittered_and_said_to_be"
REGRESSION_BUGS = [
    Bug("the prior mean is not added back", REGRESSION, "@ self._solved + self.prior_mean", "@ self._solved", EXACT),
    Bug("the prior mean is not taken off", REGRESSION, "residual = columns - centre", "residual = columns", EXACT),
    Bug("the variance forgets what is known of half the points", REGRESSION,
        "self.covariance(self._basis, places)) ** 2).sum(axis=0)",
        "self.covariance(self._basis, places)) ** 2)[::2].sum(axis=0)", EXACT),
    Bug("a constant of the evidence is dropped", EVIDENCE, "len(residual) * np.log(2 * np.pi)", "0.0", EXACT),
    Bug("noise is part of what is predicted", COVARIANCES,
        'return NoisyCovariance(whole, positive("noise_level", level), ',
        'return NoisyCovariance(covariance, positive("noise_level", level), ',
        TEST + "::test_noise_that_is_learned_is_no_part_of_the_function"),
    Bug("merged observations are counted several times", REGRESSION, "/ share[:, None]", "", MERGED),
    Bug("merging is not told", REGRESSION, "Status.MERGED if self.merged and", "Status.MERGED if False and", MERGED),
    Bug("points with noise are merged", REGRESSION, "if model.noise == 0:", "if model.noise <= 1:",
        TEST + "::test_repeated_points_with_noise_are_observations_of_their_own"),
    Bug("contradictions are passed over", REGRESSION, "AGREE = 1e-12", "AGREE = 1e-3",
        TEST + "::test_repeated_points_that_contradict_each_other_are_refused_without_noise"),
    Bug("jitter is not told", FACTOR, "Factor(frozen(lower), share * scale, ", "Factor(frozen(lower), 0.0, ", JITTERED),
    Bug("jitter starts large", FACTOR, "LEAST_JITTER = 1e-14", "LEAST_JITTER = 1e-5", JITTERED),
    Bug("the largest entry for the largest column", FACTOR, "np.abs(matrix).sum(axis=0).max()", "np.abs(matrix).max()",
        TEST + "::test_condition_is_that_of_the_matrix"),
    Bug("an ill-conditioned matrix passes for exact", FACTOR, "ILL_CONDITIONED_FROM = 1e10",
        "ILL_CONDITIONED_FROM = 1e19",
        TEST + "::test_an_ill_conditioned_covariance_is_said_to_be_and_left_as_it_is"),
    Bug("the gradient counts one function", EVIDENCE, "solved @ solved.T - count * cho_solve",
        "solved @ solved.T - cho_solve", GRADIENT),
    Bug("the noise has no logarithm in the gradient", COVARIANCES, "self.noise * np.eye(len(points))]",
        "np.eye(len(points))]", GRADIENT),
    Bug("all steps are taken", EVIDENCE, 'options={"maxiter": most_iterations}', 'options={"maxiter": 100}',
        FITTED + "::test_iterations_are_counted_and_running_out_of_them_is_told"),
    Bug("a restart changes a length that no point tells", EVIDENCE, "np.where(silent & _blind(model, points)[0], start",
        "np.where(silent & False, start", ONE_POINT),
    Bug("what no point tells passes for found", EVIDENCE, "    if blind:\n", "    if False:\n", ONE_POINT),
    Bug("what points tell together passes for found", EVIDENCE, "silent | together, strict", "silent, strict",
        FITTED + "::test_one_point_does_not_tell_noise_from_the_function"),
    Bug("a bound passes for a maximum", EVIDENCE, "Fitted.AT_BOUND if on_bound else", "Fitted.AT_BOUND if False else",
        FITTED + "::test_a_value_on_its_bound_is_told"),
    Bug("restarts are not drawn", EVIDENCE, "for x in (np.clip(start, low, high), *drawn)",
        "for x in (np.clip(start, low, high), *drawn[:0])",
        FITTED + "::test_restarts_find_a_better_length_and_the_same_seed_the_same"),
    Bug("what is lost is not told", BOUND, "(quadratic + volume + self.lost)", "(quadratic + volume)", INVERSES),
    Bug("what is lost counts double", BOUND, "(quadratic + volume + self.lost)", "(quadratic + volume + 2 * self.lost)",
        INVERSES),
    Bug("sparse variance forgets the data", SPARSE, " - (self._carried.inner.half_solve(half) ** 2).sum(axis=0)",
        "", DENSE),
    Bug("sparse weights without the noise", SPARSE, "@ self._carried.crossed / np.sqrt(self.noise)",
        "@ self._carried.crossed", DENSE),
    Bug("sparse mean without the prior mean", SPARSE, "@ self._solved + self.prior_mean", "@ self._solved", INVERSES),
    Bug("inducing points have no slope", BOUND, 'slope = -np.einsum("ij,ijp->p", by_crossed',
        'slope = 0 * np.einsum("ij,ijp->p", by_crossed', RISING),
    Bug("the last block is left out", BOUND, "for start in range(0, len(points), m)",
        "for start in range(0, len(points) - m, m)", RISING),
    Bug("the prior's variance has no slope", BOUND, "slope -= 0.5 * count / model.noise",
        "slope -= 0 * count / model.noise", RISING),
    Bug("the slope by noise forgets what is lost", BOUND, "(held.trace - held.lost)", "held.trace", RISING),
    Bug("the slope of one function only", BOUND, "+ 0.5 * count * held.excess", "+ 0.5 * held.excess", RISING),
    Bug("the trace of the wrong size", BOUND, "float(n - m + np.trace", "float(n + np.trace", RISING),
    Bug("the second matrix may be anything", SPARSE, "own if own is not Status.EXACT else inner", "own",
        SPARSELY + "::test_little_noise_is_ill_conditioned_and_said_to_be"),
    Bug("inducing points may repeat", SPARSE, "if len(first) < len(places):", "if False:",
        SPARSELY + "::test_bad_input_is_named"),
    Bug("nearest instead of farthest", INDUCING, "gap = np.minimum(gap,", "gap = np.maximum(-1,",
        SPARSELY + "::test_farthest_points_are_each_the_farthest_from_those_before"),
    Bug("the scale is forgotten", INDUCING, "scaled = given / _lengths(scale, given)", "scaled = given",
        SPARSELY + "::test_farthest_points_measure_by_the_scale"),
    Bug("k-means starts anywhere", INDUCING, 'random_state=whole("seed", seed, least=0)',
        "random_state=None, max_iter=1", SPARSELY + "::test_k_means_centres_are_in_the_middle_and_the_same_each_time"),
    Bug("the mean moves without the noise", THINNING, "max(diagonal[row] + model.noise -", "max(diagonal[row] -",
        NAIVE),
    Bug("rows kept before are chosen again", THINNING, "np.where(left, error, -1.0)",
        "np.where(~left, error, -1.0)", NAIVE),
    Bug("the first column only is watched", THINNING, "np.abs(scaled - mean)[:, counted].max(axis=1)\n        if",
        "np.abs(scaled - mean)[:, 0]\n        if", NAIVE),
    Bug("it ends at twice the tolerance", THINNING, "error.max() <= 1:", "error.max() <= 2:",
        THIN + "::test_the_rest_is_reproduced_within_the_tolerance"),
    Bug("the last may go", THINNING, "row = (0, n - 1)[k] if k < 2", "row = (0, n // 2)[k] if k < 2",
        THIN + "::test_of_what_does_not_change_the_first_and_the_last_are_kept"),
    Bug("columns of no account are learned from", THINNING,
        "_learned(inputs, scaled[:, counted], [even, *windows] if n > MOST_FITTED else [even], covariance)",
        "_learned(inputs, scaled, [even, *windows] if n > MOST_FITTED else [even], covariance)",
        THIN + "::test_infinity_leaves_a_column_out_of_account_but_reproduces_it"),
    Bug("what goes on between is not looked at", THINNING, "[even, *windows] if n > MOST_FITTED",
        "[even] if n > MOST_FITTED",
        THIN + "::test_a_tremor_between_evenly_spaced_observations_is_seen"),
    Bug("a tremor is learned although it may be passed over", THINNING, "if len(fewer) < len(rows):", "if False:",
        THIN + "::test_a_tremor_within_the_tolerance_is_passed_over"),
    Bug("what is too rough passes", THINNING, "[:, counted] <= 1).all())", "[:, counted] <= 1e9).all())",
        THIN + "::test_places_in_the_thesis_form_and_two_ways_from_one_place_are_told"),
    Bug("rows count from each trajectory's start", THINNING, "rows = np.concatenate([start + part.rows",
        "rows = np.concatenate([0 * start + part.rows", EACH),
    Bug("errors of the last trajectory", THINNING, "error = np.max([part.error for part in parts], axis=0)",
        "error = parts[-1].error", THIN + "::test_errors_are_the_largest_of_all_trajectories"),
    Bug("the length of a second, whatever the times", THINNING,
        "Matern(START * math.sqrt(spacing * span / max(len(parts[0]) - 1, 1)), (spacing, 10 * span)",
        "Matern(1.0, (1e-3, 1e3)", THIN + "::test_units_do_not_matter"),
]  # fmt: skip
