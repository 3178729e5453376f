"""Planted bugs in planning inside an envelope, and in what worlds too large to be written down tell of themselves."""

from __future__ import annotations

from tests.planted.bug import Bug

LOOPS, GROWING, RTDP = "_kernels/envelope.py", "mdp/planners/growing.py", "mdp/planners/rtdp.py"
KEPT, REWARD, LITERAL = "mdp/planners/precompute.py", "mdp/planners/rtdp_reward.py", "mdp/planners/rtdp_literal.py"
WORLD, IMPLICIT = "mdp/local_world.py", "mdp/grids/implicit_grid.py"
OF_RTDP, OF_KERNELS = "mdp/test_rtdp.py::test_", "mdp/test_envelope_kernels.py::test_"
OF_WORLDS, OF_REWARDS = "mdp/test_local_worlds.py::test_", "mdp/test_rtdp_reward.py::test_"
BOUNDS = OF_RTDP + "no_bound_is_violated_after_any_growth_of_the_envelope[0-random_grid]"
TAKEN = "mdp/test_precompute.py::test_nothing_is_taken_for_something_else"
LEFT = OF_KERNELS + "what_is_expected_outside_is_discounted_and_weighed_by_its_chance[0]"

ENVELOPE_BUGS = [
    Bug("a set that pays again and again is worth no more than one visit", GROWING,
        "return out if self.pinned else out * self.top", "return out", BOUNDS),
    Bug("V*(g) of the lower bound for both", GROWING, "self._ahead(self.envelope.states[goals], bound)",
        "self._ahead(self.envelope.states[goals], self.lower)", BOUNDS),
    Bug("nothing is worth anything outside", GROWING, "value[new, lanes:] = heard = self._heuristic(new)",
        "value[new, lanes:], heard = 0.0, self._heuristic(new)", BOUNDS),
    Bug("the budget is never told", GROWING,
        "PlanStatus.BUDGET if self.envelope.n_inside >= self.settings.most_states else None", "None",
        OF_RTDP + "a_budget_gives_the_bounds_so_far_and_says_so"),
    Bug("a set is no nearer than its nearest state", WORLD,
        "total += world.reach_bound(states, np.array([member]))[:, 0]",
        "total = np.maximum(total, world.reach_bound(states, np.array([member]))[:, 0])",
        OF_WORLDS + "no_walls_make_anyone_faster_than_the_bound"),
    Bug("a wall in the way leads backwards", "mdp/grids/travel_bound.py", "np.exp(np.maximum(steps, 0.0))",
        "np.exp(steps)", OF_WORLDS + "no_walls_make_anyone_faster_than_the_bound"),
    Bug("the whole gap for its half", RTDP, "bounds.value[1] - bounds.value[0]) / 2",
        "bounds.value[1] - bounds.value[0])", OF_RTDP + "the_plan_is_as_exact_as_was_asked[0.1]"),
    Bug("the gap of one action", RTDP, "np.maximum(rows.max(axis=1),", "np.maximum(rows[:, 0],",
        OF_RTDP + "the_plan_is_as_exact_as_was_asked[0.1]"),
    Bug("the best status of any group", RTDP, "status = max(", "status = min(",
        OF_KERNELS + "what_one_group_could_not_do_is_told_of_all"),
    Bug("plans are kept whatever the settings", KEPT, "{VERSION} {known} {astuple(settings)}", "{VERSION} {known}",
        TAKEN + "[tolerance]"),
    Bug("plans are kept whatever the states", KEPT, "digest_arrays(words, states, *goals)",
        "digest_arrays(words, *goals)", TAKEN + "[states]"),
    Bug("grids are known again whatever their corners", IMPLICIT,
        'self.origin == "lower", self.cut_corners]', 'self.origin == "lower"]', TAKEN + "[corners]"),
    Bug("slip turned the other way in a grid of any size", IMPLICIT, "[*self.slip, 0.0][: self.moves + 1]",
        "[self.slip[0], *self.slip[self.moves - 1 : 0 : -1], *self.slip[self.moves :], 0.0][: self.moves + 1]",
        OF_KERNELS + "slips_turn_the_same_way_in_a_grid_of_any_size[lower-8]"),
    Bug("what is expected outside is not discounted", LOOPS, "mass[t] += here * weight[e]",
        "mass[t] += here * weight[e] / weight[row_edge[chosen[s]] : row_edge[chosen[s] + 1]].sum()", LEFT),
    Bug("greedy behaviour goes on from where it should stop", LOOPS, "if stops[s]:", "if stops[s] and here > 1.0:",
        LEFT),
    Bug("where episodes are over nothing is paid", LOOPS, "best = reward[s]", "best = 0.0",
        OF_KERNELS + "values_inside_solve_their_equation_and_those_at_the_edge_stay[0]"),
    Bug("places that are never backed up", LOOPS, "if inside[s] and not listed[s]:", "if False:",
        OF_KERNELS + "everything_inside_is_backed_up_once_and_the_near_first[0]"),
    Bug("a reward that is paid once outside", REWARD,
        "ends = np.array([self.least, self.most]) / (1 - self.world.discount)",
        "ends = np.array([self.least, self.most])",
        OF_REWARDS + "the_bounds_hold_however_small_the_envelope[anywhere-random_grid]"),
    Bug("the printed form hopes for more outside", LITERAL, "value = np.zeros((envelope.n_met, 1))",
        "value = np.ones((envelope.n_met, 1))", OF_WORLDS + "the_printed_form_gives_lower_bounds_stage_by_stage"),
    Bug("how far a discount is felt, one step short", "mdp/planners/horizon.py", "log(alpha * (1 + gamma) / least)",
        "log(alpha / least)", OF_WORLDS + "how_far_a_discount_is_felt"),
]  # fmt: skip
