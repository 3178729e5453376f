"""A slow and obvious account of how positions become cells and steps, with dictionaries only."""

from __future__ import annotations

import math

STEPS = {
    "N": (0, 1), "NE": (1, 1), "E": (1, 0), "SE": (1, -1), "S": (0, -1), "SW": (-1, -1), "W": (-1, 0), "NW": (-1, 1),
}  # fmt: skip


class Room:
    """Open cells, and what one step leads to."""

    def __init__(self, rows, *, moves=8, corners=True, y_down=False):
        self.open = {(x, y) for y, row in enumerate(rows) for x, free in enumerate(row) if free}
        names = [name for name in STEPS if moves == 8 or len(name) == 1]
        self.steps = {name: (STEPS[name][0], STEPS[name][1] * (-1 if y_down else 1)) for name in names}
        self.corners = corners

    def neighbours(self, cell):
        """{name: cell} in the order of the compass."""
        found = {}
        for name, (dx, dy) in self.steps.items():
            x, y = cell[0] + dx, cell[1] + dy
            squeezed = dx and dy and not self.corners and not {(x, cell[1]), (cell[0], y)} <= self.open
            if (x, y) in self.open and not squeezed:
                found[name] = (x, y)
        return found

    def way(self, first, last):
        """Cells of the shortest way that keeps to the line, or None."""
        left = {last: 0}
        queue = [last]
        for cell in queue:
            for there in self.open:
                if there not in left and cell in self.neighbours(there).values():
                    left[there] = left[cell] + 1
                    queue.append(there)
        if first not in left:
            return None
        way = [first]
        while way[-1] != last:
            nearer = [cell for cell in self.neighbours(way[-1]).values() if left.get(cell) == left[way[-1]] - 1]
            way.append(min(nearer, key=lambda cell: off_line(first, last, cell)))
        return way

    def action(self, cell, there):
        if cell == there:
            return "stay"
        return next(name for name, reached in self.neighbours(cell).items() if reached == there)


def off_line(first, last, cell):
    return abs((last[0] - first[0]) * (cell[1] - first[1]) - (last[1] - first[1]) * (cell[0] - first[0]))


def pieces_of(track, room, resolution, origin):
    """Lists of (cell, time, index); cut where a position is not free or there is no way."""
    pieces, current = [], None
    for index, (place, time) in enumerate(track):
        cell = tuple(math.floor((p - o) / resolution) for p, o in zip(place, origin, strict=True))
        if cell not in room.open:
            current = None
            continue
        if current is None or room.way(current[-1][0], cell) is None:
            current = []
            pieces.append(current)
        current.append((cell, time, index))
    return pieces


def pairs_of(piece, room, staying):
    """(cell, action, time) of a piece."""
    visits = []
    for cell, time, _ in piece:
        if visits and visits[-1][0] == cell:
            visits[-1][1].append(time)
        else:
            visits.append((cell, [time]))
    pairs = []
    for number, (cell, times) in enumerate(visits):
        stays = {"keep": times[:-1], "once": times[:1] if len(times) > 1 else [], "drop": []}[staying]
        pairs += [(cell, "stay", time) for time in stays]
        if number + 1 < len(visits):
            there, (later, *_) = visits[number + 1]
            way = room.way(cell, there)
            for k in range(len(way) - 1):
                time = times[-1] + k / (len(way) - 1) * (later - times[-1])
                if staying == "drop" and k == 0:
                    time = times[0]
                pairs.append((way[k], room.action(way[k], way[k + 1]), time))
    return pairs


def gridded(tracks, room, resolution, origin, staying):
    """[(name, pairs, last cell, whether the track went on)] of {name: [(place, time), ...]}."""
    made = []
    for name, track in tracks.items():
        pieces = pieces_of(track, room, resolution, origin)
        for number, piece in enumerate(pieces):
            pairs = pairs_of(piece, room, staying)
            if pairs:
                label = name if len(pieces) == 1 else f"{name}/{number}"
                made.append((label, pairs, piece[-1][0], piece[-1][2] != len(track) - 1))
    return made
