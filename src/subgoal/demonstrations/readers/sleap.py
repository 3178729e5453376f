"""Analysis files of SLEAP (HDF5)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.hdf5 import read_hdf5
from subgoal.demonstrations.readers.tracking import Tracking, animals
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import ReadError


def read_sleap(
    path: Any,
    *,
    bodypart: str | None = None,
    min_likelihood: float = 0.6,
    max_gap: float | None = None,
    rate: float | None = None,
    scale: float = 1.0,
    units: str = "px",
) -> Recording:
    """Read ``tracks`` (animals, 2, nodes, frames) with ``node_names``, ``track_names`` and ``point_scores``.

    Each animal is a trajectory, cut at long gaps; ``bodypart`` is the name of a node, and the other options are
    described in ``Tracking``. Files without ``point_scores`` keep all frames that have a place.

    Raises ``MissingExtraError`` without h5py, ``ReadError`` for a file that is no such export, ``InputError`` for
    a node that is not there.
    """
    how = Tracking(bodypart, min_likelihood, max_gap, rate, scale, units)
    path = plain_file(path)
    arrays = read_hdf5(path, "an analysis file of SLEAP", ("tracks",))
    tracks = arrays["tracks"]
    if tracks.ndim != 4 or tracks.shape[1] != 2 or tracks.dtype.kind not in "iuf":
        found = f"{tracks.dtype} of shape {tracks.shape}"
        raise ReadError(str(path), where="tracks", found=found, wanted="numbers (animals, 2, nodes, frames)")
    nodes = _names(path, arrays, "node_names", tracks.shape[2])
    names = _names(path, arrays, "track_names", tracks.shape[0])
    node = nodes.index(how.choose_bodypart(path, nodes))
    places = np.asarray(tracks[:, :, node, :], dtype=np.float64)
    scores = _scores(path, arrays, tracks.shape, node)
    frames = np.arange(places.shape[2], dtype=np.float64)
    told = [(name, places[k].T, None if scores is None else scores[k], frames) for k, name in enumerate(names)]
    return animals(path, told, how, source_of(path))


def _names(path: Path, arrays: dict[str, Any], key: str, count: int) -> list[str]:
    """Labels of an axis; numbers where there are none (one unnamed track is usual)."""
    given = arrays.get(key)
    if given is None or (given.size == 0 and key == "track_names"):
        return [f"{key.removesuffix('_names')} {k}" for k in range(count)]
    names = [n.decode("utf-8", "replace") if isinstance(n, bytes) else str(n) for n in given.ravel()]
    if len(names) != count or len(set(names)) != count:
        raise ReadError(str(path), where=key, found=str(names[:20]), wanted=f"{count} different names")
    return names


def _scores(path: Path, arrays: dict[str, Any], shape: tuple[int, ...], node: int) -> Any:
    """(animals, frames) likelihood of the node, or None."""
    scores = arrays.get("point_scores")
    if scores is None:
        return None
    if scores.shape != (shape[0], shape[2], shape[3]) or scores.dtype.kind not in "iuf":
        found = f"{scores.dtype} of shape {scores.shape}"
        raise ReadError(str(path), where="point_scores", found=found, wanted="numbers shaped as tracks")
    return np.asarray(scores[:, node, :], dtype=np.float64)
