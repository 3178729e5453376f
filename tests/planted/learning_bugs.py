"""Planted bugs in what is learned beside the subgoals: concentration, persistence, noise, evidence, filtering."""

from __future__ import annotations

from tests.planted.bug import Bug

PRIORS, LEARNING, ETA = "partition/priors.py", "partition/learning.py", "partition/concentration.py"
KEEP, NOISE, ASSIGNED = "partition/persistence.py", "likelihood/noise.py", "likelihood/assigned.py"
TABLE, SOURCES, EVIDENCE, FILTERING = (
    "likelihood/table.py", "likelihood/sources.py", "answers/evidence.py", "answers/filtering.py"
)  # fmt: skip
CHAINS, ARCHIVE, ASSEMBLE = "posterior/chains.py", "posterior/archive.py", "posterior/assemble.py"
LAWS, AS_SAMPLED = "posterior/laws.py", "irl/as_sampled.py"
OF_AS_SAMPLED = "irl/test_as_sampled.py::test_"
OF_PRIORS, OF_LEARNING = "partition/test_priors.py::test_", "partition/test_learning.py::test_"
OF_ASSIGNED = "likelihood/test_assigned.py::test_"
OF_NOISE, OF_EVIDENCE = "likelihood/test_noise.py::test_", "answers/test_evidence.py::test_"
OF_FILTERING, OF_POSTERIOR = "answers/test_filtering.py::test_", "posterior/test_learned_posterior.py::test_"

LEARNING_BUGS = [
    Bug("a slice is cut too high", PRIORS, "log_density(x) - generator.standard_exponential()",
        "log_density(x) - 0.5 * generator.standard_exponential()",
        OF_PRIORS + "a_slice_leaves_the_law_as_it_is[skewed]"),
    Bug("a slice is stepped out to one side only", PRIORS, "for _ in range(left):", "for _ in range(0):",
        OF_PRIORS + "a_slice_leaves_the_law_as_it_is[normal, a slice too narrow]"),
    Bug("a log normal density of the logarithm", PRIORS, "(2 * math.pi)) - math.log(x)", "(2 * math.pi))",
        OF_PRIORS + "log_normal_is_scipys[3.0-1.5]"),
    Bug("shapes are not raised before the uniform", PRIORS, "standard_gamma(shape + 1)", "standard_gamma(shape + 2)",
        OF_PRIORS + "weights_have_the_moments_of_a_dirichlet[shape0]"),
    Bug("the concentration without its Jacobian", ETA, "law.log_density(eta) + log_eta", "law.log_density(eta)",
        OF_LEARNING + "concentrations_are_those_of_quadrature[counts0]"),
    Bug("counts without the prior of each candidate", ETA, "mass = concentration * prior[used]",
        "mass = concentration * prior[used] ** 0", OF_LEARNING + "counts_have_the_probability_of_the_urn[1.0]"),
    Bug("all observations counted, not redraws", LEARNING, 'state["counts"] if "counts" in state else', "",
        OF_LEARNING + "the_concentration_is_drawn_given_the_redraws"),
    Bug("the phase of a call is forgotten", LEARNING, '"learned_phase": np.array([phase])',
        '"learned_phase": np.array([0])', OF_LEARNING + "how_sweeps_are_cut_does_not_change_the_draws[cuts0-mixture]"),
    Bug("the joint density lacks the prior of the concentration", LEARNING,
        "extra += self.concentration.log_density(eta)", "extra += 0.0",
        OF_LEARNING + "the_joint_density_has_the_prior_of_the_concentration[mixture]"),
    Bug("the table stays as it was when the noise is drawn", LEARNING,
        "table = self._table(chain, values) if self.noise else chain.table", "table = chain.table",
        OF_LEARNING + "assignment_and_noise_have_their_joint_law[mixture-one confidence]"),
    Bug("steps that stay all kept", KEEP, "np.log(rho + (1 - rho) * weight)", "np.log(rho + 0 * weight)",
        OF_LEARNING + "persistence_is_that_of_quadrature[repeats1-3]"),
    Bug("one confidence without weights", NOISE, "told.log_density(alpha)[rows] @ weight)",
        "told.log_density(alpha)[rows].sum())",
        OF_NOISE + "confidence_given_the_assignment_is_that_of_quadrature[one-0.4]"),
    Bug("background counts for the noise", NOISE, "np.flatnonzero(theta < none)", "np.arange(theta.size)",
        OF_NOISE + "shares_given_the_assignment_are_those_of_quadrature[None]"),
    Bug("the total of the shares is kept", NOISE, "size = values * generator.standard_gamma(len(values))",
        "size = values * 0.2", OF_NOISE + "without_data_the_shares_are_uniform_on_the_simplex"),
    Bug("candidates without observations keep their confidence", NOISE, "fresh = self.law.median * unit * np.exp(",
        "fresh = values * np.exp(0 * ", OF_NOISE + "each_candidate_has_its_own_confidence"),
    Bug("the held product forgets its peak", NOISE, ".reshape(n, g_count) + peak[:, None]", ".reshape(n, g_count)",
        OF_NOISE + "the_table_of_levels_is_a_mixture_of_tables[0.0-False-plain 2-D]"),
    Bug("the score of a direction at twice its angle", ASSIGNED, "(1 + cosine) / 2, 0, 1", "(1 + cosine), 0, 1",
        OF_ASSIGNED + "scores_of_directions_are_differences_along_the_sphere[plain 2-D]"),
    Bug("the score of values forgets the confidence", ASSIGNED,
        "np.asarray(np.atleast_1d(np.asarray(confidence, float))[:, None] * (taken - chance))",
        "np.asarray(taken - chance)", OF_ASSIGNED + "scores_of_values_are_differences_by_the_values"),
    Bug("background is not taken from the others", TABLE, "places + np.log1p(-self.background)", "places",
        OF_NOISE + "background_is_one_more_column_of_its_prior[plain 2-D]"),
    Bug("slow actions are compared after all", SOURCES, "flat = self.slow | (np.linalg", "flat = (np.linalg",
        OF_ASSIGNED + "assigned_densities_are_entries_of_the_table[plain 2-D]"),
    Bug("assigned actions run on over blocks", SOURCES, "parts[0][rows - start, theta[rows]]",
        "parts[0][rows - start, theta[rows - start]]",
        OF_ASSIGNED + "assigned_densities_are_entries_of_the_table[action]"),
    Bug("pairs of two trajectories", EVIDENCE, "self.trajectory[lag:] == self.trajectory[:-lag]",
        "self.trajectory[lag:] >= self.trajectory[:-lag]", OF_EVIDENCE + "trajectories_are_apart"),
    Bug("each lag counts once", EVIDENCE, "time += 2 * (first + second)", "time += first + second",
        OF_EVIDENCE + "the_time_is_that_of_the_errors[flipped-0.8]"),
    Bug("chance counts as correlation", EVIDENCE, "SURE * np.hypot(error, other)", "0.0",
        OF_EVIDENCE + "chance_takes_no_evidence_from_short_recordings"),
    Bug("the error of a correlation ignores the number of pairs", EVIDENCE, "np.linalg.norm(product) / scale",
        "self.square / self.square", OF_EVIDENCE + "the_time_is_that_of_the_errors[flipped-0.8]"),
    Bug("levels are weighed by their shares alone", EVIDENCE, "log_weight += np.log(law.shares)[:, None]",
        "log_weight = 0 * log_weight + np.log(law.shares)[:, None]",
        OF_EVIDENCE + "levels_and_backgrounds_have_scores_too[0.8]"),
    Bug("draws count alike however they foretold", FILTERING, "before = after - log_total", "before = 0 * after",
        OF_FILTERING + "draws_that_foretold_better_count_for_more_within_a_trajectory"),
    Bug("trajectories are foretold by those before", FILTERING, "log_total[:, r] if first[r] else so_far", "so_far",
        OF_FILTERING + "draws_that_foretold_better_count_for_more_within_a_trajectory"),
    Bug("the background is never served", LAWS, "counts[-1] = posterior.n_observations - counts.sum()", "pass",
        OF_FILTERING + "weights_are_drawn_given_the_counts_of_the_draw[0.3]"),
    Bug("arrival makes no difference when filtering", LAWS, "bool((self.keep_there != self.keep).any())", "False",
        OF_FILTERING + "subgoals_that_persist_are_filtered_as_the_sum_over_paths[there1-0.3]"),
    Bug("parameters before the checkpoint are lost", CHAINS, "self._parameters = [found] if self._sizes else []",
        "self._parameters = []", OF_POSTERIOR + "a_run_broken_off_goes_on_as_if_it_had_not_been[33]"),
    Bug("keeping only where one has arrived passes", KEEP, "if self.keep == 0 and self.keep_there not in (None, 0):",
        "if False:", OF_LEARNING + "keeping_only_where_one_has_arrived_is_refused"),
    Bug("weights may be too few", TABLE, "if values.ndim and values.shape != (count,):", "if False:",
        OF_NOISE + "bad_noise_is_named"),
    Bug("a loaded likelihood is without weights", ARCHIVE, "weight=self.weight, background=self.background",
        "background=self.background", OF_POSTERIOR + "a_file_gives_all_of_it_back[None-confidence0]"),
    Bug("the likelihood is not at the mean of the noise", ASSEMBLE,
        "likelihood if noise is None else noise.table(mean)", "likelihood",
        OF_POSTERIOR + "the_likelihood_is_at_the_mean_of_the_noise"),
    Bug("a confidence that was fixed is taken for one that was learned", AS_SAMPLED,
        'learned = isinstance(law, str) and law.split("(")[0] in models.__all__', "learned = isinstance(law, str)",
        OF_AS_SAMPLED + "a_confidence_that_was_not_learned_stays_with_the_table[7 numbers, checksum 12ab]"),
    Bug("noise that was learned is fixed when sampled again", AS_SAMPLED,
        '_read("confidence", law) if learned else None', "None", OF_AS_SAMPLED + "laws_of_confidence"),
    Bug("a model of time takes trajectories of one step each", "partition/protocol.py", "(np.diff(offset) < 2).all()",
        "(np.diff(offset) < 1).all()",
        "posterior/test_composed.py::test_models_of_time_refuse_trajectories_of_one_step_each"),
    Bug("a weight that has not settled passes for one that has", "irl/learn.py", "return weight, False",
        "return weight, True", "irl/test_learn.py::test_a_weight_that_does_not_settle_is_said_not_to_have"),
]  # fmt: skip
