"""Small wrongs on the way from subgoals to a flight."""

from __future__ import annotations

from tests.planted.bug import Bug

VISITS, ROUTE, PLACES = "flight/visits.py", "flight/route.py", "flight/placement.py"
SMOOTH, WAYS, LOOPS = "flight/smooth.py", "flight/ways.py", "flight/loops.py"
VEHICLE, COMMANDS, FLY, TRACKING = "flight/vehicle.py", "flight/commands.py", "flight/fly.py", "flight/tracking.py"
FILES, BAGS, WAYPOINTS, ORDER = "flight/files.py", "flight/bags.py", "flight/waypoints.py", "answers/order.py"
OF_ORDER, OF_FILES = "flight/test_waypoints.py::test_", "flight/test_files.py::test_"
OF_PATHS, OF_FLIGHTS = "flight/test_smooth.py::test_", "flight/test_fly.py::test_"
OF_ERRORS, OF_PLACES = "flight/test_tracking.py::test_", "flight/test_placement.py::test_"

FLIGHT_BUGS = [
    Bug("waypoints in the order of their shares", WAYPOINTS, "order = _order(posterior, found, kept)",
        "order = np.arange(len(kept))", OF_ORDER + "waypoints_and_action_prediction_agree_on_the_order"),
    Bug("what the best draw leaves out comes last", ORDER, "own if own.size else _likeliest(chances, k)", "own",
        OF_ORDER + "a_place_that_the_best_draw_leaves_out_comes_where_it_is_likeliest_served"),
    Bug("steps are compared over trajectories of other lengths", ORDER, "(row + 0.5) / lengths", "row + 0 * lengths",
        OF_ORDER + "places_that_never_meet_come_by_share_of_their_trajectories"),
    Bug("who comes first where both are does not count", ORDER, "(won > 0) | ((won == 0) & (gone[k] < gone))",
        "(won > np.inf) | (gone[k] < gone)", OF_ORDER + "trajectories_that_end_early_leave_the_order"),
    Bug("one return makes a tour", VISITS, "2 * after.count(first) > len(after)",
        "first in (each.subgoal for each in seen[2:])",
        OF_ORDER + "waypoints_are_cyclic_where_the_first_comes_after_the_last"),
    Bug("stray segments are visits", VISITS, "each.stop - each.start < stray", "each.stop - each.start < 1",
        OF_ORDER + "visits_are_the_segments_in_order_without_strays"),
    Bug("whole turns are forgotten", VISITS, "TURN * np.round((usual - wrapped) / TURN)", "0 * usual",
        OF_ORDER + "whole_turns_are_those_of_the_demonstrator"),
    Bug("a round begins with the first waypoint", ROUTE, "np.roll(order, -_nearest(waypoints))", "np.roll(order, 0)",
        OF_PATHS + "a_cyclic_way_begins_and_ends_nearest_to_the_start"),
    Bug("a round is not closed", ROUTE, "np.append(np.tile(order, rounds), order[0])", "np.tile(order, rounds)",
        OF_PATHS + "a_cyclic_way_begins_and_ends_nearest_to_the_start"),
    Bug("tilts turn the other way", PLACES, "-sense * np.sin(angles)", "sense * np.sin(angles)",
        OF_PLACES + "tilts_are_angles_in_the_plane_from_its_first_axis_to_its_second"),
    Bug("millimetres are metres", PLACES, '"mm": 0.001', '"mm": 1.0',
        OF_PATHS + "units_and_planes_are_placed_in_the_world"),
    Bug("dwells pass before they begin", SMOOTH, "arrivals[a + 1 : b + 1] = clock + reached[1:]",
        "arrivals[a : b + 1] = clock + reached", OF_PATHS + "dwells_are_rests"),
    Bug("corners are cut as they come", WAYS, "(apart <= bound).all() or len(places) == 2", "True",
        OF_PATHS + "overshoot_is_bounded"),
    Bug("only the speed is limited", "flight/polynomials.py", "float(np.sqrt(hard / limits.acceleration))",
        "0.0 * hard",
        OF_PATHS + "the_path_goes_through_the_waypoints_and_keeps_to_the_limits"),
    Bug("short ways are hurried", "flight/polynomials.py", "float(np.sqrt(np.sqrt(snap / limits.snap)))", "0.0 * snap",
        OF_FLIGHTS + "short_ways_are_flown_no_faster_than_thrust_can_swing"),
    Bug("all is reached that is within 10 cm", FLY, "min(NEAR, APART * path.route.least_leg)", "NEAR",
        OF_FLIGHTS + "the_tolerance_is_below_the_distance_of_waypoints"),
    Bug("flights take as long as they take", SMOOTH, "if not seconds <= most:", "if not seconds <= np.inf:",
        OF_PATHS + "wrong_options_are_refused"),
    Bug("noise is the pilot's fault", "flight/record.py", "self.noise > LOUD * self.tolerance", "self.noise < 0",
        OF_FLIGHTS + "what_is_told_says_what_to_try"),
    Bug("arcs bend the other way", LOOPS, "chord = complex(end[across] - begin[across], end[up] - begin[up])",
        "chord, turn = complex(end[across] - begin[across], end[up] - begin[up]), -turn",
        OF_FLIGHTS + "two_rounds_turn_twice"),
    Bug("every loop is a circle", LOOPS, "narrow + wider * (1 - narrow)", "narrow * 0 + max(wider, 1)",
        OF_FLIGHTS + "a_narrow_loop_is_flown_as_narrow_as_the_vehicle_can"),
    Bug("loops are flown at a hand's pace", LOOPS, "np.linalg.norm(there, axis=2) < LEAST, np.pi,",
        "np.linalg.norm(there, axis=2) < LEAST, 0,",
        OF_FLIGHTS + "a_flip_is_inverted_at_the_top_and_level_at_both_ends"),
    Bug("the thrust there is does not matter", LOOPS, "self.thrust / how.vehicle.usable_thrust, self.turning / RESERVE",
        "0.0, self.turning / RESERVE", OF_FLIGHTS + "a_crazyflie_cannot_loop"),
    Bug("rotors lag twice as long", VEHICLE, "np.exp(-part * step / p", "np.exp(-part / 2 * step / p",
        OF_FLIGHTS + "steps_are_those_of_a_fine_solver"),
    Bug("Euler's rule for the midpoint's", VEHICLE, 'now["x"] + self._step * middle["v"]',
        'now["x"] + self._step * now["v"]', OF_FLIGHTS + "steps_are_those_of_a_fine_solver"),
    Bug("drag is left out", COMMANDS, "needed = accelerations + _drag(", "needed = accelerations + 0 * _drag(",
        OF_FLIGHTS + "drag_is_made_up_for"),
    Bug("a place that is missed is reached", FLY, "misses[k] = gaps.min()", "misses[k] = 0 * gaps.min()",
        OF_FLIGHTS + "a_tight_tolerance_is_not_met"),
    Bug("only the flown way is looked at", TRACKING, "((flown**2).mean() + (back**2).mean()) / 2", "(flown**2).mean()",
        OF_ERRORS + "both_directions_count_one_half"),
    Bug("a lone sample is joined to what follows", TRACKING, "alone = np.isin(rows, offset[1:] - 1)",
        "alone = rows < 0", OF_ERRORS + "a_trajectory_of_one_sample_is_a_point"),
    Bug("angles do not wrap", TRACKING, "np.arctan2(np.sin(flight.angles - there), np.cos(flight.angles - there))",
        "flight.angles - there", OF_ERRORS + "angles_are_compared_at_the_nearest_point_and_wrap"),
    Bug("a failure leaves half a file", FILES, "yield made\n", "yield path\n",
        OF_FILES + "a_failure_leaves_the_old_file"),
    Bug("a bag of a round is open", BAGS, "np.append(order, 0) if waypoints.cyclic else order", "order",
        OF_FILES + "a_bag_holds_the_attitude_and_closes_a_round"),
    Bug("turns are lost on disk", FILES, 'record["start"], turns, rounded,', 'record["start"], None, rounded,',
        OF_FILES + "json_holds_everything"),
]  # fmt: skip
