"""Planted bugs where methods are set side by side: what each has seen, what it is scored on, what is told of it."""

from __future__ import annotations

from tests.planted.bug import Bug

COMPARE, RIVALS, CLONING = "irl/compare.py", "irl/rivals.py", "irl/cloning.py"
WORDS, OF_COMPARE = "plots/comparison.py", "irl/test_compare.py::test_"

COMPARE_BUGS = [
    Bug("methods are scored on what they have seen", COMPARE, "np.flatnonzero(fold != j)", "np.flatnonzero(fold != -1)",
        OF_COMPARE + "floors_are_those_by_hand"),
    Bug("one of several likeliest actions is right", COMPARE, "losses(likeliest(table), actions)",
        "1.0 - likeliest(table)[np.arange(len(table)), actions]", OF_COMPARE + "floors_are_those_by_hand"),
    Bug("the second-order chain runs from one trajectory into the next", CLONING,
        "before[demonstrations.offset[:-1]] = n_states", "before[0] = n_states",
        OF_COMPARE + "the_second_order_chain_is_that_by_hand"),
    Bug("the filter has seen the action that it foretells", RIVALS,
        "before = filtered.probability / np.maximum(taken, np.finfo(float).tiny)",
        "before = filtered.probability / np.maximum(1.0 + 0 * taken, np.finfo(float).tiny)",
        OF_COMPARE + "a_filter_never_looks_at_the_action_it_foretells"),
    Bug("the share of errors is that of the pairs", RIVALS, "(1 - share) * own + share * even",
        "(1 - share) * own + share",
        OF_COMPARE + "the_share_of_errors_is_the_likeliest"),
    Bug("numbers above one are probabilities", COMPARE, "(np.abs(table.sum(axis=1) - 1) <= CLOSE)",
        "(table.sum(axis=1) >= 0)", OF_COMPARE + "what_is_no_probability_cannot_win[<lambda>-sum to 5]"),
    Bug("the worst method is called the best", COMPARE, "key=lambda each: -each.bits_per_decision",
        "key=lambda each: each.bits_per_decision",
        OF_COMPARE + "every_method_gives_probabilities_and_is_scored_on_the_same_decisions"),
    Bug("what Ctrl-C came before is not told", COMPARE, "if name not in done)", "if name in ())",
        OF_COMPARE + "what_ctrl_c_came_before_is_named"),
    Bug("names that are no methods are passed over", COMPARE, "if each not in RIVALS:", "if False:",
        OF_COMPARE + "bad_input_is_named"),
    Bug("a method is not named before it is fitted", COMPARE, "    step(0)\n", "",
        OF_COMPARE + "time_left_is_told_of_each_method_alone"),
    Bug("the prior of pairs of states is uniform", RIVALS, "(seen + base[asked.states])",
        "(seen + 1 / mdp.n_actions)", OF_COMPARE + "the_second_order_chain_is_that_by_hand"),
    Bug("neighbouring cells are counted apart", RIVALS, "merge_radius=merge_radius(posterior.demonstrations, mdp)",
        "merge_radius=0.0", OF_COMPARE + "neighbouring_cells_are_counted_as_one_subgoal"),
    Bug("one reward is enough where it is not", WORDS, "if low > 0:\n        return f\"One",
        "if high < 0:\n        return f\"One",
        OF_COMPARE + "whether_one_reward_is_enough_is_a_paired_difference"),
]  # fmt: skip
