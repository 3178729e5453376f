"""Small wrongs in the deterministic companions of the mixture: convex weights, mean field, assignment, score test."""

from __future__ import annotations

from tests.planted.bug import Bug

WEIGHTS, NEWTON, SCREEN = "partition/convex_weights.py", "partition/simplex_newton.py", "partition/screening.py"
FIELD, COLUMNS = "partition/mean_field.py", "_kernels/columns.py"
SEARCH, BOUND, LOOPS = "partition/local_search.py", "partition/map_bound.py", "_kernels/local_search.py"
CONVEX, MEAN = "partition/test_convex_weights.py", "partition/test_mean_field.py"
MAP, SCORE = "partition/test_map_partition.py", "partition/test_score_test.py"
IDLE = CONVEX + "::test_no_candidate_of_some_optimum_is_ever_proved_idle"
LOW = MAP + "::test_the_bound_holds_when_it_aims_too_low"
COMPANION_BUGS = [
    Bug("the gap is taken over the support alone", WEIGHTS, "return max(float(self.gradient.max()) / self.n - 1, 0.0)",
        "return max(float(self.gradient[self.names[self.names >= 0]].max(initial=1.0)) / self.n - 1, 0.0)",
        CONVEX + "::test_the_bound_holds_however_early_the_search_ends"),
    Bug("the gap of half the observations", WEIGHTS, "gap = self.n * math.log1p(self.excess)\n",
        "gap = 0.5 * self.n * math.log1p(self.excess)\n",
        CONVEX + "::test_the_bound_holds_however_early_the_search_ends"),
    Bug("rows are not scaled back", WEIGHTS, "fitted = np.log(self.fitted) + self.table.peak",
        "fitted = np.log(self.fitted)",
        CONVEX + "::test_the_optimum_and_its_bound_against_an_interior_point_solver"),
    Bug("no multiplier for the sum of the weights", NEWTON, "hessian, 2 * slope - n, x",
        "hessian, 2 * slope, x",
        CONVEX + "::test_the_optimum_and_its_bound_against_an_interior_point_solver"),
    Bug("weights below zero are cut, not walked to", NEWTON, "        falls = free & (wanted <= 0)",
        "        wanted = np.maximum(wanted, 0.0)\n        falls = free & (wanted < 0)",
        CONVEX + "::test_the_quadratic_step_satisfies_its_own_conditions"),
    Bug("one half of the curvature is lost", "_kernels/convex.py", "                whole[g, h + 1] += ab\n", "",
        CONVEX + "::test_curvature_is_that_of_the_ratios"),
    Bug("screening forgets the second order", SCREEN, "np.sqrt(2 * gap * spread)", "0.0 * spread", IDLE),
    Bug("screening with a tenth of the spread", SCREEN, "np.sqrt(2 * gap * spread)", "0.1 * np.sqrt(gap * spread)",
        IDLE),
    Bug("screening that proves nothing", SCREEN, "gap * np.maximum(largest - mean, 0.0)", "n * (largest > 0)",
        CONVEX + "::test_most_candidates_are_proved_idle_near_the_optimum"),
    Bug("largest ratios of the last block only", "partition/scaled_table.py", "np.max([p[1] for p in parts], axis=0)",
        "parts[-1][1] * 0.0", CONVEX + "::test_a_tiled_table_gives_the_same_answer"),
    Bug("the evidence bound without its divergence", FIELD, "trace.append(fit - _divergence(mass, counts))",
        "trace.append(fit)", MEAN + "::test_the_bound_is_below_the_evidence_and_near_it"),
    Bug("weights by their logarithm of the mean", FIELD, "log_weight = digamma(mass + counts) - digamma(mass.sum() + ",
        "log_weight = np.log(mass + counts) - np.log(mass.sum() + ",
        MEAN + "::test_the_bound_is_below_the_evidence_and_near_it"),
    Bug("the prior is counted twice", FIELD, "counts = ahead", "counts = ahead + mass",
        MEAN + "::test_the_bound_never_falls"),
    Bug("column sums lose what was before a new peak", COLUMNS, "total[g] = total[g] * exp(peak[g] - value) + 1.0",
        "total[g] = 1.0", SCORE + "::test_derivatives_are_those_of_differences"),
    Bug("the score against the mean, not the sum", "partition/score_test.py", "axis=0) - np.log(n)",
        "axis=0) - np.log(n + 1)",
        SCORE + "::test_the_confidence_at_which_a_second_atom_helps_is_that_of_brute_force"),
    Bug("a mover counts itself", LOOPS, "tile[r, old] + log(counts[old] - 1 + mass[old]) + least",
        "tile[r, old] + log(counts[old] + mass[old]) + least", MAP + "::test_single_moves_go_on_until_none_gains"),
    Bug("nothing is opened", SEARCH, "if not self._merge() and not self._grow()", "if not self._merge()",
        MAP + "::test_a_candidate_is_opened_for_those_who_gain_together"),
    Bug("a merger is not refunded", SEARCH, "self._rise(self.counts[None], size) - left[:, None]",
        "self._rise(self.counts[None], size) - 2 * left[:, None] - 9.0",
        MAP + "::test_a_whole_candidate_moves_to_a_better_one"),
    Bug("sets of the bound cost one too many", LOOPS, "total += surplus[order[m]] + log(m + mass[g])",
        "total += surplus[order[m]] + log(m + mass[g]) - 0.01", LOW),
    Bug("the bound cuts what it needs", LOOPS, "least = -log(n - 1 + mass[g])", "least = 0.0", LOW),
    Bug("the corner of the prior is the smallest", BOUND, "(gammaln(n + mass) - gammaln(mass)).max()",
        "(gammaln(n + mass) - gammaln(mass)).min()", MAP + "::test_the_bound_without_lagrangian_steps_holds"),
]  # fmt: skip
