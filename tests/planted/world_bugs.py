"""Small wrongs in discrete worlds: planning, the softmax likelihood, candidates, predictions, scores and options."""

from __future__ import annotations

from tests.planted.bug import Bug

PASSAGE, PLAN, GRID = "_kernels/first_passage.py", "mdp/planners/first_passage.py", "mdp/grids/grid.py"
SOFTMAX, PLANNED = "_kernels/softmax.py", "likelihood/planned_actions.py"
PREDICT, SCORES = "answers/predictions.py", "answers/scores.py"
VALUES = "mdp/test_first_passage.py::test_values_are_those_of_policy_iteration[{}-0.99-{}]"
CONTINUING, ABSORBING = VALUES.format({}, "continuing"), VALUES.format({}, "absorbing")
SCORED = "answers/test_scores.py"
TABLE = "likelihood/test_planned_actions.py"
WORLDS = [
    Bug("self-transitions discounted once", PASSAGE, "weight[entries] = discount * probability[k] * gain[rows]",
        "weight[entries] = discount * probability[k]", CONTINUING),
    Bug("a goal is only a goal while it pays", PASSAGE, "total = gain[r]", "total = 1.0", CONTINUING),
    Bug("the goal is not held", PASSAGE, "best[j] = 1.0 if pinned else", "best[j] = best[j] if pinned else", ABSORBING),
    Bug("the best of three rows forgets the third", PASSAGE, "c2, v2 = weight[third] if b - a > 2 else 0.0,",
        "c2, v2 = 0.0,", CONTINUING),
    Bug("the worst action", PASSAGE, "best[j] = sum3 if sum3 > best[j] else best[j]",
        "best[j] = sum3 if sum3 < best[j] or best[j] == 0.0 else best[j]", CONTINUING),
    Bug("no discount in action values", PASSAGE, "c, v = discount * probability[k], value[successor[k]]",
        "c, v = probability[k], value[successor[k]]", CONTINUING),
    Bug("illegal actions are worth nothing instead of being impossible", PASSAGE,
        "0.0 if offset[row] < offset[row + 1] else -np.inf", "0.0",
        VALUES.format({"illegal": True}, "continuing")),
    Bug("predecessors forgotten", PASSAGE, "            if last[t] != s:\n                last[t] = s\n",
        "            if last[t] < 0:\n                last[t] = s\n",
        "mdp/test_first_passage.py::test_predecessors_are_the_states_that_lead_there"),
    Bug("the goal is worth one", PLAN, "own, most = 1 / (1 - ahead), 1 / (1 - highest)",
        "own, most = np.ones_like(ahead), 1 / (1 - highest)", CONTINUING),
    Bug("a residual taken for an error", PLAN, "error = discount * (residual + rounding) / (1 - discount)",
        "error = discount * (residual + rounding)",
        "mdp/test_first_passage.py::test_the_error_bound_is_kept_where_values_settle_slowly"),
    Bug("the goal goes on after the episode", PLAN, "rows[at & np.isfinite(rows)] = 0.0", "pass", ABSORBING),
    Bug("columns of groups mixed up", PLAN, "self.value[:, group] = value[self.kept]",
        "self.value[:, np.sort(group)[::-1]] = value[self.kept]",
        "mdp/test_first_passage.py::test_values_do_not_depend_on_workers_or_on_what_else_is_asked"),
    Bug("slip turned the other way", GRID, "(action + k) % self.moves", "(action - k) % self.moves",
        "mdp/test_grid.py"),
    Bug("rows may be one percent off", "mdp/tabular.py", "ROW_TOLERANCE = 1e-8", "ROW_TOLERANCE = 0.02",
        "mdp/test_tabular.py::test_rows_that_do_not_sum_to_one"),
    Bug("trajectories hang on how many there are", "mdp/simulation.py", "generator = stream(seed, k)",
        "generator = stream(seed, trajectories - k)", "mdp/test_simulation.py"),
    Bug("likelihood of actions to the power 0.95", SOFTMAX, "out[i, g] = confidence * (table[actions[i], g] - peak[g])",
        "out[i, g] = 0.95 * confidence * (table[actions[i], g] - peak[g])",
        TABLE + "::test_probabilities_of_the_legal_actions_sum_to_one"),
    Bug("normalised without the confidence", SOFTMAX, "total[g] += exp(confidence * (table[a, g] - peak[g]))",
        "total[g] += exp(table[a, g] - peak[g])",
        TABLE + "::test_the_table_is_a_log_softmax_of_exact_action_values[10.0-continuing]"),
    Bug("states and actions exchanged", PLANNED, "code // mdp.n_actions, code % mdp.n_actions",
        "code // mdp.n_actions, (code + 1) % mdp.n_actions",
        TABLE + "::test_the_table_is_a_log_softmax_of_exact_action_values[10.0-continuing]"),
    Bug("illegal actions pass", PLANNED, "(~mdp.available[states,", "((actions < -9) & ~mdp.available[states,",
        TABLE + "::test_pairs_that_the_world_does_not_have"),
    Bug("successors without the visited", "candidates/states.py", "np.union1d(states, ahead)", "np.unique(ahead)",
        "likelihood/test_planned_actions.py::test_candidate_states"),
    Bug("prior forgotten in a prediction", PREDICT, "posterior.expected_shares * n + concentration * prior",
        "posterior.expected_shares * n + 0 * prior",
        "answers/test_predictions.py::test_mixture_is_the_average_over_the_draws_of_the_predictive"),
    Bug("the printed rule looks at the state", PREDICT, "score = (size[used] * policies[:, :, used]).sum(axis=1)",
        "score = (size[used] * policies[:, :, used]).max(axis=1)",
        "answers/test_predictions.py::test_the_printed_rule_takes_the_larger_cluster_where_the_smaller_is_surer"),
    Bug("waypoints never left", PREDICT, "stayed += int(there[i, at])", "stayed += 0",
        "answers/test_predictions.py::test_the_follower_turns_at_waypoints"),
    Bug("ties count in full", SCORES, "(1 - optimal[rows, actions] / optimal.sum(axis=1)).sum()",
        "(1 - optimal[rows, actions]).sum()",
        SCORED + "::test_a_constant_reward_scores_one_minus_one_over_actions"),
    Bug("natural logarithms called bits", SCORES, "np.log2(table", "np.log(table",
        SCORED + "::test_bits_per_decision"),
    Bug("chance not taken out of the Rand index", SCORES, "expected = rows * columns / max(comb(a.size, 2), 1)",
        "expected = 0.0", SCORED + "::test_adjusted_rand_by_pairs"),
    Bug("an option begins anywhere", "options/tabular.py", "(~option.initiation[first],", "(first < 0,",
        "options/test_tabular.py::test_bad_input"),
    Bug("an option does not end", "options/tabular.py", "legal = mdp.available & ~ends[:, None]",
        "legal = mdp.available & ~mdp.terminal[:, None]",
        "options/test_tabular.py::test_an_option_walks_straight_to_its_goal_and_ends_there"),
]  # fmt: skip
