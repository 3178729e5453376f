"""The Python of docs/is-it-right.md runs as printed, and its tables say what is measured."""

from __future__ import annotations

import pytest

from experiments import correctness, correctness_models, correctness_moves
from tests.docs.test_docs import ROOT, python_of

PAGE = ROOT / "docs" / "is-it-right.md"
ONE = (1.0,)
QUICK = [
    correctness_moves.of_lots, lambda: correctness_moves.of_the_others(ONE), correctness_moves.of_weights,
    correctness_models.of_persistent_paths, correctness_models.of_sticky_paths, correctness_models.of_tables_of_rows,
    correctness_models.of_whole_candidates, correctness_models.of_sites_of_groups, correctness_models.of_seats,
    correctness_models.of_tables_of_groups,
]  # fmt: skip


def cells(line: str) -> list[str]:
    r"""What stands between the bars of a row; ``\|`` is none."""
    return [cell.strip().replace("\0", "|") for cell in line.replace(r"\|", "\0").strip().strip("|").split("|")]


def table(head: str) -> list[list[str]]:
    """The rows of the page's table whose second head is this one."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith(f"| sampler | {head} |"))
    last = next(k for k in range(first, len(lines)) if not lines[k].startswith("|"))
    return [cells(line) for line in (lines[first], *lines[first + 2 : last])]


def told(rows: list[correctness_moves.Row]) -> set[tuple[str, ...]]:
    """Sampler, move and measure of rows of which none is more than rounding."""
    assert all(value <= 1e-12 for *_, value in rows)
    return {(f"`{sampler}`", move, measured) for sampler, move, measured, _ in rows}


def test_the_page_runs_as_printed(capsys) -> None:
    names: dict = {}
    exec(compile(python_of(PAGE), "is-it-right.md", "exec"), names)
    printed = capsys.readouterr().out
    assert names["report"].passed
    assert "mine: 12 of 12 checks passed" in printed
    assert "long run, peaked table" in printed
    assert "densities are complete" in printed
    assert "8 of 8 checks passed" in printed


def test_moves_that_are_quick_to_replay_are_right_and_on_the_page() -> None:
    _, *rows = table("move")
    assert all(float(row[3]) <= 1e-15 for row in rows)
    measured = told([row for of in QUICK for row in of()])
    assert len(measured) == 13
    assert measured <= {tuple(row[:3]) for row in rows}


@pytest.mark.t2
def test_all_moves_are_right_and_on_the_page() -> None:
    measured = told([*correctness_moves.exchangeable(ONE), *correctness_models.in_time_and_groups()])
    assert measured == {tuple(row[:3]) for row in table("move")[1:]}


@pytest.mark.parametrize(
    ("name", "eta"),
    [("peaked", 5.0), *(pytest.param(*case, marks=pytest.mark.t2) for case in (("generic", 0.05), ("peaked", 1.0)))],
)
def test_the_printed_forms_settle_where_the_page_says(name: str, eta: float) -> None:
    head, *rows = table("as printed")
    column = head.index(f"{name}, η = {eta:g}")
    on_page = {row[0]: row[column] for row in rows}
    found = {f"`{row['sampler']}`": f"{row['total_variation']:.3f}" for row in correctness.of_printed(name, eta)}
    assert found == on_page


def test_two_of_eighteen_settings_are_below_two_hundredths() -> None:
    head, *rows = table("as printed")
    values = {(row[0], what): float(value) for row in rows for what, value in zip(head[2:], row[2:], strict=True)}
    assert len(values) == 18
    small = {setting: value for setting, value in values.items() if value < correctness.VIOLATION}
    assert small == {
        ("`alg4_literal_fresh_draw`", "generic, η = 0.05"): 0.001, ("`alg4_literal_sum`", "peaked, η = 5"): 0.014,
    }  # fmt: skip
