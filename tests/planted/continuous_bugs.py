"""Small wrongs in planning by Gaussian processes, its likelihood, and what is made of recordings for it."""

from __future__ import annotations

from tests.planted.bug import Bug

SWEEPS, VALUES, SMOOTH = "gaussian/value_iteration.py", "gaussian/goal_values.py", "gaussian/smoothers.py"
COORDINATES, HELD, WORLD = "gaussian/coordinates.py", "demonstrations/held.py", "dynamics/world.py"
TABLE, ACTIONS, GPSRL = "likelihood/gp_values.py", "likelihood/gp_actions.py", "irl/gpsrl.py"
ANNEALED, SOFTMAX = "partition/annealed.py", "_kernels/softmax.py"
PLAN, DENSITY = "gaussian/test_value_iteration.py::test_", "likelihood/test_gp_actions.py::test_"
PLACED, SLOWER = "gaussian/test_coordinates.py::test_", "demonstrations/test_held.py::test_"
COOL, WHOLE = "partition/test_annealed.py::test_", "irl/test_gpsrl.py::test_"
NAIVE, BOUND = PLAN + "all_goals_at_once_are_each_goal_on_its_own", PLAN + "a_contraction_converges_and_its_bound_holds"
NORMAL, HAND = PLAN + "expectations_under_a_normal_law_are_those_of_quadrature", DENSITY + "it_is_the_formula_by_hand"
BY_MODEL = DENSITY + "values_come_from_the_model_and_the_reward"

CONTINUOUS_BUGS = [
    Bug("values are not bounded", SWEEPS, "if bounds is not None:\n            after",
        "if bounds is None:\n            after", NAIVE),
    Bug("the discount is forgotten", SWEEPS, "+ discount * after", "+ after", NAIVE),
    Bug("the best action is the worst", SWEEPS, "xp.argmax(worth, axis=1)", "xp.argmin(worth, axis=1)",
        PLAN + "the_best_action_is_the_one_with_the_largest_value"),
    Bug("converged too soon", SWEEPS, "residuals[-1] <= tolerance:", "residuals[-1] <= 1e3 * tolerance:",
        BOUND),
    Bug("growth without bound passes for the limit of sweeps", SWEEPS, "IterationStatus.DIVERGED\n",
        "IterationStatus.LIMIT\n", PLAN + "values_that_grow_without_bound_are_said_to"),
    Bug("a row of each block is left out", SWEEPS, "slice(first, min(first + rows, n))",
        "slice(first, first + rows - 1)",
        PLAN + "blocks_do_not_change_the_values"),
    Bug("rewards are no shares", VALUES, "reward = (1 - discount) * rewards(", "reward = rewards(", NAIVE),
    Bug("the gain is a mean", VALUES, "xp.max(xp.sum(xp.abs(weights), axis=1))",
        "xp.mean(xp.sum(xp.abs(weights), axis=1))", PLAN + "an_unstable_setting_within_bounds_trips_the_monitor"),
    Bug("a bound where nothing is proved", VALUES, "if self.smoother.contracts else math.inf", "if True else 0.0",
        PLAN + "an_unstable_setting_within_bounds_trips_the_monitor"),
    Bug("the bound forgets the discount", VALUES, "self.residual * self.discount / (1 - self.discount)",
        "self.residual * self.discount", BOUND),
    Bug("the reward of a step is its last", VALUES, "for at in ahead.points[:-1]]", "for at in ahead.points[:0]]",
        BY_MODEL),
    Bug("noise of the covariance is forgotten", SMOOTH, "self.length) + noise", "self.length)", NAIVE),
    Bug("rows of the limit are scaled up too", SMOOTH, "xp.where(size > self.most_gain,", "xp.where(size > 0,",
        PLAN + "a_limit_of_the_gain_leaves_small_rows_alone"),
    Bug("far from the support nothing falls", SMOOTH, "xp.where(total > self.floor,", "xp.where(total > 0,",
        PLAN + "an_averager_falls_to_zero_far_from_its_support"),
    Bug("a normal law keeps its height", SMOOTH, "xp.exp(shrink[:, None] - 0.5", "xp.exp(0 * shrink[:, None] - 0.5",
        NORMAL),
    Bug("a normal law has the plain length", SMOOTH, "scale = 1 / (length**2 + variance)",
        "scale = 1 / (length**2 + 0 * variance)", NORMAL),
    Bug("singular covariances are solved with", SMOOTH, "eps < 1e-3:", "eps < 1e300:",
        PLAN + "equal_support_states_need_noise"),
    Bug("angles have the radius for the circumference", COORDINATES, "metric.weights[wraps] / (2 * np.pi)",
        "metric.weights[wraps]", PLACED + "angles_lie_on_a_circle_of_the_right_size"),
    Bug("the floor is a ceiling", COORDINATES, "spread = np.maximum(", "spread = np.minimum(",
        PLACED + "units_are_spreads_but_not_below_the_floor"),
    Bug("the mean of an angle is plain", COORDINATES, "for k in np.flatnonzero(np.isfinite(period)):",
        "for k in np.flatnonzero(np.isnan(period)):",
        PLACED + "the_spread_of_an_angle_does_not_hang_on_where_it_is_cut"),
    Bug("the action is that of one moment", HELD, "np.arange(every)].mean(axis=1)", "np.arange(1)].mean(axis=1)",
        SLOWER + "a_pair_is_the_first_state_and_the_mean_action_until_the_next"),
    Bug("what is left over goes with the next trajectory", HELD, "np.minimum(within, counts[owner] - 1)", "within",
        SLOWER + "every_sample_knows_its_pair"),
    Bug("it ended where the recording ended", HELD, "inside = after < demonstrations.offset[1:]",
        "inside = after < 0", SLOWER + "it_ended_where_the_last_held_action_ended"),
    Bug("uneven steps pass", HELD, "worst <= UNEVEN * typical", "worst <= 100 * UNEVEN * typical",
        SLOWER + "times_must_be_there_and_even"),
    Bug("every part of a step is a whole one", WORLD, "actions, self.step / self.points)", "actions, self.step)",
        BY_MODEL),
    Bug("the discount is that of a second", WORLD, "math.exp(-self.step / self.horizon)", "math.exp(-1 / self.horizon)",
        BY_MODEL),
    Bug("test actions go round with the states", WORLD, "np.repeat(states, m, axis=0)", "np.tile(states, (m, 1))",
        DENSITY + "test_actions_are_valued_as_if_they_had_been_taken"),
    Bug("the volume of the actions is forgotten", TABLE, "out - log_volume", "out",
        DENSITY + "densities_sum_to_one_over_the_test_actions"),
    Bug("a sum in place of a mean over the test actions", SOFTMAX, "log(total[g] / m_count)", "log(total[g])", HAND),
    Bug("the peak is that of the first test action", SOFTMAX, "peak[g] = tested[i, m, g] if tested[i, m, g] > peak[g]",
        "total[g] = tested[i, m, g] if tested[i, m, g] > peak[g]", HAND),
    Bug("scores are of the action, not of its error", TABLE, "(self.actions - chance @ self.tests)", "self.actions",
        DENSITY + "scores_have_mean_zero_under_the_model"),
    Bug("candidates that can be held are dropped", ACTIONS, "kept = share >= least", "kept = share < least",
        DENSITY + "candidates_that_cannot_be_held_are_dropped_and_counted"),
    Bug("what is dropped is not counted", ACTIONS, "int((~kept).sum())", "0",
        DENSITY + "candidates_that_cannot_be_held_are_dropped_and_counted"),
    Bug("support states are held out", ACTIONS, "< 1e-9).any(axis=1)", "< -1).any(axis=1)",
        DENSITY + "it_says_how_well_it_has_planned"),
    Bug("not converging is not told", ACTIONS, "if plan.status is not IterationStatus.CONVERGED:", "if False:",
        DENSITY + "not_converging_warns"),
    Bug("dwelling is per step", GPSRL, "math.exp(-step / kept)", "math.exp(-1 / kept)",
        WHOLE + "subgoals_are_kept_for_the_dwell_on_average"),
    Bug("bounds of the dynamics are passed over", GPSRL, 'bounds = getattr(world, "bounds", None)', "bounds = None",
        WHOLE + "bounds_that_the_dynamics_name_are_taken"),
    Bug("the fall begins again after a pause", ANNEALED, "np.array([done + falling], np.int64)",
        "np.array([0], np.int64)", COOL + "a_pause_in_the_fall_changes_nothing"),
    Bug("draws of the fall are kept", ANNEALED, "if keep[:falling].any():", "if False:",
        COOL + "draws_of_the_fall_may_not_be_kept"),
    Bug("it falls half way", ANNEALED, "share = (done + k) / self.sweeps", "share = (done + k) / (2 * self.sweeps)",
        COOL + "the_concentration_falls_from_a_quarter_of_the_candidates_to_its_value"),
    Bug("observations begin at their likeliest", ANNEALED, "chain.generator.random(len(tile)) * mass[:, -1]",
        "0.999 * mass[:, -1]", COOL + "observations_begin_apart"),
]  # fmt: skip
