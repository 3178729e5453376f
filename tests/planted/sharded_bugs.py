"""Small wrongs in shards and in sampling them."""

from __future__ import annotations

from tests.planted.bug import Bug

LOOPS, SWEEP, FILES = "_kernels/shard_rows.py", "partition/sharded_blocked.py", "storage/shards.py"
EXACT, HELD = "exact/test_sharded_blocked.py::test_", "likelihood/test_shards.py::test_"
DRAWS = "posterior/test_sharded.py::test_"
OWN = EXACT + "chains_sweeps_seeds_and_blocks_have_uniform_numbers_of_their_own"
ORACLE = EXACT + "draws_and_sums_are_those_of_the_oracle"
DIRECTIONS = EXACT + "shares_of_directions_are_those_of_the_oracle[3.0]"

SHARDED_BUGS = [
    Bug("shares too small for a number are lost", LOOPS, "if below >= lowest else below",
        "if below >= lowest else -np.inf", ORACLE + "[5-<f4]"),
    Bug("sums that lost terms are drawn from", LOOPS, "if mass > least[c]:", "if mass > 0.0:", ORACLE + "[33-<f4]"),
    Bug("a chunk is skipped too late", LOOPS, "target >= partial[k]:", "target >= 2.0 * partial[k]:",
        ORACLE + "[100-<f8]"),
    Bug("small shares left out of the sum", LOOPS, "total += log(share) if share > 0.0 else share", "total += 0.0",
        ORACLE + "[33-<f8]"),
    Bug("a product of shares is dropped", LOOPS, "fits[c] += total + log(product)", "fits[c] += total",
        ORACLE + "[2-<f8]"),
    Bug("being there counts as a direction of shards", LOOPS, "uniform if dx * dx + dy * dy <= limit else shares[r, g]",
        "shares[r, g]", DIRECTIONS),
    Bug("a wrong term of the series of shares", LOOPS, "-1 / 5040", "-1 / 5400", DIRECTIONS),
    Bug("one halving too few", LOOPS, "for _ in range(halvings):", "for _ in range(halvings - 1):", DIRECTIONS),
    Bug("streams hang on the part of the file", SWEEP, "part.first_block + start // BLOCK", "start // BLOCK",
        DRAWS + "the_division_into_files_and_the_workers_have_no_say[7-1-threading]"),
    Bug("chains share their uniform numbers", SWEEP, "stream(seed, c, sweep,", "stream(seed, 0, sweep,",
        OWN),
    Bug("every sweep has the uniform numbers of the first", SWEEP, "stream(seed, c, sweep,", "stream(seed, c, 0,", OWN),
    Bug("weights left out that are not negligible", SWEEP, "> NEGLIGIBLE).sum())", "> 1e3 * NEGLIGIBLE).sum())",
        EXACT + "weights_are_left_out_where_most_are_negligible_and_only_there"),
    Bug("what was left out is forgotten", SWEEP, "LOST * after[:, size]", "0.0 * after[:, size]",
        EXACT + "rows_that_the_large_weights_do_not_settle_are_drawn_over_all"),
    Bug("rows left over keep the numbers of the first", SWEEP, "uniforms[one, rows]", "uniforms[one, : rows.size]",
        EXACT + "rows_that_the_large_weights_do_not_settle_are_drawn_over_all"),
    Bug("the last part of a file is left out", SWEEP, "range(0, blocks[k], largest), blocks[k]]",
        "range(0, blocks[k], largest)]", DRAWS + "the_division_into_files_and_the_workers_have_no_say[1-2-threading]"),
    Bug("rows that no weight allows pass", SWEEP, "if not np.isfinite(fits).all():", "if np.isinf(fits).any():",
        DRAWS + "weights_below_every_number_are_told_and_not_drawn"),
    Bug("weights run on when a sweep is lost", "posterior/sharded_chains.py", "copy.deepcopy(self.generator)",
        "self.generator", "posterior/test_sharded_stopping.py::test_a_sweep_that_fails_leaves_the_chains_as_they_were"),
    Bug("the likelihood of shards without their maxima", "posterior/sharded.py", "(fit + shards.peaks) * UNIT",
        "fit * UNIT", DRAWS + "without_evidence_the_posterior_is_the_prior"),
    Bug("draws of shards kept one sweep early", "posterior/sharded.py", "after > 0 and after % settings.thin == 0",
        "after >= 0 and after % settings.thin == 0", DRAWS + "what_is_said_of_places_is_what_the_draws_say"),
    Bug("inclusion by the draws of one chain", "posterior/sharded_posterior.py", "found / self.log_joint.size",
        "found / self.log_joint.shape[1]", DRAWS + "what_is_said_of_places_is_what_the_draws_say"),
    Bug("the uniform density of shards without the normaliser", "likelihood/shards.py",
        "math.exp(log_z - normalisers.log_sphere_area(2))", "math.exp(-normalisers.log_sphere_area(2))",
        HELD + "directions_give_the_density_of_the_library"),
    Bug("slow pairs of shards keep their direction", "likelihood/shards.py",
        "source.units[part] * ~source.slow[part, None]", "source.units[part]",
        HELD + "a_stream_of_positions_and_actions_is_the_same_shards"),
    Bug("checksums of shards not compared", FILES, "if verify and file_digest(path) != told.sha256:", "if False:",
        HELD + "a_changed_file_is_named"),
    Bug("the manifest may be changed", FILES, 'if said.pop("seal", None) != _seal(said):',
        'if said.pop("seal", None) is None:', HELD + "another_version_and_a_changed_manifest_are_told"),
    Bug("an unfinished folder has a manifest", FILES, "        if kind is None:\n", "        if True:\n",
        HELD + "an_unfinished_folder_is_none"),
    Bug("silence is waited for", "runtime/cluster.py", 'if answer != "Scheduler":', 'if answer == "Worker":',
        "runtime/test_cluster.py::test_nobody_there_is_refused_in_time"),
    Bug("errors lose their words between processes", "runtime/errors.py", "error.__dict__.update(said)",
        "error.__dict__.update({})", "runtime/test_errors.py"),
]  # fmt: skip
