"""Planted bugs in the sticky hidden Markov model, in groups of trajectories and in what is said of groups."""

from __future__ import annotations

from tests.planted.bug import Bug

HMM, HMM_LOOPS = "partition/sticky_hmm.py", "_kernels/sticky_hmm.py"
GROUPS, GROUP_LOOPS = "partition/groups.py", "_kernels/groups.py"
SHARED, ANSWERS = "partition/shared_weights.py", "answers/groups.py"
STICKY, GROUPED = "exact/test_transition_sticky_hmm.py::test_", "exact/test_transition_groups.py::test_"
JOINT = "statistical/test_geweke_models.py::test_a_"
SAID = "answers/test_groups.py::test_"

STICKY_AND_GROUP_BUGS = [
    Bug(
        "first steps are sticky's too",
        HMM_LOOPS,
        "        if j < g_count:\n            work[j] += sticky",
        "        work[min(j, g_count - 1)] += sticky",
        STICKY + "transitions_are_drawn_given_the_steps",
    ),
    Bug(
        "trajectories run on into each other",
        HMM_LOOPS,
        "if i + 1 == theta.size or first[i + 1]:",
        "if i + 1 == theta.size:",
        STICKY + "the_path_has_its_exact_law[generic]",
    ),
    Bug(
        "the backward draw forgets the filter",
        HMM_LOOPS,
        "work[j] = law[j] * into[j]",
        "work[j] = into[j]",
        STICKY + "the_path_has_its_exact_law[generic]",
    ),
    Bug(
        "tables of staying are not overridden",
        HMM_LOOPS,
        "own[g] += 1\n                            continue",
        "own[g] += 1",
        STICKY + "tables_have_their_exact_law[theta0-2.0-0.6]",
    ),
    Bug(
        "overrides without the shared weight",
        HMM_LOOPS,
        "work[0], work[1] = extra, base",
        "work[0], work[1] = extra, mass",
        STICKY + "tables_have_their_exact_law[theta0-2.0-0.6]",
    ),
    Bug(
        "whole candidates move without their prior",
        HMM_LOOPS,
        "+ lgamma(mass + drawn) - lgamma(mass)",
        "",
        STICKY + "moves_of_whole_candidates_leave_the_posterior_invariant[generic-3-4]",
    ),
    Bug(
        "whole candidates move onto others",
        HMM_LOOPS,
        "if shared[g] == 0 and mass > 0.0:",
        "if mass > 0.0:",
        STICKY + "moves_of_whole_candidates_leave_the_posterior_invariant[generic-3-4]",
    ),
    Bug(
        "rows of small shape lose their power",
        HMM_LOOPS,
        "-generator.standard_exponential() / shape[g]",
        "-generator.standard_exponential()",
        STICKY + "a_row_is_a_dirichlet_draw",
    ),
    Bug(
        "the slice on a + κ lacks its Jacobian",
        HMM,
        "prior.log_density(value) + x if",
        "prior.log_density(value) if",
        STICKY + "what_is_learned_has_its_posterior[6000]",
    ),
    Bug(
        "the slice on stickiness lacks its Jacobian",
        HMM,
        " + math.log(value) + math.log1p(-value)",
        "",
        STICKY + "what_is_learned_has_its_posterior[6000]",
    ),
    Bug(
        "first steps have the mass of later ones",
        HMM,
        "totals[-1, 0] = self.free",
        "totals[-1, 0] = self.mass",
        STICKY + "the_log_joint_is_that_of_all_that_is_drawn",
    ),
    Bug(
        "β stays as it was",
        HMM,
        "self.chain.concentration * self.prior + self.shared, self.chain.generator",
        "self.chain.concentration * self.prior, self.chain.generator",
        JOINT + "sweep_of_sticky_transitions_leaves_the_joint_law[1500]",
    ),
    Bug(
        "counts of a group keep their own observation",
        GROUP_LOOPS,
        "row[theta[i]] -= 1",
        "row[theta[i]] -= 0",
        GROUPED + "redrawing_observations_leaves_the_law_given_shared_weights[generic]",
    ),
    Bug(
        "groups share their seats",
        "partition/groups.py",
        "restaurant = self.group * weights.size + self.theta",
        "restaurant = 0 * self.group + self.theta",
        GROUPED + "seats_have_their_exact_law[theta2]",
    ),
    Bug(
        "seats of groups without the shared weight",
        "partition/groups.py",
        "np.tile(self.mass * weights,",
        "np.tile(self.mass + 0 * weights,",
        GROUPED + "seats_have_their_exact_law[theta1]",
    ),
    Bug(
        "tables move without the concentration",
        "partition/together.py",
        "prior, log_prior, chain.concentration, candidate,",
        "prior, log_prior, 1.0, candidate,",
        GROUPED + "moves_of_tables_leave_the_posterior_invariant[seats0-False]",
    ),
    Bug(
        "sizes of groups speak for a large mass",
        SHARED,
        "tables * log_mass + inside",
        "tables * log_mass - inside",
        GROUPED + "what_is_learned_has_its_posterior[4000]",
    ),
    Bug(
        "unused candidates are left out of the joint",
        SHARED,
        "if others.size and prior[others].sum() > 0:",
        "if False:",
        STICKY + "unused_candidates_count_as_one_in_the_log_joint",
    ),
    Bug(
        "shares of a group over all observations",
        ANSWERS,
        "counts[:, 1:] / sizes[:, None]",
        "counts[:, 1:] / own.size",
        SAID + "shares_and_differences_by_hand",
    ),
    Bug(
        "background counts as a place",
        ANSWERS,
        "np.append(found.listed_group, -1)",
        "found.listed_group",
        SAID + "background_and_unlisted_places_are_in_no_share",
    ),
    Bug(
        "equal shares count as smaller",
        ANSWERS,
        " + 0.5 * (first == second).mean(axis=0)",
        "",
        SAID + "nothing_hangs_on_labels",
    ),
]
