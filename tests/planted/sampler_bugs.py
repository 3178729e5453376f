"""Small wrongs in the samplers ``blocked``, ``collapsed``, ``cluster_collapsed``, ``split_merge`` and ``tempered``."""

from __future__ import annotations

from tests.planted.bug import Bug

BLOCKED, CLUSTERS, TABLES = "_kernels/blocked.py", "_kernels/clusters.py", "_kernels/cluster_collapsed.py"
COLLAPSED, PAIRS, LEVELS = "_kernels/collapsed.py", "_kernels/split_merge.py", "_kernels/tempered.py"
EXACT, COMPILED = "exact/test_transition_samplers.py::", "exact/test_compiled_samplers.py::"
DIRICHLET = EXACT + "test_weights_are_dirichlet[0.05-counts1]"
GIVEN = EXACT + "test_observations_given_weights_are_drawn_exactly"
SITES = EXACT + "test_cluster_sites_are_reversible_and_sweeps_invariant"
SPLITS = EXACT + "test_split_merge_is_reversible"
SWAPS = EXACT + "test_swaps_of_levels_are_reversible[0-generic]"

SAMPLER_BUGS = [
    Bug("weights without the prior", BLOCKED, "shape = concentration * prior[g] + counts[g]",
        "shape = concentration + counts[g]", DIRICHLET),
    Bug("power of the uniform forgotten", BLOCKED, "generator.standard_exponential() / shape",
        "generator.standard_exponential()", DIRICHLET),
    Bug("underflow taken for a weight", BLOCKED, "if mass > SMALLEST:", "if True:",
        GIVEN + "[walled-all but one too small]"),
    Bug("candidates left out too early", BLOCKED, "tail[count] > VANISHING * mass", "tail[count] > 0.5 * mass",
        GIVEN + "[generic-uneven]"),
    Bug("rows shifted by one", COLLAPSED, "redraw_rows(0, relative, theta", "redraw_rows(0, relative[1:], theta",
        EXACT + "test_collapsed_sweeps_leave_the_posterior_invariant[generic]"),
    Bug("impossible rows taken from sums", CLUSTERS, "if row[g] == -np.inf:", "if False:", SITES + "[walled-1.0]"),
    Bug("prior forgotten in a cluster's mass", CLUSTERS, "below = sums[g] + log_prior[g] - peak",
        "below = sums[g] - peak", SITES + "[generic-1.0]"),
    Bug("clusters not weighed by size", TABLES, "work[j] = size[other] * relative_gain(spare_held",
        "work[j] = relative_gain(spare_held", SITES + "[generic-1.0]"),
    Bug("an observation stays in its cluster's mass", TABLES, "add_row(row, -1, spare_sums, spare_walls)",
        "add_row(row, 0, spare_sums, spare_walls)", SITES + "[generic-1.0]"),
    Bug("concentration dropped in a new cluster", TABLES, "work[k] = concentration", "work[k] = 1.0",
        SITES + "[generic-5.0]"),
    Bug("a cluster that lost an observation keeps its share", TABLES, "share[slot] = spare_share",
        "share[slot] = share[slot]", SITES + "[peaked-1.0]"),
    Bug("sums of the sweep before are kept", TABLES, "fresh[:] = 0.0", "fresh[:] = fresh",
        COMPILED + "test_traces_are_those_of_the_assignments[cluster_collapsed]"),
    Bug("walls of the sweep before are kept in tiles", "partition/cluster_collapsed.py",
        "fresh[:], fresh_walls[:] = 0.0, 0", "fresh[:] = 0.0",
        COMPILED + "test_tiled_table_gives_the_draws_of_the_whole_one[cluster_collapsed-walled]"),
    Bug("one side's size forgotten", PAIRS, "lgamma(sizes[0]) + lgamma(sizes[1])", "lgamma(sizes[0])",
        SPLITS + "[generic-1.0]"),
    Bug("probability of the proposal forgotten", PAIRS, "- together - log_proposal", "- together",
        SPLITS + "[generic-1.0]"),
    Bug("concentration forgotten in a split", PAIRS, "log(concentration) + lgamma", "lgamma", SPLITS + "[generic-5.0]"),
    Bug("a merge does not ask for the present split", PAIRS, "side_of, wanted, a != b, sizes",
        "side_of, wanted, False, sizes", SPLITS + "[generic-1.0]"),
    Bug("an observation is paired with itself", PAIRS, "work[first] = 0.0", "work[first] = 1.0",
        SPLITS + "[generic-1.0]"),
    Bug("the last table keeps its number", PAIRS, "elif table_of[i] == last:", "elif False:", SPLITS + "[generic-1.0]"),
    Bug("levels exchanged the wrong way", LEVELS, "(fits[b] - fits[a])", "(fits[a] - fits[b])", SWAPS),
    Bug("power of the other level forgotten", LEVELS, "(powers[a] - powers[b])", "powers[a]", SWAPS),
    Bug("log likelihoods stay behind", LEVELS, "fits[a], fits[b] = fits[b], fits[a]", "pass", SWAPS),
    Bug("levels not as hot as stated", "partition/tempered.py", "np.multiply(dense, beta,",
        "np.multiply(dense, beta**0.9,", EXACT + "test_each_level_keeps_its_own_law[1]"),
    Bug("hotter levels stored one off", "partition/tempered.py", '"hotter": theta[1:]', '"hotter": theta[:-1]',
        COMPILED + "test_a_chain_goes_on_from_its_state_bit_for_bit[tempered]"),
]  # fmt: skip
