"""The command ``subgoal``: learn, inspect, compare, report, waypoints, fly, follow, teach, demo."""

from __future__ import annotations

import sys
from collections.abc import Callable

import typer

from subgoal.cli.compare import compare
from subgoal.cli.demo import demo
from subgoal.cli.fly import fly
from subgoal.cli.follow import follow
from subgoal.cli.inspect import inspect
from subgoal.cli.learn import learn
from subgoal.cli.report import report
from subgoal.cli.teach import teach
from subgoal.cli.waypoints import waypoints
from subgoal.cli.wording import as_typed
from subgoal.runtime.errors import StoppedError, SubgoalError
from subgoal.runtime.version import VERSION

BAD_INPUT = 2
INTERRUPTED = 130

app = typer.Typer(
    name="subgoal",
    help="Find the goals behind recorded movement, which part serves which, and how sure that is.",
    epilog="Start with: subgoal inspect FILE, then subgoal learn FILE --out out/",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"subgoal {VERSION}")
        raise typer.Exit


@app.callback()
def common(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Show the version."),
) -> None:
    """Find the goals behind recorded movement, which part serves which, and how sure that is."""


for command in (learn, inspect, compare, report, waypoints, fly, follow, teach, demo):
    app.command(no_args_is_help=command not in (demo, teach))(command)


def main() -> None:
    """Run the command; a clear message and exit code 2 for bad input, 130 when stopped before there was a result."""
    try:
        app()
    except (StoppedError, KeyboardInterrupt) as problem:
        print(f"subgoal: {problem or 'stopped'}", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except (SubgoalError, OSError) as problem:
        commands: dict[str, Callable[..., None]] = {
            "inspect": inspect, "compare": compare, "follow": follow, "waypoints": waypoints, "fly": fly,
        }  # fmt: skip
        command = commands.get(next(iter(sys.argv[1:]), ""), learn)
        print(f"subgoal: {as_typed(str(problem), command, learn)}", file=sys.stderr)
        sys.exit(BAD_INPUT)


if __name__ == "__main__":
    main()
