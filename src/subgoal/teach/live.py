"""Learning while the pen is down: a ``Stream`` is told each point once."""

from __future__ import annotations

from subgoal.runtime.errors import InputError
from subgoal.streaming import Stream
from subgoal.teach.drawing import Sheet
from subgoal.teach.learning import DRAWING, RATE, Answer, Tuning

RADIUS = 0.06
"""Metres between candidates: 3 % of a drawing that is 2 m large. Afterwards the net is that of the drawing itself."""
SWEEPS = 4
"""Of all chains, for each answer."""


class Live:
    """The stream of one drawing, for as long as points are only added to it; used by one thread at a time."""

    def __init__(self) -> None:
        self._lineage: int | None = None
        self._tuning = Tuning()

    def answer(self, sheet: Sheet, tuning: Tuning) -> Answer:
        """What is known of the sheet so far. Raises ``InputError`` while nothing has moved."""
        if sheet.lineage != self._lineage:
            self._begin(sheet, tuning)
        if tuning != self._tuning:
            self._tuning = tuning
            self._stream.retune(confidence=tuning.confidence, concentration=tuning.concentration)
        self._feed(sheet)
        self._stream.rejuvenate(SWEEPS)
        demos = self._stream.demonstrations()
        found = self._stream.subgoals()
        strokes = tuple(self._strokes[int(name[1:])] for name in demos.trajectory_names)
        return Answer(DRAWING, found, self._stream.segments(found), strokes, demos.n_observations, RADIUS)

    def _begin(self, sheet: Sheet, tuning: Tuning) -> None:
        self._stream = Stream(
            names=sheet.names, radius=RADIUS, confidence=tuning.confidence, concentration=tuning.concentration,
            rate=RATE, units=sheet.units, seed=0,
        )  # fmt: skip
        self._tuning, self._lineage = tuning, sheet.lineage
        self._at, self._fed = 0, 0
        self._strokes: list[int] = []

    def _feed(self, sheet: Sheet) -> None:
        """Tell the stream what it does not know yet; a stroke that it cannot take leaves it to be begun anew."""
        try:
            for k in range(self._at, len(sheet.strokes)):
                stroke = sheet.strokes[k]
                if stroke and not self._fed:
                    self._strokes.append(k)
                for time, y, z in stroke[self._fed :]:
                    self._stream.add(time, (y, z))
                    self._fed += 1
                if k < len(sheet.strokes) - 1 or not sheet.drawn:
                    self._stream.lift()
                    self._at, self._fed = k + 1, 0
        except InputError:
            self._lineage = None
            raise
