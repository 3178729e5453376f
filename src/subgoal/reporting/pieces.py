"""Pieces of the page that every section is made of."""

from __future__ import annotations

from subgoal.reporting.safe import text


def section(title: str, body: str) -> str:
    """A titled box."""
    return f"<section><h2>{text(title)}</h2>{body}</section>"


def details(title: str, body: str) -> str:
    """A box that opens when its title is clicked."""
    return f"<section><details><summary>{text(title)}</summary>{body}</details></section>"


def lead(sentence: str) -> str:
    """The sentence under a title, from plain text."""
    return f'<p class="sub">{text(sentence)}</p>'


def note(sentence: str) -> str:
    """A smaller sentence under a table."""
    return f'<p class="note">{text(sentence)}</p>'
