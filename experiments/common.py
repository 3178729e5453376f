"""The one frame of every experiment: ``python -m experiments.NAME --out DIR [--data PATH] [--seed K] [--quick]``.

An experiment is a function ``experiment(options) -> (headline, figure)``. ``run`` parses the command line, finds
the data, measures the time, writes ``NAME.png`` and ``NAME.json`` into ``DIR`` (to a temporary name, then renamed)
and prints the headline numbers as one JSON object on the last line. An experiment whose recordings are not at
hand prints ``{"skipped": reason}`` instead and ends with exit status 0.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from cycler import cycler
from matplotlib.figure import Figure

INK = "#222222"
GREY = "#9a9a9a"
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#000000")
"""Okabe and Ito's colours, told apart with every common colour blindness and in print (yellow left out)."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": INK,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": cycler(color=PALETTE),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10.5,
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
    "figure.titlesize": 13,
    "figure.titleweight": "bold",
    "font.size": 9.5,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "savefig.dpi": 150,
    "savefig.facecolor": "white",
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}
DATA_VARIABLE = "SUBGOAL_DATA"


@dataclass(frozen=True)
class Options:
    """What one run was asked for.

    Attributes
    ----------
    out:
        Folder of the results; it exists.
    seed:
        Root of every random stream of the run.
    quick:
        The same kinds of output from less work.
    data:
        Folder of the data set that the experiment needs; None when it needs none.
    """

    out: Path
    seed: int = 0
    quick: bool = False
    data: Path | None = None

    @property
    def recordings(self) -> Path:
        """``data``, for an experiment that declared its needs: ``run`` has made sure of it."""
        if self.data is None:
            raise LookupError("this experiment declared no data set: give needs= to run()")
        return self.data


Headline = dict[str, Any]
Experiment = Callable[[Options], tuple[Headline, Figure]]


def run(name: str, experiment: Experiment, needs: str | None = None, argv: Sequence[str] | None = None) -> Headline:
    """Run one experiment from the command line and return what its last line says.

    Parameters
    ----------
    name:
        Stem of the two files, ``fig_2_1``.
    experiment:
        ``experiment(options) -> (headline, figure)``; called inside the shared figure style.
    needs:
        Name of the data set (a folder), or None.
    argv:
        Arguments in place of those of the process.
    """
    wanted = parser(name).parse_args(argv)
    if wanted.data is not None and not wanted.data.is_dir():
        parser(name).error(f"--data {wanted.data}: no such folder")
    data, reason = find_data(needs, wanted.data)
    if reason:
        return announce({"skipped": reason})
    wanted.out.mkdir(parents=True, exist_ok=True)
    options = Options(out=wanted.out, seed=wanted.seed, quick=wanted.quick, data=data)
    start = time.perf_counter()
    with figure_style():
        headline, figure = experiment(options)
        picture = io.BytesIO()
        figure.savefig(picture, format="png", metadata={"Software": None})
    seconds = round(time.perf_counter() - start, 3)
    record = {"experiment": name, "seed": options.seed, "quick": options.quick, **headline, "seconds": seconds}
    save(options.out / f"{name}.png", picture.getvalue())
    save(options.out / f"{name}.json", (json.dumps(plain(record), indent=1, allow_nan=False) + "\n").encode())
    return announce(record)


def parser(name: str) -> argparse.ArgumentParser:
    """The command line that all experiments share."""
    made = argparse.ArgumentParser(prog=f"python -m experiments.{name}")
    made.add_argument("--out", type=Path, required=True, help="folder for the picture and the numbers")
    made.add_argument("--data", type=Path, help=f"folder of the data sets (default: ${DATA_VARIABLE})")
    made.add_argument("--seed", type=_seed, default=0, help="whole number of at least 0 (default: 0)")
    made.add_argument("--quick", action="store_true", help="the same outputs from less work")
    return made


def _seed(text: str) -> int:
    number = int(text)
    if number < 0:
        raise argparse.ArgumentTypeError("wanted a whole number of at least 0")
    return number


def find_data(needs: str | None, given: Path | None) -> tuple[Path | None, str | None]:
    """Folder of the data set and no reason, or no folder and the reason why not.

    ``given``, else the environment variable ``SUBGOAL_DATA``, names the folder that holds the data set, or the
    data set's own folder.
    """
    if needs is None:
        return None, None
    named = os.environ.get(DATA_VARIABLE)
    root = given or (Path(named) if named else None)
    if root is None:
        return None, f"needs the data set {needs}: give --data PATH or set {DATA_VARIABLE}"
    if (root / needs).is_dir():
        return root / needs, None
    if root.resolve().name == needs and root.is_dir():
        return root, None
    return None, f"no data set {needs} in {root}"


@contextmanager
def figure_style() -> Iterator[None]:
    """The shared look, in force inside the block and undone after it."""
    with matplotlib.rc_context(STYLE):
        yield


def sheet(width: float = 9.0, height: float = 6.0) -> Figure:
    """An empty figure of ``width`` by ``height`` inches that needs no display."""
    return Figure(figsize=(width, height))


def save(path: Path, content: bytes) -> None:
    """Write ``content`` to a temporary name beside ``path``, then rename: a torn file is never seen."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(content)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def plain(value: Any) -> Any:
    """``value`` in the types that JSON knows; a number that is not finite becomes null."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def announce(record: Headline) -> Headline:
    """Print ``record`` as one line of JSON, and return what was printed."""
    shown: Headline = plain(record)
    print(json.dumps(shown, allow_nan=False), flush=True)
    return shown
