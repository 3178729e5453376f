"""The Python of docs/is-it-right.md runs as printed and says what the page says."""

from __future__ import annotations

from tests.docs.test_docs import ROOT, python_of


def test_the_page_runs_as_printed(capsys) -> None:
    names: dict = {}
    exec(compile(python_of(ROOT / "docs" / "is-it-right.md"), "is-it-right.md", "exec"), names)
    told = capsys.readouterr().out
    assert names["report"].passed
    assert "mine: 12 of 12 checks passed" in told
    assert "long run, peaked table" in told
    assert "densities are complete" in told
    assert "8 of 8 checks passed" in told
