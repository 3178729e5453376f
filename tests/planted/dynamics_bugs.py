"""Small wrongs in the car, its driver and learned dynamics."""

from __future__ import annotations

from tests.planted.bug import Bug

LOOPS = "_kernels/car.py"
CAR = "dynamics/car.py"
PROTOCOL = "dynamics/protocol.py"
STEADY = "dynamics/equilibria.py"
DRIVER = "dynamics/driver.py"
SCRIPTS = "dynamics/scripts.py"
PAIRS = "dynamics/learned_pairs.py"
MODELS = "dynamics/learned_models.py"
RECORD = "dynamics/learned_dynamics.py"
LEARN = "dynamics/learned.py"
OF_CAR = "dynamics/test_car.py::test_"
OF_STEADY = "dynamics/test_equilibria.py::test_"
OF_PROTOCOL = "dynamics/test_protocol.py::test_"
OF_DRIVER = "dynamics/test_driver.py::test_"
PEERS = "dynamics/test_vehicle_models.py::test_"
OF_LEARNED = "dynamics/test_learned.py::test_"
HOLDOUT = "dynamics/test_holdout.py::test_"

DYNAMICS_BUGS = [
    Bug(
        "forces with the slip",
        LOOPS,
        "share = -build.friction",
        "share = build.friction",
        PEERS + "forces_in_pure_slip_are_theirs",
    ),
    Bug(
        "a step-steer with another lever",
        LOOPS,
        "vy + build.front * rate",
        "vy + build.rear * rate",
        PEERS + "a_step_steer_is_that_of_the_linear_single_track_model",
    ),
    Bug(
        "Euler for Heun",
        LOOPS,
        "rate += 0.5 * h * (ar + br)",
        "rate += h * ar",
        OF_CAR + "halving_the_step_quarters_the_error",
    ),
    Bug(
        "the rate of the wheel",
        LOOPS,
        "(command - wheel) / build.lag",
        "(command - wheel) * 9.5",
        OF_CAR + "the_wheel_follows_its_command",
    ),
    Bug(
        "energy out of locked wheels",
        LOOPS,
        "front_x * build.rear + rear_x * build.front",
        "rear_x * build.rear + front_x * build.front",
        OF_CAR + "derivatives_are_those_of_the_slow_form",
    ),
    Bug(
        "widths are not checked",
        CAR,
        "if values.shape[1] != len(names):",
        "if False:",
        OF_CAR + "impossible_states_and_actions_are_refused",
    ),
    Bug(
        "other shapes out of dynamics",
        PROTOCOL,
        "answer.shape != states.shape or ",
        "",
        OF_PROTOCOL + "answers_of_another_kind_are_refused",
    ),
    Bug(
        "bounds that are none",
        PROTOCOL,
        "if not (low < high).all():",
        "if False:",
        OF_PROTOCOL + "bounds_that_are_none_are_refused",
    ),
    Bug(
        "the same state counted twice",
        STEADY,
        "all(np.abs(each.state - other.state).max() > APART for other in found)",
        "True",
        OF_STEADY + "all_branches_of_a_command_are_found",
    ),
    Bug(
        "eigenvalues of the transpose of another",
        STEADY,
        "(up - down).T / (2 * _STEP)",
        "(up - down).T / _STEP",
        OF_STEADY + "small_errors_grow_and_decay_with_the_eigenvalues",
    ),
    Bug(
        "sideslip the other way",
        STEADY,
        "np.arctan2(self.state[1], self.state[0])",
        "np.arctan2(self.state[0], self.state[1])",
        OF_STEADY + "the_drift_is_stable_with_all_wheels_driven_and_a_saddle_with_two",
    ),
    Bug(
        "the hand is faster",
        DRIVER,
        "HAND_LAG = 0.1",
        "HAND_LAG = 0.08",
        OF_DRIVER + "without_noise_and_feedback_the_hand_follows_with_its_lag",
    ),
    Bug(
        "speed wanders as steering",
        DRIVER,
        "np.array([0.03, 0.10])",
        "np.array([0.03, 0.03])",
        OF_DRIVER + "speed_commands_wander_by_theirs",
    ),
    Bug(
        "commands beyond the bounds",
        DRIVER,
        "np.clip(hand + scale * wander, *car.bounds)",
        "hand + scale * wander",
        OF_DRIVER + "the_record_is_what_the_car_did",
    ),
    Bug(
        "trajectories share a stream",
        DRIVER,
        "generator = stream(seed, k)",
        "generator = stream(seed)",
        OF_DRIVER + "seeds_and_trajectories_have_streams_of_their_own",
    ),
    Bug(
        "turns of other radii",
        DRIVER,
        "-0.32",
        "-0.28",
        OF_DRIVER + "turns_are_three_radii",
    ),
    Bug(
        "times that stand still",
        DRIVER,
        "if not (lengths > 0).all():",
        "if False:",
        OF_DRIVER + "impossible_paths_are_refused",
    ),
    Bug(
        "ends are shuffled too",
        SCRIPTS,
        "turn[1:-1] = generator.permutation(turn[1:-1])",
        "turn = generator.permutation(turn)",
        OF_DRIVER + "shuffled_keeps_the_ends_and_the_share_of_each",
    ),
    Bug(
        "names that are no place",
        SCRIPTS,
        "or segment[0] not in places",
        "",
        OF_DRIVER + "impossible_drives_are_refused",
    ),
    Bug(
        "increments the long way round",
        PAIRS,
        "np.array(metric.difference(states[row], states[row + every])) / metric.weights",
        "states[row + every] - states[row]",
        OF_LEARNED + "angles_wrap",
    ),
    Bug(
        "held out one by one",
        PAIRS,
        "length = max(2 * moves.every, len(moves.row) // BLOCKS)",
        "length = 1",
        HOLDOUT + "stretches_are_whole_and_about_the_share_that_was_asked_for",
    ),
    Bug(
        "dimensions that never change",
        PAIRS,
        "if still.any():",
        "if False:",
        OF_LEARNED + "what_cannot_be_learned_from_is_refused",
    ),
    Bug(
        "neighbours count alike",
        MODELS,
        'weights="distance"',
        'weights="uniform"',
        OF_LEARNED + "neighbours_are_the_mean_of_five_by_their_distance",
    ),
    Bug(
        "variances without the noise",
        MODELS,
        " + process.noise for",
        " for",
        OF_LEARNED + "gaussian_processes_are_those_of_scikit_learn",
    ),
    Bug(
        "points hang on no seed",
        MODELS,
        "stream(seed, 1)",
        "np.random.default_rng()",
        OF_LEARNED + "learning_is_reproducible",
    ),
    Bug(
        "what is left of a step is lost",
        RECORD,
        "([left] if left > WHOLE else [])",
        "[]",
        OF_LEARNED + "several_steps_are_the_step_repeated_and_a_part_of_one_is_that_part_of_its_increment",
    ),
    Bug(
        "errors are not carried on",
        RECORD,
        "spread = slope @ spread @ slope.transpose(0, 2, 1)",
        "pass",
        OF_LEARNED + "variances_over_several_steps_are_carried_on_by_the_law",
    ),
    Bug(
        "the worst for the best",
        LEARN,
        "taken = min(tried",
        "taken = max(tried",
        OF_LEARNED + "the_best_is_the_one_that_errs_least",
    ),
    Bug(
        "learned from what is held in only",
        LEARN,
        "_LEARN[taken](at, moves.increments, seed)",
        "_LEARN[taken](at[train], moves.increments[train], seed)",
        OF_LEARNED + "where_something_was_seen_neighbours_say_it_again",
    ),
    Bug(
        "no combined slip",
        LOOPS,
        "size = sqrt(along * along + across * across)",
        "size = max(abs(along), abs(across))",
        PEERS + "forces_in_combined_slip_are_near_a_measured_law",
    ),
]
