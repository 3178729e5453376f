"""What a file is: by its first bytes where they tell, else by the end of its name."""

from __future__ import annotations

import re
from pathlib import Path

from subgoal.demonstrations.readers.files import head
from subgoal.demonstrations.readers.hdf5 import HDF5_MAGIC, is_pandas_table
from subgoal.demonstrations.readers.npz import array_names
from subgoal.runtime.errors import ReadError

POSE = re.compile(rb"\s*(?:[-+\d.eE]{1,40}[ \t]+){7}[-+\d.eE]{1,40}[ \t]*")
EUROC = re.compile(rb"\s*#\s*timestamp[^\n]{0,40},\s*p_\w{0,40}_x\b")
BAG_MAGIC = (b"#ROSBAG V", b"\x89MCAP0\r\n", b"SQLite format 3\0")
TEXT_ENDINGS = (".csv", ".tsv", ".txt", ".dat", ".tab")
ENDINGS = {".npz": "npz", ".mat": "lasa", ".parquet": "parquet", ".pq": "parquet",
           ".bag": "rosbag", ".mcap": "rosbag", ".db3": "rosbag"}  # fmt: skip


def find_format(path: Path) -> str:
    """The format of a file or of the folder of a bag, a key of ``readers.RECORDINGS`` or ``readers.PAIRS``.

    Raises ``ReadError`` if nothing tells.
    """
    if path.is_dir():
        return "rosbag"
    start, ending = head(path), path.suffix.lower()
    if start.startswith(b"PK"):
        names = array_names(path)
        return "pairs" if "states" in names and "positions" not in names else "npz"
    if start.startswith(HDF5_MAGIC):
        return "deeplabcut" if is_pandas_table(path) else "sleap"
    if start.startswith(b"PAR1"):
        return "parquet"
    if start.startswith(b"MATLAB 5.0 MAT-file"):
        return "lasa"
    if start.startswith(BAG_MAGIC):
        return "rosbag"
    if ending in TEXT_ENDINGS:
        return _text_format(start)
    if ending in ENDINGS:
        return ENDINGS[ending]
    raise ReadError(
        str(path), found=f"the ending {ending!r}", wanted="csv, tsv, txt, parquet, npz, mat, HDF5, bag, mcap or db3",
        hint="format='csv' or another name of a format; unpack the file first if it is packed",
    )  # fmt: skip


def _text_format(start: bytes) -> str:
    if b"TRACK.R" in start or b"Total number of trajectories in file" in start:
        return "edinburgh"
    if EUROC.match(start):
        return "euroc"
    lines = [line for line in start.splitlines()[:50] if line.strip() and not line.startswith(b"#")]
    first = lines[0] if lines else b""
    if POSE.fullmatch(first):
        return "tum"
    if first.startswith(b"scorer,"):
        return "deeplabcut"
    return "labyrinth" if first.startswith(b"session,bout,step,node,") else "csv"
