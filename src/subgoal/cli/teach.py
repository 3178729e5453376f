"""``subgoal teach``: a local page on which goals are taught by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def teach(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder in which projects are saved, made if it is not there.")
    ] = Path("out/teach"),
    host: Annotated[
        str, typer.Option(help="Address to listen on; with any but the default, other machines can open the page too.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0 is any that is free.")] = 0,
    open: Annotated[bool, typer.Option("--open/--no-open", help="Open the page in the browser.")] = True,
) -> None:
    """Draw a path on a page, see its subgoals while you draw, and watch a simulated quadrotor fly them.

    The address that is printed holds a secret token, new at each start: whoever has it can use the page. Ctrl-C ends.

    Example:

      subgoal teach --out taught/
    """
    from subgoal.teach.server import serve

    serve(out, host=host, port=port, open=open)
