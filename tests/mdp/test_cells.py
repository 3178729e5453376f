"""Recordings on a grid: against a slow account sample by sample, by hand, and on bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.answers.scores import top_candidates
from subgoal.demonstrations import Demonstrations, Recording, demonstrate
from subgoal.demonstrations.records import Source
from subgoal.irl.bnirl import bnirl
from subgoal.mdp.grids.cells import to_cells
from subgoal.mdp.grids.maps import read_map
from subgoal.mdp.grids.occupancy import Occupancy
from subgoal.runtime.errors import InputError
from tests.oracles.cells import Room, gridded


def recording(tracks, **fields):
    """A Recording of {name: [((x, y), time), ...]}."""
    return Recording(
        np.array([place for track in tracks.values() for place, _ in track], float),
        np.array([time for track in tracks.values() for _, time in track], float),
        np.cumsum([0, *(len(track) for track in tracks.values())]),
        ("east", "north"), "m", tuple(tracks), **fields,
    )  # fmt: skip


def along(*places, since=0.0):
    """A track with a sample a second."""
    return [(place, since + k) for k, place in enumerate(places)]


def cells_and_actions(world, demos, d=0):
    rows = slice(demos.offset[d], demos.offset[d + 1])
    cells = [tuple(world.cells[s].tolist()) for s in demos.states[rows]]
    return list(zip(cells, [world.action_names[a] for a in demos.actions[rows]], strict=True))


OPEN = Occupancy(np.ones((4, 4), bool))


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_recording_as_sample_by_sample(data) -> None:
    height, width = data.draw(st.integers(1, 5)), data.draw(st.integers(1, 5))
    rows = data.draw(st.lists(st.lists(st.integers(0, 4), min_size=width, max_size=width), min_size=height,
                              max_size=height))  # fmt: skip
    free = np.array(rows) > 0
    free[0, 0] = True
    resolution, origin = data.draw(st.sampled_from([1.0, 0.5, 20.0])), data.draw(st.sampled_from([(0, 0), (-3, 7.5)]))
    moves, corners = data.draw(st.sampled_from([4, 8])), data.draw(st.booleans())
    y_down, staying = data.draw(st.booleans()), data.draw(st.sampled_from(["keep", "once", "drop"]))
    whole = st.tuples(st.integers(-1, 4 * width), st.integers(-1, 4 * height))
    tracks = {}
    for name in ("a", "b", "c")[: data.draw(st.integers(1, 3))]:
        quarters = np.array(data.draw(st.lists(whole, min_size=1, max_size=10)))
        times = np.cumsum(data.draw(st.lists(st.integers(1, 5), min_size=len(quarters), max_size=len(quarters))))
        places = origin + (quarters + 0.5) / 4 * resolution
        tracks[name] = [(tuple(place), float(time)) for place, time in zip(places, times, strict=True)]
    room = Room(free.tolist(), moves=moves, corners=corners, y_down=y_down)
    wanted = gridded(tracks, room, resolution, origin, staying)
    occupancy = Occupancy(free, resolution, origin, y_down)
    options = {"discount": 0.9, "moves": moves, "cut_corners": corners, "staying": staying, "outside": "drop"}
    if not wanted:
        with pytest.raises(InputError, match="no trajectory left"):
            to_cells(recording(tracks), occupancy, **options)
        return
    world, demos = to_cells(recording(tracks), occupancy, **options)
    assert demos.trajectory_names == tuple(name for name, *_ in wanted)
    assert demos.truncated.tolist() == [cut for *_, cut in wanted]
    assert [tuple(world.cells[s].tolist()) for s in demos.final_states] == [last for _, _, last, _ in wanted]
    for d, (_, pairs, _, _) in enumerate(wanted):
        assert cells_and_actions(world, demos, d) == [(cell, action) for cell, action, _ in pairs]
        times = demos.times[demos.offset[d] : demos.offset[d + 1]]
        assert times.tolist() == pytest.approx([time for *_, time in pairs], rel=1e-14)  # the same sum
        assert (np.diff(times) > 0).all()


def test_steps_stays_and_what_lies_between() -> None:
    track = along((0.5, 0.5), (0.9, 0.1), (0.2, 0.2), (1.5, 1.5), (1.5, 3.5), (1.6, 3.6))
    fields = {"time_unit": "frame", "source": Source("mine", notes={"read": 6})}
    for staying, pairs, times in (
        ("keep", "stay stay NE N N stay", [0, 1, 2, 3, 3.5, 4]),
        ("once", "stay NE N N stay", [0, 2, 3, 3.5, 4]),
        ("drop", "NE N N", [0, 3, 3.5]),
    ):
        world, demos = to_cells(recording({"a": track}, **fields), OPEN, discount=0.95, staying=staying)
        assert [action for _, action in cells_and_actions(world, demos)] == pairs.split()
        assert demos.times.tolist() == times
        assert demos.places[0].tolist() == [0.5, 0.5]
        assert demos.final_places.tolist() == [[1.5, 3.5]]
        assert (demos.names, demos.units, demos.time_unit) == (("east", "north"), "m", "frame")
        assert demos.trajectory_names == ("a",)
        assert not demos.truncated.any()
        stays = pairs.split().count("stay")
        assert demos.source.notes == {
            "read": 6, "pairs filled in between samples": 1,
            **({"pairs of standing still kept": stays} if stays else {}),
            **({"pairs of standing still dropped": 3 - stays} if stays < 3 else {}),
        }  # fmt: skip
        assert world.discount == 0.95


def test_places_are_in_the_units_of_the_recording() -> None:
    room = Occupancy(np.ones((3, 3), bool), 20.0, (100, 200))
    world, demos = to_cells(recording({"a": along((105, 205), (125, 245))}), room, discount=0.9)
    assert demos.places.tolist() == [[110, 210], [110, 230]]
    assert demos.final_places.tolist() == [[130, 250]]
    np.testing.assert_array_equal(demos.coordinates, world.mdp.coordinates)
    np.testing.assert_array_equal(demos.coordinates, room.position_of(world.cells))


def test_what_is_off_the_map_or_in_a_wall_is_refused_with_its_row() -> None:
    room = Occupancy.from_map(read_map("...\n.#.\n...\n"))
    good = along((0.5, 0.5), (1.5, 0.5))
    for place, found in (((1.5, 1.5), "in a wall"), ((3.0, 0.5), "off the map"), ((0.5, -0.01), "off the map")):
        tracks = {"a": good, "b": along((0.5, 0.5), place, (2.5, 0.5))}
        told = f"({place[0]:g}, {place[1]:g})".replace("(", r"\(").replace(")", r"\)")
        with pytest.raises(InputError, match=rf"positions at row 3, trajectory 'b': found {told}, which is {found}"):
            to_cells(recording(tracks), room, discount=0.9)
        world, demos = to_cells(recording({**tracks, "c": along(place), "d": good}), room, discount=0.9, outside="drop")
        assert demos.trajectory_names == ("a", "d")
        label = "samples in walls dropped" if found == "in a wall" else "samples off the map dropped"
        assert demos.source.notes == {
            label: 2, "trajectories cut": 1, "trajectories of one sample dropped": 2,
            "trajectories without a sample left dropped": 1,
        }  # fmt: skip
        assert world.n_states == 8


def test_pieces_are_named_and_truncated() -> None:
    room = Occupancy.from_map(read_map(".....#.....\n"))
    track = along((0.5, 0.5), (1.5, 0.5), (5.5, 0.5), (6.5, 0.5), (7.5, 0.5), (5.5, 0.5))
    ended = along((5.5, 0.5), (8.5, 0.5), (9.5, 0.5))
    data = recording({"a": track, "b": ended, "c": ended}, truncated=[False, False, True])
    world, demos = to_cells(data, room, discount=0.9, outside="drop")
    assert demos.trajectory_names == ("a/0", "a/1", "b", "c")
    assert demos.truncated.tolist() == [True, True, False, True]
    assert [tuple(world.cells[s].tolist()) for s in demos.final_states] == [(1, 0), (7, 0), (9, 0), (9, 0)]
    assert demos.source.notes == {"samples in walls dropped": 4, "trajectories cut": 1}


def test_pieces_keep_the_group_of_their_trajectory() -> None:
    gone = along((0.5, 0.5), (0.5, 2.5), (9, 9), (2.5, 2.5), (2.5, 0.5))
    data = recording({"a": along((0.5, 0.5), (0.5, 2.5)), "b": gone}, groups=("ant", "bee"))
    _, demos = to_cells(data, OPEN, discount=0.9, outside="drop")
    assert demos.groups == ("ant", "bee", "bee")
    assert to_cells(recording({"a": gone}), OPEN, discount=0.9, outside="drop")[1].groups == ()


def test_no_way_between_two_samples() -> None:
    room = Occupancy.from_map(read_map("...#...\n"))
    data = recording({"a": along((0.5, 0.5), (2.5, 0.5), (4.5, 0.5), (5.5, 0.5))})
    with pytest.raises(InputError, match=r"row 2, trajectory 'a': found no way over free cells from \(2\.5, 0\.5\) to"):
        to_cells(data, room, discount=0.9)
    world, demos = to_cells(data, room, discount=0.9, outside="drop")
    assert demos.trajectory_names == ("a/0", "a/1")
    assert demos.truncated.tolist() == [True, False]
    assert cells_and_actions(world, demos, 0) == [((0, 0), "E"), ((1, 0), "E")]
    assert demos.source.notes == {
        "steps without a way cut": 1, "trajectories cut": 1, "pairs filled in between samples": 1,
    }  # fmt: skip


def test_tracks_that_never_leave_their_cell() -> None:
    tracks = {"still": along((0.1, 0.1), (0.2, 0.2), (0.3, 0.3)), "one": along((2.5, 2.5)),
              "moves": along((0.5, 0.5), (1.5, 0.5))}  # fmt: skip
    for staying, names, pairs in (("keep", ("still", "moves"), 3), ("once", ("still", "moves"), 2),
                                  ("drop", ("moves",), 1)):  # fmt: skip
        _, demos = to_cells(recording(tracks), OPEN, discount=0.9, staying=staying)
        assert (demos.trajectory_names, demos.n_observations) == (names, pairs)
        assert demos.source.notes["trajectories of one sample dropped"] == 1
        assert demos.source.notes.get("trajectories that never left their cell dropped", 0) == ("still" not in names)
    with pytest.raises(InputError, match=r"no trajectory left.*2 pairs of standing still dropped, 1 trajectories that"):
        to_cells(recording({"still": tracks["still"]}), OPEN, discount=0.9, staying="drop")


def test_y_downwards_only_changes_the_names() -> None:
    data = recording({"a": along((0.5, 0.5), (0.5, 1.5))})
    for y_down, name in ((False, "N"), (True, "S")):
        world, demos = to_cells(data, Occupancy(np.ones((2, 1), bool), y_down=y_down), discount=0.9)
        assert cells_and_actions(world, demos) == [((0, 0), name)]


def test_demonstrations_with_ends_of_their_own() -> None:
    """The end of a trajectory is one more sample where it is not its last state, and else it is not."""
    demos = Demonstrations(
        [[0.5, 0.5], [1.5, 0.5], [0.5, 2.5]], np.zeros((3, 2)), np.array([0, 2, 3]), times=[0.0, 1.0, 7.0],
        final_states=[[3.5, 0.5], [0.5, 2.5]], truncated=[True, False], trajectory_names=("a", "b"),
    )  # fmt: skip
    world, found = to_cells(demos, OPEN, discount=0.9)
    assert cells_and_actions(world, found) == [((0, 0), "E"), ((1, 0), "E"), ((2, 0), "E")]
    assert found.times.tolist() == [0, 1, 1.5]
    assert found.truncated.tolist() == [True]
    assert found.source.notes["trajectories of one sample dropped"] == 1
    alone = Demonstrations(
        [[0.5, 0.5], [0.5, 0.5]], np.zeros((2, 2)), np.array([0, 1, 2]), times=[3.0, 9.0],
        final_states=[[2.5, 0.5], [0.5, 2.5]],
    )  # fmt: skip
    assert to_cells(alone, OPEN, discount=0.9)[1].times.tolist() == [3, 3, 9, 9]
    with pytest.raises(InputError, match=r"the end of trajectory 'T0': found \(9, 9\), which is off the map"):
        to_cells(Demonstrations([[0.5, 0.5]], [[1, 1]], np.array([0, 1]), final_states=[[9, 9]]), OPEN, discount=0.9)
    timeless = Demonstrations([[0.5, 0.5], [1.5, 0.5]], np.zeros((2, 2)), np.array([0, 2]))
    assert to_cells(timeless, OPEN, discount=0.9)[1].times is None


def test_a_recording_and_its_demonstrations_agree() -> None:
    steps = np.random.default_rng(1).normal(size=(60, 2)).cumsum(axis=0)
    data = Recording(steps, np.arange(60.0), np.array([0, 25, 60]), ("x", "y"))
    room = Occupancy.around(data, 0.7)
    for staying in ("keep", "once", "drop"):
        direct, again = (to_cells(d, room, discount=0.9, staying=staying)[1] for d in (data, demonstrate(data)))
        for field in ("states", "actions", "offset", "times", "final_states", "truncated"):
            np.testing.assert_array_equal(getattr(direct, field), getattr(again, field))


def test_steps_are_those_of_the_world() -> None:
    """Without slip, every pair leads where the next one begins."""
    data = Recording(np.random.default_rng(2).uniform(0, 4, (80, 2)), np.arange(80.0), np.array([0, 40, 80]), ())
    room = Occupancy(np.random.default_rng(3).random((8, 8)) > 0.2, 0.5)
    for moves in (4, 8):
        world, demos = to_cells(data, room, discount=0.9, moves=moves, cut_corners=False, outside="drop")
        for d in range(demos.n_trajectories):
            states = [*demos.states[demos.offset[d] : demos.offset[d + 1]], demos.final_states[d]]
            for k, action in enumerate(demos.actions[demos.offset[d] : demos.offset[d + 1]]):
                assert world.mdp.row(int(states[k]), int(action))[0].tolist() == [states[k + 1]]


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"staying": "twice"}, "staying: found 'twice', wanted 'keep' or 'once' or 'drop'"),
        ({"outside": "clip"}, "outside: found 'clip', wanted 'raise' or 'drop'"),
        ({"stay": False}, "staying: found 'keep', wanted 'drop'"),
        ({"stay": False, "staying": "once"}, "staying: found 'once'"),
        ({"moves": 5}, "moves"),
        ({"discount": 2}, "discount"),
        ({"slip": (0.5, 0.5)}, "slip"),
        ({"occupancy": np.ones((2, 2), bool)}, "occupancy: found ndarray, wanted an Occupancy"),
        ({"data": np.zeros((3, 2))}, "data: found ndarray"),
        ({"data": Demonstrations([0, 1], [0, 0], np.array([0, 2]))}, "data: found states of a discrete world"),
        ({"data": Recording(np.zeros((2, 3)), [0, 1], np.array([0, 2]), ())}, "data: found positions with 3 columns"),
        ({"data": Recording(np.zeros((2, 1)), [0, 1], np.array([0, 2]), ())}, "data: found positions with 1 columns"),
    ],
)
def test_bad_choices(fields, match) -> None:
    given = {"data": recording({"a": along((0.5, 0.5), (1.5, 0.5))}), "occupancy": OPEN, "discount": 0.9, **fields}
    with pytest.raises(InputError, match=match):
        to_cells(given.pop("data"), given.pop("occupancy"), **given)


def test_without_an_action_that_stays() -> None:
    data = recording({"a": along((0.5, 0.5), (0.6, 0.5), (1.5, 0.5))})
    world, demos = to_cells(data, OPEN, discount=0.9, moves=4, stay=False, staying="drop")
    assert world.action_names == ("N", "E", "S", "W")
    assert cells_and_actions(world, demos) == [((0, 0), "E")]


@pytest.mark.filterwarnings("ignore")
def test_two_goals_are_found_where_they_lie() -> None:
    """Walks in metres to two corners of a room with a wall: the two subgoals of largest share are those corners."""
    drawn = read_map(".......\n.......\n..####.\n.......\n.......\n")
    room, generator = Occupancy.from_map(drawn, 0.5, (10, 20)), np.random.default_rng(0)
    goals, tracks = [(6, 0), (0, 4)], {}
    for k in range(8):
        way = Room(drawn.free.tolist()).way([(2, 3), (4, 1)][k // 2 % 2], goals[k % 2])
        centres = room.position_of(np.repeat(way, 3, axis=0))
        tracks[f"walk {k}"] = along(*map(tuple, centres + generator.uniform(-0.24, 0.24, centres.shape)))
    world, demos = to_cells(recording(tracks), room, discount=0.95, staying="drop")
    assert "pairs filled in between samples" not in demos.source.notes
    posterior = bnirl(demos, world.mdp, chains=2, draws=300, warmup=100, thin=2, seed=0, workers=1)
    best = posterior.candidates.points[top_candidates(posterior, 2)]
    assert sorted(best.tolist()) == sorted(room.position_of(np.array(goals)).tolist())
