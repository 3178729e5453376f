"""A flight as a moving picture: GIF, a page, or a film."""

from __future__ import annotations

import base64
import contextlib
import io
import secrets
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.flight.record import Flight
from subgoal.flight.waypoints import Waypoints
from subgoal.plots.flight import FLOWN, SHOWN, draw_paths, draw_waypoints, span_of, vehicle_lines
from subgoal.plots.style import FAINT, INK, SMALL, new_figure, panel, with_unit
from subgoal.runtime.errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image

RATE = 20
"""Pictures a second."""
MOST_FRAMES = 160
HELD = 1.0
"""Seconds that the last picture stands."""
COLOURS = 64
PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Flight</title>
<body style="margin:2em;font-family:sans-serif"><img alt="Flight" src="data:image/gif;base64,{}"></body></html>
"""


def animate_flight(
    flight: Flight, waypoints: Waypoints, demonstrations: Demonstrations, path: str | Path, *, y_down: bool = False
) -> Path:  # fmt: skip
    """Write the flight as a moving picture, by the suffix of ``path``: ``.gif``, ``.html`` or ``.mp4``.

    Long flights run faster than they were; the picture says by how much. Three dimensions are seen from above.
    ``y_down`` turns the second coordinate over, as in images. Raises ``InputError`` for another suffix, and for
    ``.mp4`` where the program ffmpeg is not found.
    """
    path = Path(path)
    if path.suffix not in (".gif", ".html", ".mp4"):
        raise InputError("path", found=repr(path.name), wanted="a name that ends in .gif, .html or .mp4")
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise InputError("path", found="no program ffmpeg", wanted="it, for .mp4", hint="a name that ends in .gif")
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        frames = _frames(flight, waypoints, demonstrations, y_down)
        if path.suffix == ".mp4":
            _film(frames, aside)
        else:
            picture = _gif(frames)
            page = PAGE.format(base64.b64encode(picture).decode()) if path.suffix == ".html" else None
            aside.write_bytes(picture if page is None else page.encode())
        aside.replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            aside.unlink()
    return path


def _frames(flight: Flight, waypoints: Waypoints, demonstrations: Demonstrations, y_down: bool) -> Iterator[Image]:
    """Pictures at even times; what does not move is drawn once."""
    from matplotlib.collections import LineCollection
    from PIL import Image as Images

    count = int(min(MOST_FRAMES, max(2, flight.duration * RATE)))
    rows = np.linspace(0, len(flight.times) - 1, count).astype(int)
    figure = new_figure(5.6, 5.4, "", None, [_pace(flight, count)], left=0.14)
    own, columns = flight.waypoints, flight.placement.columns
    names = (with_unit(own.dimensions[k], own.units) for k in columns[:2])
    axes = panel(figure, (0.14, 0.14, 0.82, 0.78), "", *names)
    draw_paths(axes, flight, demonstrations, y_down=y_down)
    trace = axes.lines[0]
    draw_waypoints(axes, waypoints, flight)
    discs = list(axes.texts)
    for x, name, shade in ((0.14, "demonstrated", SHOWN), (0.38, "flown", FLOWN)):
        figure.text(x, 0.955, f"━ {name}", color=shade, fontsize=SMALL, weight="bold")
    craft = LineCollection([], colors=INK, linewidths=2.6, zorder=7, capstyle="round")
    axes.add_collection(craft, autolim=False)
    clock = axes.text(0.98, 1.03, "", transform=axes.transAxes, ha="right", fontsize=SMALL, color=FAINT)
    moving: list[Any] = [trace, *discs, craft, clock]
    for artist in moving:
        artist.set_animated(True)
    canvas: Any = figure.canvas
    canvas.draw()
    still, span = canvas.copy_from_bbox(figure.bbox), 2 * span_of(axes)
    for row in rows.tolist():
        trace.set_data(*flight.shown[: row + 1, :2].T)
        craft.set_segments(vehicle_lines(flight, [row], span))
        clock.set_text(f"{flight.times[row]:.1f} s")
        canvas.restore_region(still)
        for artist in moving:
            axes.draw_artist(artist)
        yield Images.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


def _pace(flight: Flight, count: int) -> str:
    faster = flight.duration * RATE / count
    return f"{flight.vehicle}, simulated" + (f"; {faster:.1f} times as fast as flown" if faster > 1.05 else "")


def _gif(frames: Iterator[Image]) -> bytes:
    from PIL.Image import Dither, Quantize

    first, *others = frames
    palette = first.quantize(COLOURS, method=Quantize.MEDIANCUT)
    drawn = [each.quantize(palette=palette, dither=Dither.NONE) for each in (first, *others)]
    wait = round(1000 / RATE)
    lasts = [wait] * (len(drawn) - 1) + [round(1000 * HELD)]
    stream = io.BytesIO()
    drawn[0].save(stream, "GIF", save_all=True, append_images=drawn[1:], duration=lasts, loop=0, optimize=False)
    return stream.getvalue()


def _film(frames: Iterator[Image], path: Path) -> None:
    first = next(frames)
    width, height = (size - size % 2 for size in first.size)
    pipe = subprocess.Popen(
        ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r",
         str(RATE), "-i", "-", "-pix_fmt", "yuv420p", str(path)], stdin=subprocess.PIPE,
    )  # fmt: skip
    with contextlib.closing(pipe.stdin) as stream:  # type: ignore[type-var]
        for frame in (first, *frames):
            stream.write(frame.crop((0, 0, width, height)).tobytes())  # type: ignore[union-attr]
    if pipe.wait() != 0:
        raise InputError("path", found=f"ffmpeg ended with {pipe.returncode}", wanted="a film",
                         hint="a name that ends in .gif")  # fmt: skip
