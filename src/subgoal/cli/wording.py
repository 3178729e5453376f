"""Python's words in messages turned into those of the command line: ``clock='sort'`` into ``--clock sort``."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from shlex import quote
from typing import Any

SPELLED = {"thin": "--thin-radius"}
"""Arguments whose option has another name."""
WITHOUT_MODEL = ("model=None", "no --learn-all")
TWICE = r"(--[\w-]+)( [^\s(]+)? \(\1\)"
"""An option beside itself in brackets, where a message named both the argument and the option."""
VALUE = r"\[[^\]]*\]|'[^']*'|\"[^\"]*\"|\w+(?:\.\w+)*"


def as_typed(text: str, command: Callable[..., Any], other: Callable[..., Any] | None = None) -> str:
    """``text`` with the arguments that are options of ``command`` as they are typed.

    Options that only the command ``other`` has are told with its name.
    """
    own = set(inspect.signature(command).parameters)
    foreign = set(inspect.signature(other).parameters) - own if other is not None else set()
    text = text.replace(*WITHOUT_MODEL)

    def typed_option(found: re.Match[str]) -> str:
        name, value = found["name"], found["value"] or ""
        listed = re.sub(r"[\[\]'\"]", "", value).replace(", ", ",")
        listed = "" if listed == "True" else listed
        told = SPELLED.get(name, "--" + name.replace("_", "-"))
        place = f" of subgoal {other.__name__}" if other is not None and name in foreign else ""
        return (f"{told} {quote(listed)}" if listed else told) + place

    names = "|".join(sorted(own | foreign, key=len, reverse=True))
    text = re.sub(rf"(?<![^\s(])(?P<name>{names})=(?P<value>{VALUE})?", typed_option, text)
    return re.sub(TWICE, r"\1\2", text)
