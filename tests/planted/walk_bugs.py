"""Planted bugs in Bayesian inverse reinforcement learning."""

from __future__ import annotations

from tests.planted.bug import Bug

RANKS, WALK = "_kernels/rank_updates.py", "_kernels/policy_walk.py"
CHAIN, BAYESIAN, FOUND = "irl/reward_walk.py", "irl/bayesian.py", "irl/reward_posterior.py"
OF_WALK, OF_BAYESIAN = "irl/test_reward_walk.py::test_", "irl/test_bayesian.py::test_"
REVERSIBLE = OF_WALK + "a_step_is_reversible"

WALK_BUGS = [
    Bug("corrections with the sign turned", RANKS, "value[s] -= weight * column[s]", "value[s] += weight * column[s]",
        OF_WALK + "the_same_steps_are_accepted_as_where_every_world_is_solved_anew[400]"),
    Bug("one improvement is enough", RANKS, "            return count + 1", "            break\n        break",
        OF_WALK + "the_same_steps_are_accepted_as_where_every_world_is_solved_anew[400]"),
    Bug("the base keeps its policy", RANKS, "base.policy[rows[i]] = policy[rows[i]]", "pass",
        OF_WALK + "changes_of_base_and_fresh_inverses_change_no_value"),
    Bug("responses are not corrected", RANKS, "    if linear:\n", "    if False:\n",
        OF_WALK + "changes_of_base_and_fresh_inverses_change_no_value"),
    Bug("the inverse is not turned", WALK, "np.linalg.inv(system).T", "np.linalg.inv(system)",
        OF_WALK + "changes_of_base_and_fresh_inverses_change_no_value"),
    Bug("the prior is left out of the ratio", WALK, "(likelihood - walk.numbers[0] + gain)",
        "(likelihood - walk.numbers[0])", REVERSIBLE + "[every state-product]"),
    Bug("proposals lean upwards", WALK, "        work[:] = 0.5\n", "        work[:] = 0.5\n        work[0] = 0.55\n",
        OF_WALK + "proposals_are_symmetric"),
    Bug("a relevance that hangs on the reward", WALK, "f = choose(law.relevance, law.relevance.size, generator)",
        "f = choose(law.relevance * (1.0 + np.abs(walk.point)), law.relevance.size, generator)",
        OF_WALK + "proposals_are_symmetric"),
    Bug("the printed likelihood for the product", WALK, "if reading == PRODUCT:", "if reading == -1:",
        REVERSIBLE + "[every state-product]"),
    Bug("the reward now is left out where it does not cancel", WALK, "total += confidence * seen * reward[s]", "pass",
        REVERSIBLE + "[features-unnormalised]"),
    Bug("an observation counts once, however often it was made", CHAIN, "np.ascontiguousarray(table[states])",
        "np.ascontiguousarray(table[states] > 0) * 1.0",
        OF_WALK + "the_same_steps_are_accepted_as_where_every_world_is_solved_anew[400]"),
    Bug("the predictive distribution at the mean", FOUND, "for value in draws:",
        "for value in draws.mean(axis=0, keepdims=True).repeat(len(draws), axis=0):",
        OF_BAYESIAN + "the_predictive_distribution_is_the_mean_over_the_draws"),
    Bug("the last reward for the best", BAYESIAN, "weights[int(np.argmax(", "weights[-1 + 0 * int(np.argmax(",
        OF_BAYESIAN + "annealing_keeps_the_best_it_saw"),
    Bug("every chain from one stream", BAYESIAN, "0), k) for k in range(chains)]",
        "0), 0) for k in range(chains)]",
        OF_BAYESIAN + "no_more_workers_and_the_same_seed_give_the_same_draws"),
    Bug("chains that never moved have converged", BAYESIAN, "and not accepted.all()", "and False",
        OF_BAYESIAN + "chains_that_never_moved_have_not_converged"),
    Bug("chains that hardly move say nothing", BAYESIAN, "if least < LEAST_ACCEPTED:", "if False:",
        OF_BAYESIAN + "a_chain_that_hardly_moves_says_what_to_try"),
]  # fmt: skip
