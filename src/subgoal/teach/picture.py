"""An answer in the words of the page: plain numbers, ready for JSON."""

from __future__ import annotations

from typing import Any

from subgoal.answers.segments import OTHER
from subgoal.answers.subgoals import COUNTED_FROM, reaches
from subgoal.posterior.diagnostics import Status
from subgoal.teach.drawing import Sheet
from subgoal.teach.learning import FULL, Answer

HALF_WIDTH, HEIGHT = 2.0, 3.0
"""Of the empty plane, metres: y from −2 to 2, z from 0 to 3."""
MARGIN = 0.08
LEAST_CHANCE = 0.005


def picture(answer: Answer, number: int) -> dict[str, Any]:
    """Subgoals with their uncertainty, segments by stroke and time, and the posterior over how many there are."""
    found, status = answer.found, answer.status
    return {
        "type": "answer",
        "number": number,
        "stage": answer.stage,
        "subgoals": [
            {"y": float(goal.position[0]), "z": float(goal.position[1]), "share": goal.share, "low":
             goal.share_interval[0], "high": goal.share_interval[1], "inclusion": goal.inclusion,
             "radius": goal.radius + answer.radius, "counted": reaches(goal.share, COUNTED_FROM)}
            for goal in found
        ],
        "n": found.n_subgoals,
        "counts": {str(k): p for k, p in found.n_subgoals_distribution.items() if p >= LEAST_CHANCE},
        "segments": [
            {"stroke": answer.strokes[cut.trajectory], "begin": cut.begin, "end": cut.end,
             "subgoal": -1 if cut.subgoal == OTHER else cut.subgoal, "probability": cut.probability}
            for cut in answer.cut
        ],
        "pairs": answer.pairs,
        "converged": status is Status.CONVERGED,
        "status": "the latest draws" if status is None else status.value,
    }  # fmt: skip


def nothing(number: int, text: str = "") -> dict[str, Any]:
    """The answer to a drawing from which nothing can be learned; ``text`` says why."""
    return {"type": "answer", "number": number, "stage": FULL, "subgoals": [], "n": 0, "counts": {},
            "segments": [], "pairs": 0, "converged": False, "status": text}  # fmt: skip


def shown(sheet: Sheet) -> dict[str, Any]:
    """The drawing, and the part of the plane that holds it."""
    return {
        "type": "drawing",
        "strokes": [[list(point) for point in stroke] for stroke in sheet.strokes],
        "drawn": sheet.drawn,
        "names": list(sheet.names),
        "units": sheet.units,
        "view": view(sheet),
    }


def view(sheet: Sheet) -> list[float]:
    """Least and most y, least and most z: of the empty plane, or of a file that does not fit it or has other units."""
    points = [point for stroke in sheet.strokes for point in stroke]
    plane = [-HALF_WIDTH, HALF_WIDTH, 0.0, HEIGHT]
    if not points:
        return plane
    across, up = [point[1] for point in points], [point[2] for point in points]
    inside = plane[0] <= min(across) and max(across) <= plane[1] and plane[2] <= min(up) and max(up) <= plane[3]
    if inside and sheet.units in ("m", ""):
        return plane
    size = max((max(across) - min(across)) / (2 * HALF_WIDTH), (max(up) - min(up)) / HEIGHT) * (1 + 2 * MARGIN)
    size = size or max(abs(across[0]), abs(up[0]), 1.0)
    y, z = (min(across) + max(across)) / 2, (min(up) + max(up)) / 2
    return [y - size * HALF_WIDTH, y + size * HALF_WIDTH, z - size * HEIGHT / 2, z + size * HEIGHT / 2]
