"""Cells of a plane: where they lie, which are free, and maps out of text, pictures and recordings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.demonstrations import Demonstrations, Recording
from subgoal.mdp.grids.maps import read_map
from subgoal.mdp.grids.occupancy import Occupancy
from subgoal.runtime.errors import BudgetError, InputError, ReadError


def recording(positions):
    return Recording(np.array(positions, float), np.arange(len(positions)), np.array([0, len(positions)]), ("x", "y"))


def test_cells_and_their_centres() -> None:
    room = Occupancy(np.array([[1, 0, 1], [1, 1, 1]], bool), 0.5, (10, -2))
    assert room.cell_of([[10, -2], [10.49, -1.51], [10.5, -1.5], [11.25, -1.75], [9.99, -2], [11.5, -1]]).tolist() == [
        [0, 0], [0, 0], [1, 1], [2, 0], [-1, 0], [3, 2],
    ]  # fmt: skip
    assert room.position_of(np.array([[0, 0], [2, 1], [-1, 5]])).tolist() == [
        [10.25, -1.75],
        [11.25, -1.25],
        [9.75, 0.75],
    ]
    cells = np.array([[0, 0], [1, 0], [2, 1], [3, 1], [0, 2], [-1, 0], [0, -1]])
    assert room.on_map(cells).tolist() == [True, True, True, False, False, False, False]
    assert room.is_free(cells).tolist() == [True, False, True, False, False, False, False]
    assert repr(room) == "Occupancy(3 × 2 cells of 0.5, 5 free)"


def test_positions_at_the_end_of_the_world_are_off_the_map() -> None:
    room = Occupancy(np.ones((2, 2), bool), 1e-3)
    cells = room.cell_of([[1e300, 0], [-1e300, 0], [-1.7e308, 1.7e308]])
    assert not room.on_map(cells).any()
    assert (np.sign(cells[:, 0]) == [1, -1, -1]).all()


@settings(max_examples=200, deadline=None)
@given(
    st.tuples(st.integers(1, 6), st.integers(1, 6)),
    st.floats(1e-3, 1e3),
    st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
)
def test_centres_lie_in_their_cells(shape, resolution, origin) -> None:
    room = Occupancy(np.ones(shape, bool), resolution, origin)
    cells = np.argwhere(room.free)[:, ::-1]
    np.testing.assert_array_equal(room.cell_of(room.position_of(cells)), cells)


def test_a_world_whose_states_lie_at_the_centres() -> None:
    free = np.array([[1, 0, 1], [1, 1, 1]], bool)
    for y_down, north in ((False, (0, 1)), (True, (0, -1))):
        room = Occupancy(free, 2.0, (1, 1), y_down)
        world = room.world(0.9, moves=4)
        np.testing.assert_array_equal(world.mdp.coordinates, room.position_of(world.cells))
        assert tuple(world.directions[world.action("N")].tolist()) == north
        assert world.discount == 0.9


def test_of_a_map_in_text() -> None:
    text = "#.\n..\n"
    up, down = (Occupancy.from_map(read_map(text, origin=origin), 1, (-0.5, -0.5)) for origin in ("lower", "upper"))
    assert not up.is_free(up.cell_of([[0, 1]]))[0] and up.is_free(up.cell_of([[0, 0]]))[0]
    assert not down.is_free(down.cell_of([[0, 0]]))[0] and down.is_free(down.cell_of([[0, 1]]))[0]
    assert (up.y_down, down.y_down) == (False, True)
    assert down.position_of(np.array([[1, 0]])).tolist() == [[1, 0]]


PIXELS = np.array([[0, 127, 128], [205, 254, 255]], np.uint8)


def saved(folder, name, pixels, mode=None):
    from PIL import Image

    path = folder / name
    (Image.fromarray(pixels) if mode is None else Image.fromarray(pixels).convert(mode)).save(path)
    return path


@pytest.mark.parametrize("name", ["a.png", "a.pgm", "a.bmp", "a.tif"])
@pytest.mark.parametrize("mode", [None, "RGB"])
def test_bright_pixels_are_free_and_rows_go_downwards(tmp_path, name, mode) -> None:
    if mode and name.endswith("pgm"):
        pytest.skip("a format without colour")
    path = saved(tmp_path, name, PIXELS, mode)
    assert Occupancy.from_image(path, 0.1).free.astype(int).tolist() == [[1, 1, 1], [0, 0, 1]]
    downwards = Occupancy.from_image(path, 0.1, (5, 6), y_down=True)
    assert downwards.free.astype(int).tolist() == [[0, 0, 1], [1, 1, 1]]
    assert (downwards.y_down, downwards.resolution, downwards.origin.tolist()) == (True, 0.1, [5, 6])


@pytest.mark.parametrize("mode", [None, "RGB", "RGBA"])
def test_thresholds_are_exact(tmp_path, mode) -> None:
    """A pixel as bright as the threshold is free, the next darker one is not, for every level there is."""
    levels = np.arange(256, dtype=np.uint8)[None]
    path = saved(tmp_path, "a.png", levels, mode)
    for level in range(1, 256):
        room = Occupancy.from_image(path, 1, threshold=level / 255)
        np.testing.assert_array_equal(room.free, levels >= level)


def test_thresholds_of_deep_pictures_are_exact(tmp_path) -> None:
    levels = np.arange(2**16, dtype=np.uint16).reshape(256, 256)
    path = saved(tmp_path, "a.png", levels)
    for level in range(1, 2**16, 997):
        room = Occupancy.from_image(path, 1, threshold=level / 65535, y_down=True)
        np.testing.assert_array_equal(room.free, levels >= level)


def test_colours_count_by_their_mean_and_what_is_transparent_is_black(tmp_path) -> None:
    colours = np.array([[[255, 255, 0], [255, 0, 0], [128, 128, 128]]], np.uint8)
    assert Occupancy.from_image(saved(tmp_path, "a.png", colours), 1).free.tolist() == [[True, False, True]]
    opaque = np.array([[255, 128, 127, 0]], np.uint8)
    white = np.dstack([np.full((1, 4, 3), 255, np.uint8), opaque])
    assert Occupancy.from_image(saved(tmp_path, "b.png", white), 1).free.tolist() == [[True, True, False, False]]
    grey = np.dstack([np.full((1, 2), 200, np.uint8), np.array([[255, 100]], np.uint8)])
    from PIL import Image

    Image.fromarray(grey, mode="LA").save(tmp_path / "c.png")
    assert Occupancy.from_image(tmp_path / "c.png", 1).free.tolist() == [[True, False]]


def test_pictures_of_other_depths(tmp_path) -> None:
    deep = saved(tmp_path, "deep.png", np.array([[0, 32767, 32768, 65535]], np.uint16))
    assert Occupancy.from_image(deep, 1).free.tolist() == [[False, False, True, True]]
    bits = saved(tmp_path, "bits.png", np.array([[0, 255]], np.uint8), "1")
    assert Occupancy.from_image(bits, 1).free.tolist() == [[False, True]]
    palette = saved(tmp_path, "palette.png", np.array([[0, 255]], np.uint8), "P")
    assert Occupancy.from_image(palette, 1).free.tolist() == [[False, True]]


def test_pictures_that_cannot_be_used(tmp_path) -> None:
    with pytest.raises(ReadError, match="no such file"):
        Occupancy.from_image(tmp_path / "none.png", 1)
    (tmp_path / "torn.png").write_bytes(saved(tmp_path, "a.png", PIXELS).read_bytes()[:40])
    (tmp_path / "text.png").write_text("no picture")
    for name in ("torn.png", "text.png"):
        with pytest.raises(ReadError, match="wanted a picture"):
            Occupancy.from_image(tmp_path / name, 1)
    (tmp_path / "deep.pgm").write_bytes(b"P5\n3 1\n65535\n" + bytes(6))
    for path in (tmp_path / "deep.pgm", saved(tmp_path, "floats.tif", PIXELS.astype(np.float32))):
        with pytest.raises(ReadError, match=r"pixels of kind '[IF]', wanted 8 or 16 bits"):
            Occupancy.from_image(path, 1)
    with pytest.raises(InputError, match=r"free: .*one at least True"):
        Occupancy.from_image(saved(tmp_path, "dark.png", PIXELS // 4), 1)
    for threshold in (0, -1, 1.1, float("nan"), "bright"):
        with pytest.raises(InputError, match="threshold"):
            Occupancy.from_image(tmp_path / "a.png", 1, threshold=threshold)


def test_around_a_recording() -> None:
    room = Occupancy.around(recording([[1, 7], [38, 21]]), 20)
    assert (room.origin.tolist(), room.free.shape, bool(room.free.all())) == ([0, 0], (2, 2), True)
    wide = Occupancy.around(recording([[1, 7], [38, 21]]), 20, margin=2, y_down=True)
    assert (wide.origin.tolist(), wide.free.shape, wide.y_down) == ([-20, 0], (2, 4), True)
    edge = Occupancy.around(recording([[0, 0], [40, 20]]), 20)
    assert (edge.origin.tolist(), edge.free.shape) == ([0, 0], (2, 3))


def test_around_demonstrations_counts_where_they_ended() -> None:
    demos = Demonstrations([[0.5, 0.5]], [[1.0, 0]], np.array([0, 1]), final_states=[[5.5, -0.5]])
    room = Occupancy.around(demos, 1)
    assert (room.origin.tolist(), room.free.shape) == ([0, -1], (2, 6))


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-100, 100), st.floats(-100, 100)), min_size=1, max_size=5),
    st.floats(0.5, 50),
    st.floats(0, 20),
)
def test_everything_is_on_the_map_and_the_map_no_larger_than_needed(places, resolution, margin) -> None:
    room = Occupancy.around(recording(places), resolution, margin=margin)
    assert room.on_map(room.cell_of(places)).all()
    low, high = np.min(places, axis=0) - margin, np.max(places, axis=0) + margin
    top = room.origin + np.array(room.free.shape[::-1]) * resolution
    slack = 1e-9 * (abs(top).max() + 1)  # rounding of numbers below about a hundred
    assert (room.origin <= low + slack).all() and (top >= high - slack).all()
    assert (room.origin > low - resolution - slack).all() and (top <= high + resolution + slack).all()
    assert np.abs(room.origin / resolution - np.round(room.origin / resolution)).max() < 1e-9


def test_a_first_position_that_rounds_onto_an_edge_is_on_the_map() -> None:
    """1.7 divided by 0.1 rounds to 17, and 17 times 0.1 to what lies above 1.7."""
    place = 1.7
    assert np.floor(place / 0.1) * 0.1 > place
    room = Occupancy.around(recording([[place, place]]), 0.1)
    assert room.on_map(room.cell_of([[place, place]])).all()


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"free": np.zeros((2, 2), bool)}, "free"),
        ({"free": np.ones((2, 2))}, "free: found float64"),
        ({"free": [[True], [True, False]]}, "free"),
        ({"resolution": 0}, "resolution: found 0"),
        ({"resolution": -1}, "resolution"),
        ({"resolution": float("nan")}, "resolution"),
        ({"resolution": float("inf")}, "resolution"),
        ({"resolution": 1e-9, "origin": (5e6, 0)}, r"resolution: found 1e-09, wanted at least 1e-09 of the largest"),
        ({"origin": (0, 0, 0)}, "origin: found 3 numbers"),
        ({"origin": (0, np.nan)}, "origin"),
        ({"origin": "here"}, "origin"),
    ],
)
def test_bad_maps(fields, match) -> None:
    with pytest.raises(InputError, match=match):
        Occupancy(**{"free": np.ones((2, 2), bool), **fields})


def test_bad_positions_and_cells() -> None:
    room = Occupancy(np.ones((2, 2), bool))
    for positions in ([[0.0, np.nan]], [[0.0, 1, 2]], [0.0, 1.0]):
        with pytest.raises(InputError, match="positions"):
            room.cell_of(positions)
    for cells in (np.zeros((1, 2)), np.zeros(2, int), [[0, 1, 2]]):
        for verb in (room.position_of, room.on_map, room.is_free):
            with pytest.raises(InputError, match="cells"):
                verb(cells)


def test_bad_surroundings() -> None:
    lines = Recording(np.zeros((2, 3)), [0, 1], np.array([0, 2]), ("x", "y", "z"))
    with pytest.raises(InputError, match=r"data: found positions with 3 columns, wanted 2"):
        Occupancy.around(lines, 1)
    with pytest.raises(InputError, match="data: found states of a discrete world"):
        Occupancy.around(Demonstrations([0, 1], [0, 0], np.array([0, 2])), 1)
    with pytest.raises(InputError, match="data: found ndarray"):
        Occupancy.around(np.zeros((2, 2)), 1)
    for resolution in (0, np.nan):
        with pytest.raises(InputError, match="resolution"):
            Occupancy.around(recording([[0, 0]]), resolution)
    with pytest.raises(InputError, match="margin"):
        Occupancy.around(recording([[0, 0]]), 1, margin=-1)
    for places, resolution in (([[0, 0], [1e4, 1e4]], 1), ([[-1e308, 0], [1.7e308, 1]], 1)):
        with pytest.raises(BudgetError, match="a coarser resolution"):
            Occupancy.around(recording(places), resolution)


def test_the_record_is_a_copy() -> None:
    free = np.ones((2, 2), bool)
    room = Occupancy(free)
    free[:] = False
    assert room.free.all() and not room.free.flags.writeable and not room.origin.flags.writeable
