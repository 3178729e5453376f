"""Small wrongs that somebody could write, and the test that must notice each; a text occurs once in its file."""

from __future__ import annotations

from tests.planted.bug import Bug
from tests.planted.companion_bugs import COMPANION_BUGS
from tests.planted.compare_bugs import COMPARE_BUGS
from tests.planted.continuous_bugs import CONTINUOUS_BUGS
from tests.planted.display_bugs import DISPLAY_BUGS
from tests.planted.dynamics_bugs import DYNAMICS_BUGS
from tests.planted.envelope_bugs import ENVELOPE_BUGS
from tests.planted.expertise_bugs import EXPERTISE_BUGS
from tests.planted.flight_bugs import FLIGHT_BUGS
from tests.planted.irl_bugs import ENTROPY_BUGS, MARGIN_BUGS
from tests.planted.learning_bugs import LEARNING_BUGS
from tests.planted.option_bugs import OPTION_BUGS
from tests.planted.persistence_bugs import PERSISTENCE_BUGS
from tests.planted.pose_bugs import POSE_BUGS
from tests.planted.prior_bugs import PRIOR_BUGS
from tests.planted.regression_bugs import REGRESSION_BUGS
from tests.planted.sampler_bugs import SAMPLER_BUGS
from tests.planted.sharded_bugs import SHARDED_BUGS
from tests.planted.streaming_bugs import STREAMING_BUGS
from tests.planted.summary_bugs import SUMMARY_BUGS
from tests.planted.teach_bugs import TEACH_BUGS
from tests.planted.temporal_bugs import STICKY_AND_GROUP_BUGS
from tests.planted.walk_bugs import WALK_BUGS
from tests.planted.world_bugs import WORLDS

BLOCKS, ALG4, COUNTS = "_kernels/collapsed_blocks.py", "_kernels/alg4.py", "_kernels/counts.py"
DIRECTIONS, SAMPLE, STORED = "_kernels/directions.py", "posterior/sample.py", "storage/archive.py"
ASSEMBLE, SEATING = "posterior/assemble.py", "_kernels/seating.py"
DRAWS_IN, PRIMITIVES = "_kernels/draws.py", "exact/test_draws.py::test_"
SITES = "exact/test_transition_collapsed_blocks.py::test_every_site_move_is_reversible[generic-5.0]"
MOVES = "exact/test_transition_collapsed_blocks.py::test_block_move_leaves_the_posterior_invariant[generic-1.0]"
TABLES = "exact/test_transition_alg4.py::test_corrected_site_moves_are_reversible_and_dish_moves_invariant[peaked-1.0]"
GEWEKE = "statistical/test_geweke.py::test_a_sweep_leaves_the_joint_law"
ACTIONS, NORMALISERS = "likelihood/test_action_comparison.py", "likelihood/test_normalisers.py"
SUBGOALS, SEGMENTS = "answers/test_subgoals.py", "answers/test_segments.py"
RESUME, STORAGE, DRAWS = "robustness/test_resume.py", "robustness/test_storage.py", "robustness/test_sample.py"
LAW = "posterior/test_posterior_law.py::test_what_a_posterior_says_of_itself_agrees"

SAMPLERS = [
    Bug("likelihood to the power 0.95 in site moves", BLOCKS, "held[j] * row[active[j]]",
        "held[j] * row[active[j]] ** 0.95", SITES),
    Bug("likelihood to the power 0.95 in block moves", BLOCKS, "below = sums[t, g] + log_prior[g] - peak",
        "below = 0.95 * sums[t, g] + log_prior[g] - peak", MOVES),
    Bug("counts keep their own observation", BLOCKS, "held[p] -= 1.0", "held[p] -= held[p] == 1.0", SITES),
    Bug("prior forgotten in block moves", BLOCKS, "below = sums[t, g] + log_prior[g] - peak",
        "below = sums[t, g] - peak", MOVES),
    Bug("concentration dropped in a birth", BLOCKS, "total = concentration", "total = 1.0",
        GEWEKE + "[collapsed_blocks]"),
    Bug("prior forgotten in a birth", BLOCKS, "work[g] = prior[g] * row[g]", "work[g] = row[g]", SITES),
    Bug("seat mass without the prior", BLOCKS, "mass = concentration * prior", "mass = concentration + 0 * prior",
        "exact/test_transition_collapsed_blocks.py::test_whole_shipped_sweep_leaves_the_posterior_invariant[generic-1.0]"),
    Bug("customers seated are not counted", SEATING, "seated[k] = before + 1", "seated[k] = before + (before < 2)",
        MOVES),
    Bug("a new table starts from the sum of an old one", SEATING, "sums[table, c] = 0.0", "sums[table, c] += 0.0",
        "exact/test_draws.py::test_rows_are_added_to_the_sums_of_their_tables"),
    Bug("seats not weighed by table size", DRAWS_IN, "target -= sizes[found]", "target -= 1.0",
        PRIMITIVES + "a_listed_table_is_chosen_by_its_size"),
    Bug("customers count themselves before they open a table", DRAWS_IN, "mass / seated", "mass / (seated + 1)",
        PRIMITIVES + "a_table_is_opened_with_the_chance_of_the_restaurant[1.0]"),
    Bug("a restaurant waits on after it has opened a table", DRAWS_IN, "waited[restaurant] = 1.0 - generator.random()",
        "waited[restaurant] = 1.0", PRIMITIVES + "a_table_is_opened_with_the_chance_of_the_restaurant[1.0]"),
    Bug("rounding draws what has no weight", DRAWS_IN, "range(count - 1, 0, -1)", "range(count - 1, count)",
        PRIMITIVES + "nothing_without_weight_is_drawn"),
    Bug("a singleton's candidate is drawn afresh", ALG4, "if alone and singleton_keeps:", "if False:", TABLES),
    Bug("table sizes include the customer", ALG4, "work[j] = size[order[j]] *",
        "work[j] = (size[order[j]] + (order[j] == slot)) *", TABLES),
    Bug("prior forgotten in dishes", ALG4, "exp(row[g] + log_prior[g] - peak) if product",
        "exp(row[g] - peak) if product", TABLES),
    Bug("constant dropped from the log joint", COUNTS, "lgamma(counts[g] + mass) - lgamma(mass)",
        "lgamma(counts[g] + mass)", LAW),
    Bug("a chain reuses a stream", "runtime/seeds.py", "spawn_key=identity", "spawn_key=()",
        DRAWS + "::test_chains_and_seeds_differ"),
    Bug("chains hang on how many there are", SAMPLE, "stream(settings.seed, k)",
        "stream(settings.seed, settings.chains - k)",
        DRAWS + "::test_chain_k_of_four_is_chain_k_of_eight"),
]  # fmt: skip
LIKELIHOODS = [
    Bug("normaliser dropped", DIRECTIONS, "-confidence[g] * sqrt(out[g]) - log_normaliser[g]",
        "-confidence[g] * sqrt(out[g])",
        ACTIONS + "::test_directions_against_the_oracle[weights]"),
    Bug("angle not wrapped", DIRECTIONS, "squared[g] += (gap - period[k] * np.rint(gap / period[k])) ** 2",
        "squared[g] += gap**2", ACTIONS + "::test_directions_against_the_oracle[angle]"),
    Bug("uniform rows not uniform", "likelihood/sources.py",
        "return each, normalisers.log_direction_normalisers(each, d), -normalisers.log_sphere_area(d)",
        "return each, normalisers.log_direction_normalisers(each, d), 0.0",
        ACTIONS + "::test_slow_pairs_are_uniform_and_counted"),
    Bug("prior forgotten in the marginal", DIRECTIONS, "total += exp(row[g] + log_prior[g] - peak)",
        "total += exp(row[g] - peak)", "likelihood/test_table.py::test_log_marginal_is_the_sum_over_candidates"),
    Bug("being there counts as a direction", DIRECTIONS, "limit = near * near", "limit = 0.0",
        ACTIONS + "::test_directions_against_the_oracle[weights]"),
    Bug("states not weighted", "likelihood/sources.py", "np.ascontiguousarray(states * weights)",
        "np.ascontiguousarray(states)", ACTIONS + "::test_directions_against_the_oracle[weights]"),
    Bug("measure of the sphere one dimension off", "likelihood/normalisers.py",
        "math.exp(-2 * confidence * math.sin(angle / 2)) * math.sin(angle) ** (dimension - 2)",
        "math.exp(-2 * confidence * math.sin(angle / 2)) * math.sin(angle) ** (dimension - 1)",
        NORMALISERS + "::test_two_dimensions_is_bessel_minus_struve"),
    Bug("a wrong term of the series", "likelihood/normalisers.py", "x**2 / 8", "x**2 / 6",
        NORMALISERS + "::test_series_and_closed_form_meet"),
    Bug("weights left out of the action normaliser", "likelihood/normalisers.py",
        "log_sphere_area(dimension) + radial - log_weights", "log_sphere_area(dimension) + radial",
        NORMALISERS + "::test_action_normaliser_in_one_and_two_dimensions"),
    Bug("the same confidence as before", "likelihood/table.py", "table = replace(self, confidence=confidence)",
        "table = self", "likelihood/test_table.py::test_confidence_can_be_changed_afterwards"),
    Bug("prior not normalised", "candidates/record.py", "values - total if abs(total) > ROUNDING else values", "values",
        "candidates/test_candidates.py::test_prior_is_normalised_and_uniform_by_default"),
    Bug("end points left out of the net", "candidates/places.py", "ends = np.arange(demonstrations.n_trajectories)",
        "ends = np.arange(0)", "candidates/test_candidates.py::test_net_covers_and_keeps_its_distance_and_every_end"),
]  # fmt: skip
RESULTS = [
    Bug("thinning off by one", "posterior/rounds.py",
        "((after + 1) % self._settings.thin == 0)", "(after % self._settings.thin == 0)",
        DRAWS + "::test_thin_and_warmup_choose_from_the_same_chain"),
    Bug("traces kept at the wrong sweeps", ASSEMBLE, "slice(settings.warmup + settings.thin - 1, None",
        "slice(settings.warmup, None", LAW),
    Bug("shares per chain", ASSEMBLE, "tally / joint.size", "tally / joint.shape[1]", LAW),
    Bug("last draw instead of the best", "posterior/chains.py", "if kept_joint.max() > self.best[0]:", "if True:",
        "posterior/test_chains.py::test_the_best_draw_is_kept_through_stretches_without_a_better_one"),
    Bug("budget ignored", "posterior/memory.py", 'budget = positive("memory_budget", budget)',
        'budget = 1e3 * positive("memory_budget", budget)', DRAWS + "::test_memory_is_refused_before_it_is_taken"),
    Bug("single linkage", "answers/subgoals.py", 'method="complete"', 'method="single"', SUBGOALS),
    Bug("credible set of 90 %", "answers/subgoals.py", "CREDIBLE = 0.95", "CREDIBLE = 0.9", SUBGOALS),
    Bug("counted without merging", "answers/subgoals.py", "counted = (per_draw >= COUNTED_FROM)",
        "counted = (per_draw > 0)", SUBGOALS),
    Bug("silent observations keep their label", "answers/segments.py", "np.where(silent, -1, np.arange(labels.size))",
        "np.arange(labels.size)", SEGMENTS),
    Bug("silent observations have a say", "answers/segments.py", "speaking if speaking.size else np.arange(start",
        "np.arange(start", SEGMENTS),
]  # fmt: skip
FILES = [
    Bug("checksum not compared", STORED, "if seal != _digest(text, arrays):", "if not seal:",
        STORAGE + "::test_arrays_changed_behind_the_checksum"),
    Bug("pickles opened", STORED, "allow_pickle=False", "allow_pickle=True",
        STORAGE + "::test_pickles_inside_are_not_opened"),
    Bug("bombs unpacked", STORED, "        _check_stored(path)\n", "",
        STORAGE + "::test_packed_bombs_are_refused_unopened[8]"),
    Bug("members may point elsewhere", STORED, ' or ".." in Path(member.filename).parts', "",
        STORAGE + "::test_members_that_point_elsewhere"),
    Bug("any kind of file will do", STORED, 'header.get("kind") != kind or ', "",
        STORAGE + "::test_wrong_kind_and_format"),
    Bug("the checkpoint before is not kept", STORED, "if keep_previous and path.exists():", "if False:",
        RESUME + "::test_torn_newest_checkpoint_gives_way_to_the_one_before"),
    Bug("files written in place", STORED, 'aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")',
        'aside = path.with_name(path.name)\n    keep_previous = False',
        RESUME + "::test_killed_inside_a_write[kill:3:half]"),
    Bug("generators of all chains restored from the first", "posterior/checkpoint.py", 'header["generators"][k]',
        'header["generators"][0]', RESUME + "::test_resuming_in_the_same_process[collapsed_blocks]"),
    Bug("the seed may change", "posterior/checkpoint.py", "if found.get(name) != wanted:",
        'if name != "seed" and found.get(name) != wanted:', RESUME + "::test_other_settings_are_refused_by_name"),
    Bug("checksum of the first row only", "posterior/checksum.py", "probe = source.values", "probe = source.values[:1]",
        RESUME + "::test_other_numbers_are_refused"),
    Bug("an interrupted run loses its checkpoint", SAMPLE, "complete = records[0].sweeps == settings.sweeps",
        "complete = True", RESUME + "::test_interrupted_runs_keep_their_checkpoint"),
    Bug("half of the draws given as all", "posterior/chains.py",
        'if len(held["draws"]) != len(self._sizes):', "if False:",
        RESUME + "::test_another_memory_budget_never_gives_half_of_the_draws"),
]  # fmt: skip
BUGS = [
    *SAMPLERS, *LIKELIHOODS, *RESULTS, *FILES, *WORLDS, *SAMPLER_BUGS, *COMPANION_BUGS, *LEARNING_BUGS,
    *PERSISTENCE_BUGS, *STICKY_AND_GROUP_BUGS, *SUMMARY_BUGS, *WALK_BUGS, *MARGIN_BUGS, *ENTROPY_BUGS,
    *PRIOR_BUGS, *COMPARE_BUGS, *SHARDED_BUGS, *ENVELOPE_BUGS, *REGRESSION_BUGS, *CONTINUOUS_BUGS, *DYNAMICS_BUGS,
    *OPTION_BUGS, *POSE_BUGS, *EXPERTISE_BUGS, *FLIGHT_BUGS, *STREAMING_BUGS, *TEACH_BUGS, *DISPLAY_BUGS,
]  # fmt: skip
