"""A run that is killed: ``python -m tests.robustness.resume_child CHECKPOINT OUT HOW SWEEPS``.

HOW is "run" (start anew), "resume", or "kill:K:WHERE": the process kills itself with SIGKILL during its K-th write of
a checkpoint, WHERE being "half" (in the middle of the temporary file), "first" (before the first rename) or "second"
(after the old file was set aside, before the new one is in place).
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.posterior import checkpoint, rounds
from tests.posterior.worlds import quiet_sample, table

RUN = {"chains": 2, "warmup": 20, "thin": 3, "seed": 5}


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def kill_at(write: int, where: str) -> None:
    """Have the ``write``-th write of a checkpoint end the process."""
    usual_replace, usual_savez = Path.replace, np.savez
    state = {"writes": 0, "renames": 0}

    def savez(stream: Any, **members: Any) -> None:
        state["writes"], state["renames"] = state["writes"] + 1, 0
        usual_savez(stream, **members)
        if state["writes"] == write and where == "half":
            stream.flush()
            stream.truncate(stream.tell() // 2)
            die()

    def replace(self: Path, target: Path) -> Path:
        state["renames"] += 1
        last = not str(target).endswith(".previous")
        if state["writes"] == write and (where == "second" if last else where == "first"):
            die()
        return usual_replace(self, target)

    np.savez, Path.replace = savez, replace  # type: ignore[assignment]


def main(path: str, out: str, how: str, draws: str) -> None:
    checkpoint.EVERY, checkpoint.LARGEST_COST = 0.0, 1e9
    rounds.ROUND_SECONDS["threading"] = 0.01
    if how.startswith("kill:"):
        _, write, where = how.split(":")
        kill_at(int(write), where)
    if how == "resume" and not any(Path(path).parent.glob(Path(path).name + "*")):
        how = "run"
    print("go", flush=True)
    posterior = quiet_sample(table(), draws=int(draws), checkpoint=path, resume=how == "resume", **RUN)
    np.savez(out, assignments=posterior.assignments, joint=posterior.log_joint, best=posterior.best_assignment,
             shares=posterior.shares.toarray(), **posterior.traces)  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])
