"""Maps in text: read as drawn, printed so that they read back, and refused with row and line."""

from __future__ import annotations

import os
import string
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.maps import TextMap, print_map, read_map, read_maps
from subgoal.runtime.errors import InputError, ReadError

KITCHEN = """kitchen
XXPXX
O . O
X   X
XDXSX

corridor
#.a.b#
"""


def listed(tiles):
    return {tile: [tuple(cell) for cell in cells.tolist()] for tile, cells in tiles.items()}


def test_rows_downwards() -> None:
    maps = read_maps(KITCHEN, blocked="PODS", origin="upper")
    assert list(maps) == ["kitchen", "corridor"]
    kitchen = maps["kitchen"]
    assert listed(kitchen.tiles) == {"D": [(1, 3)], "O": [(0, 1), (4, 1)], "P": [(2, 0)], "S": [(3, 3)]}
    assert kitchen.free.astype(int).tolist() == [[0] * 5, [0, 1, 1, 1, 0], [0, 1, 1, 1, 0], [0] * 5]
    assert maps["corridor"].free.astype(int).tolist() == [[0, 1, 1, 1, 1, 0]]
    assert repr(kitchen) == "TextMap('kitchen': 5 × 4, 6 free cells, tiles 'DOPS')"


def test_rows_upwards() -> None:
    """With y upwards the last row is y = 0, and going N in the world is going up in the text."""
    there = read_map("#.\n.a\n..\n")
    assert there.free.astype(int).tolist() == [[1, 1], [1, 1], [0, 1]]
    assert listed(there.tiles) == {"a": [(1, 1)]}
    for origin in ("lower", "upper"):
        drawn = read_map("b.\na.\n", origin=origin)
        world = GridWorld(drawn.free, 0.9, moves=4, origin=drawn.origin)
        start, above = (world.states(drawn.tiles[tile])[0] for tile in "ab")
        assert world.targets[start, world.action("N")] == above


def test_tiles_are_free_unless_blocked() -> None:
    text = "a.b\n.#X\n"
    assert read_map(text).free.sum() == 4
    assert read_map(text, blocked="a").free.sum() == 3
    assert read_map(text, walls="#").free.sum() == 5
    assert listed(read_map(text, walls="#", blocked="X").tiles) == {"a": [(0, 1)], "b": [(2, 1)], "X": [(2, 0)]}


def test_files(tmp_path) -> None:
    for content in (KITCHEN.encode(), KITCHEN.replace("\n", "\r\n").encode(), "\ufeff".encode() + KITCHEN.encode()):
        (tmp_path / "maps.txt").write_bytes(content)
        for path in (tmp_path / "maps.txt", str(tmp_path / "maps.txt")):
            maps = read_maps(path)
            assert list(maps) == ["kitchen", "corridor"]
            assert maps["kitchen"].free.shape == (4, 5)
    (tmp_path / "one.txt").write_text("\n\n#.\n..\n\n\n")
    assert read_map(tmp_path / "one.txt").name == "one"
    assert read_map("#.\n").name == ""
    assert read_maps(KITCHEN.replace("\n", "\r\n"))["kitchen"].free.shape == (4, 5)


def test_print_as_drawn() -> None:
    free = np.array([[1, 0, 1], [1, 1, 1]], bool)
    assert print_map(free, marks={"g": [(2, 1)], "s": [(0, 0)], "?": []}) == "..g\ns#.\n"
    assert print_map(free, marks={"D": [(1, 0)]}, walls="X", origin="upper") == ".D.\n...\n"
    with pytest.raises(InputError, match=r"marks: found 's' on free cells and on walls, wanted two marks"):
        print_map(free, marks={"s": [(0, 0), (1, 0)]})


VISIBLE = [*sorted(set(string.printable) - set(string.whitespace) - set("#X.")), "é", "→", "目"]


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_what_is_printed_reads_back(data) -> None:
    height, width = data.draw(st.integers(1, 5)), data.draw(st.integers(1, 5))
    kinds = data.draw(st.lists(st.sampled_from(VISIBLE), max_size=4, unique=True))
    blocked = "".join(tile for tile in kinds if data.draw(st.booleans()))
    cells = [(x, y) for y in range(height) for x in range(width)]
    content = {cell: data.draw(st.sampled_from([".", "#", *kinds])) for cell in cells}
    free = np.array([[content[x, y] not in "#" + blocked for x in range(width)] for y in range(height)])
    marks = {tile: [cell for cell in cells if content[cell] == tile] for tile in kinds}
    origin = data.draw(st.sampled_from(["lower", "upper"]))
    text = print_map(free, marks=marks, origin=origin)
    found = read_map(text, blocked=blocked, origin=origin)
    np.testing.assert_array_equal(found.free, free)
    assert listed(found.tiles) == {tile: placed for tile, placed in marks.items() if placed}
    assert print_map(found.free, marks=found.tiles, origin=origin) == text
    named = read_maps(f"the first\n{text}\n\nthe second\n{text}", blocked=blocked, origin=origin)
    for there in named.values():
        np.testing.assert_array_equal(there.free, free)
        assert listed(there.tiles) == listed(found.tiles)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "map: found no rows"),
        ("\n\n\n", "map: found no rows"),
        ("a\n...\n..\n", r"map at layout 'a', row 1, line 3: found 2 characters, wanted 3, as in the first row"),
        ("a\n...\n\nb\n.. \n....\n", r"map at layout 'b', row 1, line 6: found 4 characters"),
        ("a\n...\n...\n  \n\n", r"map at layout 'a', row 2, line 4: found 2 characters"),
        ("a\n\n..\n", r"map at layout 'a', line 1: found no rows"),
        ("a\n...\n\na\n...\n", r"map at layout 'a', line 4: found the name twice"),
        ("   \n..\n", r"map at line 1: found '   ', wanted a name"),
        ("a\n.\t.\n", r"map at layout 'a', row 0, line 2: found '\\t', wanted characters that can be seen"),
        ("a\n.\0.\n", r"map at layout 'a', row 0"),
        ("a\n..\r..\n", r"map at layout 'a', row 0"),
        ("XXPXX\nO   P\nXXXXX\n", r"map at line 1: found 'XXPXX', wanted a name that cannot be a row.*read_map for"),
        (b"a\n..\n", "map: found bytes, wanted text, or the name of a file"),
        (None, "map: found NoneType"),
    ],
)
def test_maps_that_cannot_be_read(text, match) -> None:
    with pytest.raises(InputError, match=match):
        read_maps(text)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("..\n...\n", r"map at row 1, line 2: found 3 characters, wanted 2"),
        ("a\n..\n\nb\n..\n", r"map at line 4: found a second map, wanted one\. Try: read_maps"),
        ("\n", "map: found no rows"),
    ],
)
def test_one_map_that_cannot_be_read(text, match) -> None:
    with pytest.raises(InputError, match=match):
        read_map(text)


def test_files_that_cannot_be_read(tmp_path) -> None:
    with pytest.raises(ReadError, match=r"nowhere\.txt: found no such file"):
        read_map(tmp_path / "nowhere.txt")
    with pytest.raises(ReadError, match="a folder"):
        read_maps(tmp_path)
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(ReadError, match="an empty file"):
        read_maps(tmp_path / "empty")
    (tmp_path / "bytes").write_bytes(b"a\n\xff\xfe\n")
    with pytest.raises(ReadError, match="text in UTF-8"):
        read_maps(tmp_path / "bytes")


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"walls": ""}, "walls: found none"),
        ({"walls": "#."}, "walls: found '#.'"),
        ({"walls": None}, "walls"),
        ({"blocked": "X"}, "blocked: found 'X'"),
        ({"blocked": " "}, "blocked"),
        ({"origin": "top"}, "origin: found 'top'"),
    ],
)
def test_bad_choices(fields, match) -> None:
    for read in (read_map, lambda text, **fields: read_maps(f"name\n{text}", **fields)):
        with pytest.raises(InputError, match=match):
            read("..\n", **fields)


@pytest.mark.parametrize(
    ("marks", "match"),
    [
        ({"ab": [(0, 0)]}, "marks: found 'ab', wanted one visible character"),
        ({"#": [(0, 0)]}, "marks"),
        ({".": [(0, 0)]}, "marks"),
        ({"\n": [(0, 0)]}, "marks"),
        ({3: [(0, 0)]}, "marks: found 3"),
        ({"a": [(0, 0)], "b": [(0, 0)]}, r"marks at cell \(0, 0\): found 'b' upon another"),
        ({"a": [(3, 0)]}, r"cells at tile 'a': found \(3, 0\), wanted a cell of 3 × 2"),
        ({"a": [(0, -1)]}, r"cells at tile 'a': found \(0, -1\)"),
        ({"a": [(0.0, 1.0)]}, "cells at tile 'a': found float64"),
        ({"a": [(0, 0), (1,)]}, "cells: found rows of different lengths"),
    ],
)
def test_bad_marks(marks, match) -> None:
    with pytest.raises(InputError, match=match):
        print_map(np.ones((2, 3), bool), marks=marks)


def test_the_record_is_a_copy_and_checks_itself() -> None:
    free, cells = np.ones((2, 2), bool), np.array([[0, 1]])
    there = TextMap("here", free, {"a": cells})
    free[:] = False
    cells[:] = 7
    assert there.free.all() and there.tiles["a"].tolist() == [[0, 1]]
    assert not there.free.flags.writeable and not there.tiles["a"].flags.writeable
    for bad in (np.ones((2, 2)), np.ones(3, bool), np.ones((0, 2), bool), [[True], [True, False]]):
        with pytest.raises(InputError, match="free"):
            TextMap("here", bad)
        with pytest.raises(InputError, match="free"):
            print_map(bad)
    with pytest.raises(InputError, match="tile 'a'"):
        TextMap("here", np.ones((2, 2), bool), {"a": [(2, 0)]})


def test_kitchens_of_overcooked() -> None:
    """Tiles lie where the recorded events took place."""
    given = os.environ.get("SUBGOAL_DATA")
    path = Path(given or "nowhere") / "overcooked_human" / "layouts.txt"
    if not path.is_file():
        pytest.skip("SUBGOAL_DATA does not name a folder that holds overcooked_human/layouts.txt")
    maps = read_maps(path, blocked="OPDS", origin="upper")
    assert list(maps) == ["asymmetric_advantages", "coordination_ring", "cramped_room", "random0", "random3"]
    room = maps["cramped_room"]
    assert listed(room.tiles) == {"D": [(1, 3)], "O": [(0, 1), (4, 1)], "P": [(2, 0)], "S": [(3, 3)]}
    assert room.free.sum() == 6
    assert {name: int(there.free.sum()) for name, there in maps.items()} == {
        "asymmetric_advantages": 14, "coordination_ring": 8, "cramped_room": 6, "random0": 6, "random3": 14,
    }  # fmt: skip
