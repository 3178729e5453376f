"""Shortest ways between cells of a grid world, and the actions they are made of."""

from __future__ import annotations

import numpy as np

from subgoal.mdp.grids.grid import GridWorld
from subgoal.runtime.checks import Ints


def steps_between(world: GridWorld, start: Ints, end: Ints) -> Ints:
    """(M,) the action that leads from each state to the next when nothing slips; −1 where no single one does.

    For a state and itself it is the action that stays, whether the world has it or not: its number is ``moves``.
    """
    actions = np.where(start == end, world.moves, -1)
    for action in range(world.moves):
        actions[(world.targets[start, action] == end) & (start != end)] = action
    return actions


def shortest_ways(world: GridWorld, pairs: Ints) -> list[Ints]:
    """The states of a way with the fewest steps for each pair (P, 2), first and last included; empty: there is none.

    Of the ways with the fewest steps, the one whose every step goes to the cell nearest to the straight line from
    first to last; of cells equally near, the one whose direction comes first, clockwise from N.
    """
    ways = _straight(world, pairs)
    distance = np.full(world.n_states, -1)
    for k in range(len(pairs)):
        if not len(ways[k]):
            first, last = pairs[k].tolist()
            met = _spread(world.targets, last, first, distance)
            if distance[first] >= 0:
                ways[k] = _walked(world, first, last, distance)
            distance[met] = -1
    return ways


def _straight(world: GridWorld, pairs: Ints) -> list[Ints]:
    """The ways that are as short as without walls, all side by side; empty where a wall is in the way.

    No way is shorter, and the cells to choose from where there are walls are some of those without: so what is chosen
    without, if it is free, is what is chosen with them.
    """
    at, goal = pairs[:, 0].copy(), world.cells[pairs[:, 1]]
    begin, line = world.cells[at], goal - world.cells[at]
    walkers, met, blocked = [np.arange(len(pairs))], [at.copy()], np.zeros(len(pairs), bool)
    walking = np.flatnonzero(pairs[:, 0] != pairs[:, 1])
    while walking.size:
        here, there = world.cells[at[walking]], goal[walking]
        ahead = here[:, None] + world.directions[: world.moves]
        shorter = _steps(world, there[:, None] - ahead) < _steps(world, there - here)[:, None]
        chosen = np.where(shorter, _off_line(line[walking, None], ahead - begin[walking, None]), np.inf).argmin(axis=1)
        after = world.targets[at[walking], chosen]
        blocked[walking] = after == at[walking]
        at[walking] = after
        walking = walking[~blocked[walking]]
        walkers.append(walking)
        met.append(at[walking])
        walking = walking[at[walking] != pairs[walking, 1]]
    walker = np.concatenate(walkers)
    order = np.argsort(walker, kind="stable")
    ways = np.split(np.concatenate(met)[order], np.cumsum(np.bincount(walker, minlength=len(pairs)))[:-1])
    return [way[:0] if wall else way for way, wall in zip(ways, blocked, strict=False)]


def _steps(world: GridWorld, apart: Ints) -> Ints:
    """Fewest steps to what is ``apart`` (..., 2), without walls."""
    return np.asarray(np.abs(apart).max(axis=-1) if world.moves == 8 else np.abs(apart).sum(axis=-1))


def _off_line(line: Ints, apart: Ints) -> Ints:
    """How far places ``apart`` (..., 2) from the beginning of ``line`` (..., 2) lie off it, times its length."""
    return np.asarray(np.abs(line[..., 0] * apart[..., 1] - line[..., 1] * apart[..., 0]))


def _spread(targets: Ints, source: int, until: int, distance: Ints) -> Ints:
    """Write the steps to ``source`` into ``distance``, −1 so far, wave by wave until ``until`` is met.

    Returns the states written. Every step has its reverse, so that steps to and from are the same number.
    """
    front = np.array([source])
    distance[front] = 0
    waves = [front]
    while front.size and distance[until] < 0:
        ahead = np.unique(targets[front])
        front = ahead[distance[ahead] < 0]
        distance[front] = len(waves)
        waves.append(front)
    return np.concatenate(waves)


def _walked(world: GridWorld, first: int, last: int, distance: Ints) -> Ints:
    """Down the distances, nearest to the line."""
    begin, line = world.cells[first], world.cells[last] - world.cells[first]
    way = [first]
    while way[-1] != last:
        ahead = world.targets[way[-1]]
        ahead = ahead[distance[ahead] == distance[way[-1]] - 1]
        way.append(int(ahead[np.argmin(_off_line(line, world.cells[ahead] - begin))]))
    return np.array(way)
