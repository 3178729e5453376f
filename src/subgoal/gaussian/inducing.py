"""A few places that stand for many points, chosen in the same way every time."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.runtime.checks import Floats, real_array, whole
from subgoal.runtime.errors import InputError


def farthest_points(points: Any, count: int, *, scale: Any = 1.0) -> Floats:
    """(count, d) of the points (n, d): the first, then each time the one farthest from those chosen (Gonzalez 1985).

    No point is farther from the nearest chosen one than twice what the best choice allows, and none is chosen twice.
    ``scale`` is a length, or (d,) lengths, by which differences are divided: length scales of a covariance, say.
    In O(n·count). Raises ``InputError`` where there are fewer distinct points.
    """
    given, count = real_array("points", points, ndim=2), whole("count", count)
    scaled = given / _lengths(scale, given)
    chosen, gap = np.zeros(count, np.int64), np.full(len(given), np.inf)
    for k in range(count):
        farthest = int(gap.argmax()) if len(gap) else 0
        if not len(gap) or not gap[farthest] > 0:
            raise InputError("count", found=count, wanted=f"at most {k}, the number of distinct points")
        chosen[k] = farthest
        gap = np.minimum(gap, ((scaled - scaled[farthest]) ** 2).sum(axis=1))
    return np.asarray(given[chosen])


def k_means_centres(points: Any, count: int, *, scale: Any = 1.0, seed: int = 0) -> Floats:
    """(count, d) centres of clusters of the points (n, d), by k-means of scikit-learn.

    ``scale`` as in ``farthest_points``. Raises ``InputError`` where there are fewer distinct points.
    """
    from sklearn.cluster import KMeans

    given, count = real_array("points", points, ndim=2), whole("count", count)
    lengths = _lengths(scale, given)
    distinct = len(np.unique(given, axis=0))
    if count > distinct:
        raise InputError("count", found=count, wanted=f"at most {distinct}, the number of distinct points")
    found = KMeans(count, n_init=1, random_state=whole("seed", seed, least=0)).fit(given / lengths)
    return np.asarray(found.cluster_centers_ * lengths)


def _lengths(scale: Any, points: Floats) -> Floats:
    lengths = real_array("scale", scale, ndim=(0, 1))
    if lengths.shape not in ((), points.shape[1:]) or not (lengths > 0).all():
        raise InputError("scale", found=lengths, wanted=f"a number above 0, or {points.shape[1]} of them")
    return lengths
