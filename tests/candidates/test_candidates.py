"""Candidates: the user's own, grids, visited places, nets, and files of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates, read_candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.errors import BudgetError, InputError, ReadError


def walk(seed: int = 0, n: int = 200) -> Demonstrations:
    generator = np.random.default_rng(seed)
    states = np.cumsum(generator.normal(size=(n, 2)), axis=0)
    ends = generator.uniform(50, 60, (3, 2))
    return Demonstrations.from_arrays(states, generator.normal(size=(n, 2)), [0, 50, 90, n], final_states=ends)


def test_prior_is_normalised_and_uniform_by_default() -> None:
    given = Candidates([[0, 0], [1, 1], [2, 2]], np.log([2.0, 6.0, 8.0]) + 700)
    np.testing.assert_allclose(np.exp(given.log_prior), [1 / 8, 3 / 8, 1 / 2], rtol=1e-12)
    np.testing.assert_allclose(Candidates(np.zeros((4, 1))).log_prior, -np.log(4), rtol=1e-15)
    assert (given.n_candidates, given.radius, given.name(1)) == (3, 0.0, "")


def test_names() -> None:
    named = Candidates.from_points([[0.0], [1.0]], names=["door", "window"])
    assert (named.name(0), named.names) == ("door", ("door", "window"))
    with pytest.raises(InputError, match="'a' twice"):
        Candidates([0.0, 1.0, 2.0], names=("a", "b", "a"))
    with pytest.raises(InputError, match="names: found 1, wanted 2"):
        Candidates([0.0, 1.0], names=("a",))


@pytest.mark.parametrize(
    ("fields", "message"),
    [({"points": []}, "found none"), ({"points": [[0.0], [np.nan]]}, r"index \(1, 0\)"),
     ({"points": [[np.inf]]}, "finite"), ({"points": [["a"]]}, "real numbers"), ({"points": 3.0}, "dimension"),
     ({"points": np.zeros((2, 2, 2))}, "dimension"), ({"points": [0.0], "log_prior": [0.0, 0.0]}, "log_prior"),
     ({"points": [0.0], "log_prior": [np.nan]}, "log_prior"), ({"points": [0.0], "log_prior": [-np.inf]}, "log_prior"),
     ({"points": [0.0], "radius": -1.0}, "radius"), ({"points": [0.0], "radius": np.nan}, "radius"),
     ({"points": [0.0], "metric": Metric.euclidean(2)}, "metric")],
)  # fmt: skip
def test_bad_input_is_named(fields, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Candidates(**fields)


def test_the_callers_arrays_stay_as_they_were() -> None:
    points, prior = np.array([[0.0, 1.0], [2.0, 3.0]]), np.array([5.0, 6.0])
    candidates = Candidates(points, prior)
    assert points.flags.writeable and prior.tolist() == [5.0, 6.0]
    assert not candidates.points.flags.writeable and not candidates.log_prior.flags.writeable


def test_grid_corners_spacing_and_order() -> None:
    grid = Candidates.grid([0.0, -1.0], [1.0, 1.0], 0.5)
    assert grid.n_candidates == 3 * 5
    assert grid.radius == 0.5
    assert grid.points[0].tolist() == [0.0, -1.0]
    assert grid.points[-1].tolist() == [1.0, 1.0]
    assert Candidates.grid([0.0], [0.3], 0.1).n_candidates == 4
    assert Candidates.grid([0.0], [0.29], 0.1).n_candidates == 3
    assert Candidates.grid([2.0], [2.0], 1.0).points.tolist() == [[2.0]]


@pytest.mark.parametrize(
    ("lower", "upper", "spacing", "message"),
    [([0.0], [-1.0], 1.0, "upper"), ([0.0, 0.0], [1.0], 1.0, "upper"), ([0.0], [1.0], 0.0, "spacing"),
     ([np.nan], [1.0], 1.0, "lower"), ([0.0], [np.inf], 1.0, "upper"), ([0.0], [1.0], np.nan, "spacing")],
)  # fmt: skip
def test_bad_grids(lower, upper, spacing, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Candidates.grid(lower, upper, spacing)


def test_huge_grids_are_refused_before_they_are_made() -> None:
    for spacing in (1e-4, 1e-12):
        with pytest.raises(BudgetError, match="wider spacing"):
            Candidates.grid([0.0, 0.0], [1.0, 1.0], spacing)
    assert Candidates.grid([0.0], [1.0], 1e-5).n_candidates == 100_001


@pytest.mark.parametrize("radius", [0.0, 0.5, 3.0, 1000.0])
def test_net_covers_and_keeps_its_distance_and_every_end(radius: float) -> None:
    demos = walk()
    net = subgoal.epsilon_net(demos, radius)
    ends = np.asarray(demos.final_states)
    assert all((net.points == end).all(axis=1).any() for end in ends)
    gap = np.linalg.norm(net.points[:, None] - net.points[None], axis=2)
    inner = gap[len(ends) :][:, len(ends) :]
    assert inner.size == 0 or inner[~np.eye(len(inner), dtype=bool)].min(initial=np.inf) > radius
    cover = np.linalg.norm(np.asarray(demos.states)[:, None] - net.points[None], axis=2).min(axis=1)
    assert cover.max() <= radius
    assert net.radius == radius


def test_net_radius_by_default_is_three_percent_in_the_metric() -> None:
    demos = walk()
    metric = Metric.of(2, [1.0, 10.0])
    everything = np.vstack([demos.states, demos.final_states]) * [1.0, 10.0]
    assert subgoal.epsilon_net(demos, metric=metric).radius == pytest.approx(0.03 * np.ptp(everything, axis=0).max())


def test_visited_places_once_each_ends_included() -> None:
    demos = Demonstrations.from_arrays([[0.0], [1.0], [0.0]], np.ones(3), [0, 3], final_states=[[7.0]])
    assert sorted(subgoal.visited(demos).points.ravel()) == [0.0, 1.0, 7.0]
    discrete = Demonstrations.from_arrays(np.arange(3), np.arange(3))
    with pytest.raises(InputError, match="discrete"):
        subgoal.epsilon_net(discrete)


def write(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "places.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("bom", ["", "\ufeff"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_files_with_names_and_prior(separator: str, bom: str, newline: str, tmp_path: Path) -> None:
    rows = [["x", "y", "name", "prior"], ["1.5", "2", "north gate", "1"], ["3", "-4e0", "sally", "3"]]
    text = bom + newline.join(separator.join(row) for row in rows) + newline
    found = read_candidates(write(tmp_path, text), ["x", "y"])
    assert found.points.tolist() == [[1.5, 2.0], [3.0, -4.0]]
    assert found.names == ("north gate", "sally")
    np.testing.assert_allclose(np.exp(found.log_prior), [0.25, 0.75])


def test_files_with_log_prior_one_column_or_columns_reordered(tmp_path: Path) -> None:
    found = read_candidates(write(tmp_path, "log_prior,y,x\n0,1,2\n-1,3,4\n"), ["x", "y"])
    assert found.points.tolist() == [[2, 1], [4, 3]]
    assert found.log_prior[0] - found.log_prior[1] == pytest.approx(1.0)
    assert read_candidates(write(tmp_path, "x\n1\n2\n"), ["x"]).points.tolist() == [[1.0], [2.0]]


@pytest.mark.parametrize(
    ("text", "message"),
    [("x,z\n1,2\n", "wanted columns"), ("", "readable CSV"), ("\n\n", "readable CSV"), ("x,y\n", "found none"),
     ("x,y\n1\n", "finite"), ("x,y\n1,a\n", "real numbers"), ("x,y\n1,2,3,4\n", "longer than the header"),
     (b"\xff\xfe\x00x,y\n1,2\n", "readable CSV"), ("x,y\n1,1e400\n", "finite"), ("x,y,prior\n1,2,0\n", "prior"),
     ("x,y,prior\n1,2,\n", "prior"), ("x,y,name\n1,2,a\n3,4,a\n", "twice")],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_bad_files_are_named(text, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        read_candidates(write(tmp_path, text), ["x", "y"])


def test_missing_files_and_directories(tmp_path: Path) -> None:
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(ReadError, match="readable CSV"):
            read_candidates(path, ["x"])
