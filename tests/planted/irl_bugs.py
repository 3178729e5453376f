"""Planted bugs in the methods that learn one reward."""

from __future__ import annotations

from tests.planted.bug import Bug

QP, EXPECTATIONS = "irl/margin_qp.py", "irl/expectations.py"
APPRENTICE, MARGIN, CLONING = "irl/apprenticeship.py", "irl/max_margin.py", "irl/cloning.py"
OF_QP, OF_EXPECTATIONS = "irl/test_margin_qp.py::test_", "irl/test_expectations.py::test_"
OF_APPRENTICE, OF_MARGIN = "irl/test_apprenticeship.py::test_", "irl/test_max_margin.py::test_"
OF_CLONING = "irl/test_cloning.py::test_"

MARGIN_BUGS = [
    Bug("losses of the margin program not rescaled", QP, "wanted * strength / scale**2", "wanted / scale**2",
        OF_QP + "the_conditions_of_an_optimum_hold[True-40-6-0.001]"),
    Bug("margin weights without the regulariser", QP, "weights = alpha @ table / strength", "weights = alpha @ table",
        OF_QP + "another_solver_finds_the_same_weights[0.1]"),
    Bug("losses of the margin program with the sign turned", QP, "rows, -losses, cones", "rows, losses, cones",
        OF_QP + "the_conditions_of_an_optimum_hold[True-1-1-1.0]"),
    Bug("demonstrations that break off are forgotten", EXPECTATIONS, 'left if tail == "held" else 0.0', "0.0 * left",
        OF_EXPECTATIONS + "demonstrations_that_break_off_stay_where_they_ended"),
    Bug("an end is collected for ever", EXPECTATIONS, "np.where(over, (1 - mdp.discount) * left,",
        "np.where(over, left,", OF_EXPECTATIONS + "demonstrations_that_end_collect_their_end_once"),
    Bug("discounting runs on over trajectories", EXPECTATIONS, "- np.repeat(pairs.offset[:-1], lengths)", "",
        OF_EXPECTATIONS + "demonstrations_that_break_off_stay_where_they_ended"),
    Bug("policies start anywhere", EXPECTATIONS, "expected_visits(self.mdp, policy, self.start)",
        "expected_visits(self.mdp, policy, np.full(self.start.size, 1 / self.start.size))",
        OF_EXPECTATIONS + "visits_of_a_policy_are_those_of_the_series"),
    Bug("weights in the wrong units", EXPECTATIONS, "weights / self.scale", "weights * self.scale",
        OF_EXPECTATIONS + "rewards_of_scaled_and_given_features_are_the_same"),
    Bug("shares of a mixture grow beyond one", APPRENTICE, "np.append((1 - step) * self.shares, step)",
        "np.append(self.shares, step)", OF_APPRENTICE + "the_mixture_has_the_visits_of_its_parts"),
    Bug("a mixture of actions, not of visits", APPRENTICE, "self.shares[:, None] * np.stack(self.visits)",
        "np.tile(self.shares[:, None], (1, len(self.newest)))",
        OF_APPRENTICE + "the_mixture_has_the_visits_of_its_parts"),
    Bug("half of what no mixture can take off", APPRENTICE, "max(0.0, float(best @ self.weights))",
        "max(0.0, 0.5 * float(best @ self.weights))", OF_APPRENTICE + "at_the_nearest_point_no_policy_is_nearer"),
    Bug("planning against the loss", MARGIN, "reward + self.loss))", "reward - self.loss))",
        OF_MARGIN + "the_policy_of_a_linear_reward_is_recovered_where_it_was_shown[cutting_plane]"),
    Bug("the loss stays in the reward", MARGIN, "optimal_policy(made.mdp, reward))",
        "optimal_policy(made.mdp, reward + self.loss))",
        OF_MARGIN + "the_policy_is_optimal_for_the_reward_without_the_loss"),
    Bug("the dual without its square", MARGIN, "mixed = after / self.mass", "mixed = 0 * after / self.mass",
        OF_MARGIN + "bounds_of_the_subgradient_method_are_below_the_optimum"),
    Bug("the last step for the best", MARGIN, "if value < self.objective:", "if True:",
        OF_MARGIN + "of_all_steps_that_of_the_least_objective_is_returned"),
    Bug("where walks ended counts as not visited", MARGIN,
        "np.concatenate([demonstrator.pairs.states, demonstrator.pairs.final])", "demonstrator.pairs.states",
        OF_MARGIN + "states_where_a_walk_ended_carry_no_loss"),
    Bug("a prior on illegal actions", CLONING, "* mdp.available", "* np.ones(mdp.available.shape)",
        OF_CLONING + "policies_are_counts_and_a_prior_for_each_legal_action"),
]  # fmt: skip

SOFT, FLOW, CAUSAL = "mdp/planners/soft.py", "mdp/planners/flow.py", "irl/causal_objective.py"
TRAJECTORY, PATHS, ENTROPY = "irl/trajectory_objective.py", "_kernels/paths.py", "irl/max_entropy.py"
OF_SOFT, OF_ENTROPY = "mdp/planners/test_soft.py::test_", "irl/test_max_entropy.py::test_"
OF_OBJECTIVES = "irl/test_entropy_objectives.py::test_"

ENTROPY_BUGS = [
    Bug("soft values without the temperature", SOFT, "peak + temperature * np.log(total)", "peak + np.log(total)",
        OF_SOFT + "values_and_policies_are_those_of_plain_recursion[0]"),
    Bug("the bound of soft values is the change of a sweep", SOFT, "(modulus * last.change + floor) / (1 - modulus)",
        "modulus * last.change + floor", OF_SOFT + "the_bound_is_attained_with_one_state"),
    Bug("soft values at discount 1 are taken on trust", SOFT, "if not ((under - slack >= low)[inner].all()",
        "if False and not ((under - slack >= low)[inner].all()",
        OF_SOFT + "at_discount_1_no_bound_is_claimed_that_does_not_hold"),
    Bug("visits are not discounted", FLOW, "- mdp.discount * self.transition", "- 0.9 * self.transition",
        OF_SOFT + "visits_sum_to_the_horizon_and_flow[1-0.5]"),
    Bug("visits flow backwards", FLOW, "Flow(mdp, table).forwards(first)", "Flow(mdp, table).backwards(first)",
        OF_SOFT + "visits_sum_to_the_horizon_and_flow[1-0.5]"),
    Bug("expected visits are those of all states, not of the pairs", CAUSAL, "forwards(self.on_value)",
        "forwards(-self.on_reward)", OF_OBJECTIVES + "causal_gradients_are_exact[likelihood-0.9-False-0.0]"),
    Bug("a trajectory that was cut off is over", CAUSAL, "mdp.matrix.T @ cut - begun",
        "0 * (mdp.matrix.T @ cut) - begun",
        OF_ENTROPY + "visits_of_the_policy_found_match_those_shown_at_the_discount_of_the_world[0.9]"),
    Bug("visits shown are not discounted", CAUSAL, "mdp.discount ** time.astype(float)", "1.0 ** time.astype(float)",
        OF_ENTROPY + "visits_of_the_policy_found_match_those_shown_at_the_discount_of_the_world[0.9]"),
    Bug("the penalty has twice its gradient", CAUSAL, "(self.on_reward + flow) - self.l2 * weights",
        "(self.on_reward + flow) - 2 * self.l2 * weights",
        OF_OBJECTIVES + "causal_gradients_are_exact[likelihood-0.9-False-0.7]"),
    Bug("the last state of a trajectory is not paid", PATHS, "out[steps, state] = fade[steps] * reward[state]",
        "out[steps, state] = 0.0", OF_OBJECTIVES + "the_likelihood_of_trajectories_is_that_of_enumeration[1.0-True]"),
    Bug("rewards of trajectories do not fade", PATHS, "out[t, state] = fade[t] * reward[state] + peak",
        "out[t, state] = reward[state] + peak",
        OF_OBJECTIVES + "the_likelihood_of_trajectories_is_that_of_enumeration[0.6-True]"),
    Bug("sums over trajectories without logs", PATHS, "peak = ahead if ahead > peak else peak",
        "peak = 0.0 if ahead > peak else peak", OF_OBJECTIVES + "longer_weights_than_doubles_hold_do_no_harm"),
    Bug("all trajectories are as long as the longest", TRAJECTORY, "pairs.starts[length == n]", "pairs.starts",
        OF_OBJECTIVES + "the_likelihood_of_trajectories_is_that_of_enumeration[1.0-True]"),
    Bug("last states that are not known count as if they were", TRAJECTORY, "pairs.final) > 0", "pairs.final) >= 0",
        OF_OBJECTIVES + "the_likelihood_of_trajectories_is_that_of_enumeration[1.0-False]"),
    Bug("pairs without order pass for trajectories", ENTROPY, "    if not pairs.ordered:\n        raise",
        "    if False:\n        raise", OF_ENTROPY + "trajectories_need_pairs_in_order"),
    Bug("a constant reward is undetermined where episodes end", "irl/single_reward.py", "if mdp is not None:",
        "if False and mdp is not None:", OF_ENTROPY + "no_policy_depends_on_undetermined_directions[ending]"),
    Bug("a search that was cut short passes for converged", "irl/ascent.py", "if steps.slope(weights) <= tolerance:",
        "if steps.slope(weights) <= 1:", OF_ENTROPY + "ctrl_c_gives_back_what_was_found_and_limits_are_said"),
]  # fmt: skip
