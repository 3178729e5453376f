"""Figures on disk: PNG and SVG, the same bytes for the same figure, written aside and renamed."""

from __future__ import annotations

import contextlib
import secrets
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DPI = 130


def save_figure(figure: Figure, folder: str | Path, name: str) -> tuple[Path, Path]:
    """Write ``name``.png and ``name``.svg into ``folder`` (made if it is missing) and return where they are.

    A reader finds the old file or the new one, never half of one.
    """
    import matplotlib

    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    png, svg = place / f"{name}.png", place / f"{name}.svg"
    with matplotlib.rc_context({"svg.hashsalt": "subgoal", "svg.fonttype": "path"}):
        _write(figure, png, {"Software": "subgoal"})
        _write(figure, svg, {"Date": None, "Creator": "subgoal"})
    return png, svg


def _write(figure: Figure, path: Path, metadata: dict[str, str | None]) -> None:
    aside = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        figure.savefig(aside, format=path.suffix[1:], dpi=DPI, metadata=metadata)
        aside.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            aside.unlink()
