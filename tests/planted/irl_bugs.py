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
