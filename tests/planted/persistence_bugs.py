"""Wrongs that somebody could write where subgoals persist, and the test that must notice each."""

from __future__ import annotations

from tests.planted.bug import Bug

LOOPS, SAMPLER = "_kernels/persistence.py", "partition/persistence.py"
OF = "exact/test_transition_persistence.py::"
PATH = OF + "test_the_path_has_its_exact_law"
RUNS = OF + "test_moves_of_runs_leave_the_posterior_invariant"
LONG = OF + "test_long_runs_reach_the_enumerated_posterior"

PERSISTENCE_BUGS = [
    Bug("likelihood to the power 0.95 in the filter", LOOPS, "out[r, g] *= relative[r, g]",
        "out[r, g] *= relative[r, g] ** 0.95", PATH),
    Bug("likelihood to the power 0.95 in runs", LOOPS, "row[g] += tile[r, g]", "row[g] += 0.95 * tile[r, g]", RUNS),
    Bug("a redraw that forgets to leave", LOOPS, "work[1] = leaving(law, at, keep, keep_there) * weights[following]",
        "work[1] = weights[following]", PATH),
    Bug("who is there is looked up a step early", LOOPS, "at = there[there_from[i + 1] : there_from[i + 2]]",
        "at = there[there_from[i] : there_from[i + 1]]", PATH),
    Bug("arriving changes nothing for the one that stays", LOOPS, "                    stay = keep_there",
        "                    stay = keep", PATH),
    Bug("trajectories run into each other", LOOPS, "if i + 1 == theta.size or first[i + 1]:", "if i + 1 == theta.size:",
        PATH),
    Bug("a run forgets that it was left on arrival", LOOPS, "before[g] += log_left", "before[g] += 0.0", RUNS),
    Bug("a run forgets that it was kept on arrival", LOOPS, "row[g] += log_kept", "row[g] += 0.0", RUNS),
    Bug("weights counted from every step", SAMPLER, "np.bincount(self.theta[self.redrawn], minlength",
        "np.bincount(self.theta, minlength", LONG),
    Bug("runs not moved back to their steps", SAMPLER, "theta, self._sums)[run])",
        "theta, self._sums)[np.minimum(run + 1, theta.size - 1)])", RUNS),
]  # fmt: skip
