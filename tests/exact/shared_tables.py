"""Small likelihood tables with trajectories, and how far a long run is from an enumerated law."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from subgoal.partition.protocol import Chain
from tests.oracles.tables import PRIOR, TABLES

FLAT = np.zeros((4, 3))
BARRED = np.log(np.array([[0.7, 0.2, 0.4], [0.1, 0.6, 0.3], [0.5, 0.4, 0.9], [0.2, 0.8, 0.1]]))
BARRED[1, 0] = BARRED[2, 1] = -np.inf
ALL = TABLES | {"flat": FLAT, "barred": BARRED}


def with_trajectories(
    dense: np.ndarray, starts: tuple[int, ...], prior: np.ndarray | None = None, edges: tuple[int, ...] = (),
    tiled: bool = False,
) -> SimpleNamespace:  # fmt: skip
    """What a sampler sees: ``starts`` are the first rows of trajectories, ``edges`` inner boundaries of blocks."""
    n, g_count = dense.shape
    prior = PRIOR[:g_count] / PRIOR[:g_count].sum() if prior is None else prior
    likelihood = np.exp(dense)
    relative = likelihood / (likelihood @ prior)[:, None]
    bounds = np.array([0, *edges, n])
    return SimpleNamespace(
        n_observations=n, n_candidates=g_count, log_prior=np.log(prior), dense=None if tiled else dense,
        relative=None if tiled else relative, edges=bounds, offset=np.array([*starts, n]),
        tiles=lambda: ((int(a), dense[a:b]) for a, b in pairwise(bounds)),
        rows=lambda a, b: dense[a:b], relative_tile=lambda start, tile: relative[start : start + len(tile)],
    )  # fmt: skip


def distance_ratio(draws: np.ndarray, law: dict[tuple[int, ...], float], thinned: int = 2) -> float:
    """Total variation of the draws (S, N) from ``law``, over that of S / ``thinned`` independent draws on average."""
    states, pi = list(law), np.array(list(law.values()))
    pi = pi / pi.sum()
    place = {state: k for k, state in enumerate(states)}
    reached = np.bincount([place[tuple(int(g) for g in t)] for t in draws], minlength=len(states)) / len(draws)
    count = len(draws) // thinned
    independent = np.random.default_rng(8).multinomial(count, pi, size=200) / count
    return float(np.abs(reached - pi).sum() / np.abs(independent - pi).sum(axis=1).mean())


def worst_gap(got: np.ndarray, wanted: np.ndarray) -> float:
    """Largest difference of means and of variances of the columns, in standard errors."""
    gaps = []
    for a, b in zip(got.T, wanted.T, strict=True):
        for x, y in ((a, b), ((a - b.mean()) ** 2, (b - b.mean()) ** 2)):
            gaps.append(abs(x.mean() - y.mean()) / np.sqrt(x.var() / x.size + y.var() / y.size + 1e-300))
    return float(max(gaps))


def assert_cuts_change_nothing(model, eta: float, starts: tuple[int, ...]):
    """Nine sweeps are four and five; blocks and tiles give the same draws; inputs stay. Returns the nine."""
    dense, keep = TABLES["generic"], np.arange(9) % 2 == 0
    whole = model(Chain(with_trajectories(dense, starts), eta, np.random.default_rng(3)), keep)
    generator = np.random.default_rng(3)
    table = with_trajectories(dense, starts, edges=(1, 2), tiled=True)
    start = model(Chain(table, eta, generator), keep[:4])
    before = {name: value.copy() for name, value in start.state.items()}
    rest = model(Chain(table, eta, generator, start.state), keep[4:])
    for name, value in whole.state.items():
        assert np.array_equal(value, rest.state[name])
        assert np.array_equal(before[name], start.state[name])
    for trace in ("assignments", "log_joint"):
        assert np.array_equal(getattr(whole, trace), np.concatenate([getattr(start, trace), getattr(rest, trace)]))
    for name, values in whole.parameters.items():
        assert np.array_equal(values, np.concatenate([start.parameters[name], rest.parameters[name]]))
    return whole
