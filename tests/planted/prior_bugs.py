"""Planted bugs in what stands around Bayesian IRL: priors of rewards, relevance, Room World, the imperfect expert."""

from __future__ import annotations

from tests.planted.bug import Bug

PRIORS, RELEVANCE, ROOMS = "irl/reward_priors.py", "irl/relevance.py", "mdp/grids/rooms.py"
POLICY = "mdp/planners/policy.py"
OF_PRIORS, OF_RELEVANCE = "irl/test_reward_priors.py::test_", "irl/test_relevance.py::test_"
OF_ROOMS, OF_POLICIES = "mdp/test_rooms.py::test_", "mdp/test_policies.py::test_"

PRIOR_BUGS = [
    Bug("bounded peaks with the mass of whole ones", PRIORS, "        if self.bounded:\n            inside =",
        "        if False:\n            inside =",
        OF_PRIORS + "densities_integrate_to_one[three uneven peaks, bounded]"),
    Bug("a steepness halved", PRIORS, "self.steepness * (rewards[..., None]",
        "0.5 * self.steepness * (rewards[..., None]",
        OF_PRIORS + "densities_integrate_to_one[three peaks, scaled]"),
    Bug("the Laplace density lacks its half", PRIORS, "math.log(2 * self.scale)", "math.log(self.scale)",
        OF_PRIORS + "densities_integrate_to_one[laplace]"),
    Bug("a beta density of the share, not of the reward", PRIORS, "betaln(self.a, self.b) - math.log(span)",
        "betaln(self.a, self.b)", OF_PRIORS + "densities_integrate_to_one[beta]"),
    Bug("a uniform density everywhere", PRIORS, "np.where(inside, -math.log(self.high - self.low), -np.inf)",
        "np.where(inside, -math.log(self.high - self.low), -math.log(self.high - self.low))",
        OF_PRIORS + "nothing_lies_outside_the_support[uniform]"),
    Bug("the first of the modes", PRIORS, "min(modes, key=abs)", "modes[0]",
        OF_PRIORS + "of_several_modes_it_is_the_nearest_to_zero[-3-1-weights2]"),
    Bug("peaks scaled by R_max, not by its square", PRIORS, "/ size**2", "/ size",
        OF_PRIORS + "three_peaks_are_in_the_proportions_of_the_thesis"),
    Bug("NaN has a density", PRIORS, "if np.isnan(rewards).any():", "if False:",
        OF_PRIORS + "shapes_are_kept_and_nan_fails[gaussian]"),
    Bug("states counted as often as they were visited", RELEVANCE, "counts.astype(float) if multiplicity else",
        "counts.astype(float) if True else", OF_RELEVANCE + "it_is_the_sum_over_visited_states_by_its_maximum[1.0]"),
    Bug("relevance by its sum, not its maximum", RELEVANCE, "frozen(total / total.max())",
        "frozen(total / total.sum())",
        OF_RELEVANCE + "a_constant_covariance_makes_all_states_alike[False]"),
    Bug("the distance not squared", RELEVANCE, "np.exp(-0.5 * (cdist(here, there) / sigma) ** 2)",
        "np.exp(-0.5 * (cdist(here, there) / sigma))",
        OF_RELEVANCE + "it_is_the_sum_over_visited_states_by_its_maximum[1.0]"),
    Bug("doors do not turn with the walls", ROOMS, "drawn.tiles[door][:, ::turn].T", "drawn.tiles[door].T",
        OF_ROOMS + "every_variant_has_five_rooms_that_are_connected_and_a_free_start[A-True-drawn]"),
    Bug("no slip in the rooms", ROOMS, "stay=False, slip=ROOM_SLIP)", "stay=False)",
        OF_ROOMS + "the_slip_and_the_walls"),
    Bug("moved doors are open beside the drawn ones", ROOMS, '"moved": "d"', '"moved": ""',
        OF_ROOMS + "every_variant_has_five_rooms_that_are_connected_and_a_free_start[A-False-moved]"),
    Bug("errors are always wrong", POLICY, "others = mdp.available if may_be_optimal else",
        "others = mdp.available if False else", OF_POLICIES + "random_actions_may_be_the_right_one"),
    Bug("errors where none can be made", POLICY, "np.where(others.any(axis=1, keepdims=True), chance, 0.0)",
        "np.where(others.any(axis=1, keepdims=True), chance, chance)",
        OF_POLICIES + "who_breaks_ties_at_random_errs_outside_the_tie"),
]  # fmt: skip
