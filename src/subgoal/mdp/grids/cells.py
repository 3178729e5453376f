"""From positions over time to a discrete world: the cells gone through, and the steps between them."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np

from subgoal.demonstrations.recordings import piece_names
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.occupancy import Occupancy
from subgoal.mdp.grids.samples import Samples, samples_of
from subgoal.mdp.grids.shortest_ways import shortest_ways, steps_between
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError


class _Links(NamedTuple):
    """From each sample to the next one, (M − 1,).

    ``joined``: whether the two belong together. ``ways``: the states gone through, first and last included, of those
    that are further apart than a step.
    """

    joined: Bools
    ways: dict[int, Ints]


def to_cells(
    data: Recording | Demonstrations,
    occupancy: Occupancy,
    *,
    discount: float,
    moves: int = 8,
    stay: bool = True,
    slip: tuple[float, ...] | None = None,
    cut_corners: bool = True,
    staying: Literal["keep", "once", "drop"] = "keep",
    outside: Literal["raise", "drop"] = "raise",
) -> tuple[GridWorld, Demonstrations]:
    """The world of the free cells, and the recording as states and actions in it.

    Of each two samples in a row the first gives the state and the step to the second one the action. Where they are
    further apart than one step, the cells of a shortest way between them are filled in (``shortest_ways`` has the
    rule). Recorded actions and velocities are not looked at, nor is it known whether something slipped.

    Parameters
    ----------
    data:
        A Recording, or Demonstrations with positions; two columns, x and y. The end of a trajectory, where it is not
        its last state, is one more sample, as long after it as the last two are apart.
    occupancy:
        Which cells are free, in the units of the data.
    discount, moves, stay, slip, cut_corners:
        As of ``GridWorld``.
    staying:
        What becomes of samples that stay in their cell. "keep": each is a pair with the action "stay". "once": one
        such pair for each visit of a cell. "drop": none.
    outside:
        Positions in walls and off the map, and samples between which there is no way: "raise", or "drop", which leaves
        such samples out and cuts the trajectory there, into pieces called "name/0", "name/1".

    Returns
    -------
    The world, whose states lie at the centres of the cells, and demonstrations of it with those as coordinates, so
    that places are in the units of the data. The time of a pair is that of its sample; of the pair that leaves a cell
    it is, with "drop", when the cell was entered; for cells that were filled in it is interpolated. A piece whose
    trajectory went on is ``truncated``. What was dropped, cut and filled in is counted in ``source.notes``, and so is
    standing still.

    Raises
    ------
    InputError
        A position in a wall or off the map, or no way, naming row and position; nothing left; an option out of range.
    """
    if not isinstance(occupancy, Occupancy):
        raise InputError("occupancy", found=type(occupancy).__name__, wanted="an Occupancy")
    _check_choices(staying, outside, stay)
    samples = samples_of(data)
    world = occupancy.world(discount, moves=moves, stay=stay, slip=slip, cut_corners=cut_corners)
    states, off = _states(world, occupancy, samples, outside)
    links, cut = _links(world, samples, states, outside)
    pairs = _pairs(world, samples, states, links, staying)
    return world, _demonstrations(data, world, samples, states, pairs, {**off, **cut, **pairs.notes})


def _check_choices(staying: str, outside: str, stay: bool) -> None:
    for what, given, known in (("staying", staying, ("keep", "once", "drop")), ("outside", outside, ("raise", "drop"))):
        if given not in known:
            raise InputError(what, found=repr(given), wanted=" or ".join(map(repr, known)))
    if not stay and staying != "drop":
        raise InputError("staying", found=repr(staying), wanted="'drop': the world has no action that stays")


def _told(position: Floats) -> str:
    return f"({position[0]:g}, {position[1]:g})"


def _states(world: GridWorld, occupancy: Occupancy, samples: Samples, outside: str) -> tuple[Ints, dict[str, int]]:
    """(M,) the state of each sample, −1 for what is dropped."""
    cells = occupancy.cell_of(samples.positions)
    on_map, free = occupancy.on_map(cells), occupancy.is_free(cells)
    if outside == "raise" and not free.all():
        i = int(np.argmin(free))
        found = f"{_told(samples.positions[i])}, which is {'in a wall' if on_map[i] else 'off the map'}"
        raise InputError("positions", where=samples.place(i), found=found, wanted="a free cell", hint="outside='drop'")
    x, y = np.where(free[:, None], cells, 0).T
    return np.where(free, world.numbers[y, x], -1), {
        "samples_off_the_map_dropped": int((~on_map).sum()),
        "samples_in_walls_dropped": int((on_map & ~free).sum()),
    }


def _links(world: GridWorld, samples: Samples, states: Ints, outside: str) -> tuple[_Links, dict[str, int]]:
    """What belongs together, and how one gets from each sample to the next."""
    begin, end = states[:-1], states[1:]
    joined = (begin >= 0) & (end >= 0) & (samples.trajectory[:-1] == samples.trajectory[1:])
    far = np.flatnonzero(joined)
    far = far[steps_between(world, begin[far], end[far]) < 0]
    different, which = np.unique(np.stack([begin[far], end[far]], axis=1), axis=0, return_inverse=True)
    found = shortest_ways(world, different)
    ways = {i: found[k] for i, k in zip(far.tolist(), which.ravel().tolist(), strict=True)}
    lost = [i for i in ways if not len(ways[i])]
    if lost and outside == "raise":
        told = " to ".join(_told(samples.positions[lost[0] + k]) for k in (0, 1))
        raise InputError(
            "positions", where=samples.place(lost[0] + 1), found=f"no way over free cells from {told}",
            wanted="a way", hint="outside='drop' cuts the trajectory there",
        )  # fmt: skip
    joined[lost] = False
    return _Links(joined, {i: way for i, way in ways.items() if len(way)}), {"steps_without_a_way_cut": len(lost)}


class _Pairs(NamedTuple):
    """N pairs of state and action; the sample each comes from, its time or None; what was counted."""

    states: Ints
    actions: Ints
    sample: Ints
    times: Any
    first: Ints
    last: Ints
    notes: dict[str, int]


def _pairs(world: GridWorld, samples: Samples, states: Ints, links: _Links, staying: str) -> _Pairs:
    apart = np.concatenate([[True], ~links.joined, [True]])
    first, last = (np.flatnonzero((states >= 0) & edge) for edge in (apart[:-1], apart[1:]))
    still = links.joined & (states[:-1] == states[1:])
    entered = np.concatenate([[True], ~still])
    kept = {"keep": still, "once": still & entered[:-1], "drop": np.zeros_like(still)}[staying]
    counts = (links.joined & (~still | kept)).astype(np.int64)
    counts[list(links.ways)] = [len(way) - 1 for way in links.ways.values()]
    sample = np.repeat(np.arange(len(counts)), counts)
    begins = np.cumsum(counts) - counts
    here, ahead = states[sample], states[sample + 1]
    for i, way in links.ways.items():
        here[begins[i] + 1 : begins[i] + counts[i]] = way[1:-1]
        ahead[begins[i] : begins[i] + counts[i] - 1] = way[1:-1]
    times = None
    if samples.times is not None:
        part = (np.arange(len(sample)) - begins[sample]) / counts[sample]
        times = samples.times[sample] + part * (samples.times[sample + 1] - samples.times[sample])
        if staying == "drop":
            since = np.maximum.accumulate(np.where(entered, np.arange(len(states)), 0))
            times = np.where(part == 0, samples.times[since[sample]], times)
    return _Pairs(
        here, steps_between(world, here, ahead), sample, times, first, last,
        {
            "pairs_filled_in_between_samples": sum(len(way) - 2 for way in links.ways.values()),
            "pairs_of_standing_still_kept": int(kept.sum()),
            "pairs_of_standing_still_dropped": int(still.sum() - kept.sum()),
        },
    )  # fmt: skip


def _demonstrations(
    data: Any, world: GridWorld, samples: Samples, states: Ints, pairs: _Pairs, notes: dict[str, int]
) -> Demonstrations:
    """The pieces that have pairs, with their names, ends and what became of the others."""
    parent, ends = samples.trajectory[pairs.first], samples.trajectory[pairs.last]
    there, which = np.unique(parent, return_inverse=True)
    names, _ = piece_names([data.trajectory_names[d] for d in there], which)
    finish = np.flatnonzero(np.diff(samples.trajectory, append=-1) != 0)
    piece = np.searchsorted(pairs.first, pairs.sample, side="right") - 1
    counts = np.bincount(piece, minlength=len(pairs.first))
    full, alone = counts > 0, pairs.first == pairs.last
    source = data.source.noting(
        **notes,
        trajectories_cut=int((np.bincount(which) > 1).sum()),
        trajectories_without_a_sample_left_dropped=data.n_trajectories - len(there),
        trajectories_of_one_sample_dropped=int(alone.sum()),
        trajectories_that_never_left_their_cell_dropped=int((~full & ~alone).sum()),
    )
    if not full.any():
        told = ", ".join(f"{count} {what}" for what, count in source.notes.items())
        raise InputError("data", found="no trajectory left", wanted="one that moves from cell to cell", hint=told)
    return Demonstrations(
        states=pairs.states, actions=pairs.actions, offset=np.concatenate([[0], np.cumsum(counts[full])]),
        times=pairs.times, final_states=states[pairs.last[full]],
        truncated=(data.truncated[parent] | (pairs.last != finish[ends]))[full],
        names=data.names, units=data.units, time_unit=data.time_unit, source=source,
        trajectory_names=tuple(name for name, some in zip(names, full, strict=True) if some),
        coordinates=world.coordinates, groups=tuple(data.groups[p] for p in parent[full]) if data.groups else (),
    )  # fmt: skip
