"""``python -m benchmarks``: one table; exit code 1 if a target is missed."""

from __future__ import annotations

import sys

from benchmarks import command, gp_planning, large_worlds, planning, sampling, streaming, table, temporal


def main() -> int:
    """Run everything, a line at a time."""
    rows = []
    for case in (
        command.start,
        table.whole_table,
        sampling.sweeps,
        temporal.sweeps,
        streaming.points,
        table.tiled_pass,
        planning.subgoals,
        planning.table_4_1,
        large_worlds.envelopes,
        gp_planning.drives,
        command.learn,
    ):
        answer = case()
        for row in answer if isinstance(answer, list) else [answer]:
            print(row, flush=True)
            rows.append(row)
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
