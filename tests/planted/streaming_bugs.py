"""Small wrongs in what is learned while data come."""

from __future__ import annotations

from tests.planted.bug import Bug

LOOPS, TRACK, TABLE = "_kernels/streaming.py", "streaming/track.py", "streaming/table.py"
CHAINS, DRAWS, DOOR, FOLLOWING = "streaming/chains.py", "streaming/draws.py", "streaming/door.py", "cli/following.py"
MOVES, PAIRS, ROWS = (f"streaming/test_{name}.py::test_" for name in ("kernels", "demonstrations", "table"))
EXACT, SAYS, BAD = (f"streaming/test_{name}.py::test_" for name in ("exact", "stream", "bad_input"))
PIECES = "streaming/trajectories.py"
INVARIANT, LIVE = MOVES + "moves_leave_the_posterior_as_it_is", EXACT + "chains_are_near_the_posterior_without_a_sweep"
AS_BATCH = ROWS + "the_table_is_that_of_action_comparison_after_every_pair"

STREAMING_BUGS = [
    Bug("nobody of a streamed table sits alone", LOOPS, "seated - here + mass[own]", "seated - here",
        INVARIANT + "[move a table-generic-1.0]"),
    Bug("a streamed table minds no prior", LOOPS, "below = sums[g] + log_prior[g] - peak",
        "below = sums[g] - peak", INVARIANT + "[move a table-generic-1.0]"),
    Bug("some pairs are redrawn by the rows of others", LOOPS, "redraw_rows(0, relative,",
        "redraw_rows(0, relative[::-1],", INVARIANT + "[redraw some-generic-1.0]"),
    Bug("samples are settled too soon", TRACK, "settled = int(np.ceil(", "settled = 1 + int(np.ceil(",
        PAIRS + "pairs_are_given_as_soon_as_they_are_sure[20.0-2]"),
    Bug("half a window will do", TRACK, "len(times) - (self._window - self._window // 2)",
        "len(times) - self._window // 2", PAIRS + "pairs_are_given_as_soon_as_they_are_sure[20.0-5]"),
    Bug("velocities begin anew with every sample", TRACK, "first = max(start - self._window // 2, 0)",
        "first = start", PAIRS + "pairs_are_given_as_soon_as_they_are_sure[None-2]"),
    Bug("what is known at the end changes nothing", TABLE, "if not changed.size:", "if True:",
        PAIRS + "samples_that_lie_on_the_grid_stay_what_they_were"),
    Bug("coarse clocks are not minded", "demonstrations/recordings.py", "or not grid[-1] < times[-1]:", "or False:",
        "demonstrations/test_recordings.py::"
        "test_seconds_since_1970_are_so_coarse_that_the_end_may_be_a_resampling_time"),
    Bug("what went round once comes back", TRACK, "self._turned[wraps] += ", "self._turned[wraps] = ",
        "streaming/test_angles.py::test_pairs_are_those_of_the_whole_recording[from 0-20.0-2]"),
    Bug("rows that become slow stay", TABLE, "np.union1d(changed, new)", "np.asarray(new)",
        ROWS + "pairs_become_slow_and_quick_again_as_the_median_speed_moves"),
    Bug("standing still counts in the median speed", TABLE, "if speed[0] > 0:", "if True:",
        ROWS + "a_pair_that_does_not_move_is_slow_from_the_first"),
    Bug("an end must be far from the others", TABLE, "0.0 if is_end else self._radius", "self._radius",
        ROWS + "an_end_is_a_candidate_however_near_the_others"),
    Bug("old pairs know nothing of new candidates", TABLE, "        if n:\n            alone",
        "        if not n:\n            alone", AS_BATCH + "[plain]"),
    Bug("the newest pair is not drawn", CHAINS, "np.arange(n - 1, older - 1, -1)", "np.arange(n - 2, older - 1, -1)",
        LIVE + "_of_their_own"),
    Bug("streams expect more subgoals than asked", CHAINS, "theta, prior, concentration, generator)",
        "theta, prior, 3 * concentration, generator)", LIVE + "_of_their_own"),
    Bug("draws of late lack the newest pair", CHAINS, "if k == 0:", "if k < 0:",
        SAYS + "draws_of_late_hold_every_pair_and_only_candidates_there_are"),
    Bug("all chains of a stream are one", CHAINS, "stream(seed, k) for", "stream(seed, 0) for", SAYS + "chains_differ"),
    Bug("shares of late are of other candidates", DRAWS, "used[few.indices]", "few.indices",
        SAYS + "shares_of_late_are_those_of_the_draws"),
    Bug("a time may come again", DOOR, "if not when > before:", "if not when >= before:",
        BAD + "a_bad_sample_is_refused_and_changes_nothing[a time again]"),
    Bug("pieces before a gap have ended", PIECES, "self._close(stop, end, truncated=True)",
        "self._close(stop, end, truncated=False)", PAIRS + "gaps_cut_as_in_the_whole_recording[20.0-2]"),
    Bug("dropped pieces are not counted in names", PIECES, "self._pieces.append(self._cuts)",
        "self._pieces.append(len(self._pieces))", PAIRS + "a_piece_of_one_sample_is_dropped_and_counted"),
    Bug("velocities bridge a gap", DOOR, "is_cut = len(track) > 0 and when - track.last[0] > max_gap",
        "is_cut = len(track) > 1000 and when - track.last[0] > max_gap",
        PAIRS + "gaps_cut_as_in_the_whole_recording[None-2]"),
    Bug("lines with too many fields are read", "streaming/rows.py", "if len(fields) != self.width:",
        "if len(fields) < self.width:", "streaming/test_lines.py::test_a_line_that_is_no_sample_is_told"),
    Bug("trajectories come back", FOLLOWING, "            self._over.add(self._trajectory)\n", "",
        "cli/test_follow.py::test_bad_lines_are_told_and_left_out"),
]  # fmt: skip
