"""What a file is: by its first bytes where they tell, else by the end of its name."""

from __future__ import annotations

import re
from pathlib import Path

from subgoal.demonstrations.readers.files import head
from subgoal.demonstrations.readers.npz import array_names
from subgoal.runtime.errors import ReadError

POSE = re.compile(rb"\s*(?:[-+\d.eE]{1,40}[ \t]+){7}[-+\d.eE]{1,40}[ \t]*\r?\n?")
TEXT_ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".tab")


def find_format(path: Path) -> str:
    """The format of a file, a key of ``readers.RECORDINGS`` or ``readers.PAIRS``.

    Raises ``ReadError`` listing the formats if nothing tells.
    """
    start = head(path)
    if start.startswith(b"PK"):
        names = array_names(path)
        return "pairs" if "states" in names and "positions" not in names else "npz"
    if start.startswith(b"MATLAB 5.0 MAT-file"):
        return "lasa"
    ending = path.suffix.lower()
    if ending in TEXT_ENDINGS:
        return _text_format(start)
    endings = {".npz": "npz", ".mat": "lasa"}
    if ending in endings:
        return endings[ending]
    raise ReadError(
        str(path), found=f"the ending {ending!r}", wanted="a known kind of file (csv, tsv, txt, npz, mat)",
        hint="format='csv' or another name of a format",
    )  # fmt: skip


def _text_format(start: bytes) -> str:
    if b"TRACK.R" in start or b"Total number of trajectories in file" in start:
        return "edinburgh"
    lines = [line for line in start.splitlines()[:50] if line.strip() and not line.startswith(b"#")]
    if lines and POSE.fullmatch(lines[0]):
        return "tum"
    return "csv"
