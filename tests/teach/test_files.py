"""Files in, project folders out."""

from __future__ import annotations

import stat
from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import InputError
from subgoal.teach import files
from subgoal.teach.drawing import Drawing, Sheet
from subgoal.teach.files import _told, planar, read_dropped, save_project
from subgoal.teach.learning import SETTLED, Answer, Tuning, demonstrations_of, learn
from subgoal.teach.limits import Limits
from subgoal.teach.messages import RefusedError
from tests.teach.made import Page, served, square

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")
OWN = b"time,y,z,stroke\n0,1,2,stroke 1\n0.5,1.5,2,stroke 1\n0.2,0,0,stroke 2\n0.3,1,0,stroke 2\n"
LEGS = "t,x,y\n" + "".join(f"{0.1 * k},{min(k, 20) * 10},{max(k - 20, 0) * 10}\n" for k in range(41))


def drawn() -> tuple[Sheet, Answer]:
    drawing = Drawing(Limits())
    drawing.begin()
    drawing.add(tuple(square()))
    drawing.lift()
    return drawing.sheet(), learn(demonstrations_of(drawing.sheet().recording()), Tuning(), SETTLED)


def save(out: Path) -> Path:
    sheet, answer = drawn()
    assert answer.posterior is not None
    return save_project(sheet, answer.found, answer.posterior, out)


def drop(page: Page, name: str, content: bytes) -> None:
    page.number += 1
    head = f'{{"type": "file", "number": {page.number}, "name": "{name}"}}\n'
    page.socket.send(head.encode() + content)


def test_a_saved_recording_is_read_as_it_was() -> None:
    found = read_dropped("recording.csv", OWN, Limits())
    assert found.positions.tolist() == [[1, 2], [1.5, 2], [0, 0], [1, 0]]
    assert (found.offset.tolist(), found.names, found.units) == ([0, 2, 4], ("y", "z"), "m")


def test_other_tables_are_read_by_their_own_columns() -> None:
    found = read_dropped("a.csv", LEGS.encode(), Limits())
    assert (found.names, found.n_trajectories, len(found.times)) == (("x", "y"), 1, 41)


def test_of_three_columns_y_and_z_lie_on_the_plane() -> None:
    places = np.arange(12.0).reshape(4, 3)
    given = Recording(places, np.arange(4.0), np.array([0, 4]), ("x", "y", "z"))
    assert planar(given).positions.tolist() == places[:, 1:].tolist()
    other = Recording(places, np.arange(4.0), np.array([0, 4]), ("u", "v", "w"))
    assert planar(other).positions.tolist() == places[:, :2].tolist()


def test_one_column_lies_on_no_plane() -> None:
    with pytest.raises(InputError, match="one column"):
        planar(Recording(np.zeros((2, 1)), np.arange(2.0), np.array([0, 2]), ("x",)))


@pytest.mark.parametrize(("name", "content"), [
    ("a.csv", b""), ("a.csv", b"\x00\x01\x02"), ("a.xyz", b"x,y\n1,2\n"), ("a.npz", b"PK\x03\x04"), ("a.mcap", b"x"),
    ("a.csv", b"a,b\n1,2\n"), ("..", b"x,y\n1,2\n"), ("/etc/passwd", b"x"), ("...csv", OWN[:20]),
])  # fmt: skip
def test_what_is_no_recording_is_refused_with_a_sentence(name: str, content: bytes) -> None:
    with pytest.raises(RefusedError) as told:
        read_dropped(name, content, Limits())
    assert name in told.value.text
    assert not any(word in told.value.text for word in ("/tmp", "subgoal-teach", "Try", "="))


def test_what_was_opened_is_told(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        drop(page, "legs.csv", LEGS.encode())
        assert page.hear("opened", "error") == {
            "type": "opened", "name": "legs.csv", "points": 41, "columns": ["x", "y"], "unit": "",
        }  # fmt: skip


def test_a_path_within_a_sentence_becomes_the_name() -> None:
    path = Path("/somewhere/aside/a_.csv")
    problem = InputError(str(path), found=f"a torn {path}", wanted="a whole one", hint="repair=True")
    assert _told(problem, path, "a*.csv") == "a*.csv: found a torn a*.csv, wanted a whole one."


def test_a_name_leads_nowhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert read_dropped("../../../../tmp/evil.csv", OWN, Limits()).n_trajectories == 2
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("limits", [Limits(points=3), Limits(strokes=1)])
def test_a_file_is_no_larger_than_a_drawing(limits: Limits) -> None:
    with pytest.raises(RefusedError, match="at most"):
        read_dropped("recording.csv", OWN, limits)


def test_a_dropped_file_takes_the_place_of_the_drawing_and_is_learned_from(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square()[:100])
        page.answer("full")
        drop(page, "legs.csv", LEGS.encode())
        shown = page.hear("drawing")
        assert (shown["names"], len(shown["strokes"][0])) == (["x", "y"], 41)
        left, right, low, high = shown["view"]
        assert left < 0 < 200 < right
        assert low < 0 < 200 < high
        assert page.answer("full")["n"] == 2


def test_a_file_that_cannot_be_read_leaves_the_drawing_alone(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square())
        drop(page, "a.csv", b"\x00\x01")
        assert page.hear("error")["code"] == "file"
        page.do("begin")
        assert page.done()["points"] == len(square())


def test_a_file_that_is_too_large_is_refused(tmp_path: Path) -> None:
    with served(tmp_path, Limits(file_bytes=1000)) as server, server.opened() as page:
        drop(page, "a.csv", b"0" * 1001)
        assert page.hear("error")["code"] == "too-large"


def test_a_project_is_whole_and_can_be_read_by_others(tmp_path: Path) -> None:
    folder = save(tmp_path / "new")
    names = {path.name for path in folder.iterdir()}
    assert {"recording.csv", "waypoints.csv", "waypoints.json", "report.html", "subgoals.csv", "segments.csv",
            "summary.json", "posterior.npz"} <= names  # fmt: skip
    assert stat.S_IMODE(folder.stat().st_mode) & 0o055 == 0o055
    assert [path.name for path in (tmp_path / "new").iterdir()] == [folder.name]
    assert subgoal.load(folder / "posterior.npz").n_observations == 161


def test_projects_of_one_second_stand_beside_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files.time, "strftime", lambda _: "teach-now")
    first, second = save(tmp_path), save(tmp_path)
    assert first.name == "teach-now"
    assert second.name.startswith("teach-now-")
    assert (first / "report.html").exists()


def test_a_project_that_cannot_be_written_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object, **__: object) -> None:
        raise OSError("no space")

    monkeypatch.setattr(files, "write_results", fails)
    with pytest.raises(OSError, match="no space"):
        save(tmp_path)
    assert not any(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_in_any_more_is_told_without_its_place(tmp_path: Path) -> None:
    (tmp_path / "gone").write_text("here")
    with served(tmp_path / "gone") as server, server.opened() as page:
        page.draw(square())
        page.do("save")
        text = page.hear("error", "saved")["text"]
    assert text.startswith("Could not save: ")
    assert str(tmp_path) not in text
