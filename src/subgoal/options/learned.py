"""Options of whichever world they were learned in: one verb to make them, one to run them."""

from __future__ import annotations

from typing import Any, overload

from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.protocol import Dynamics
from subgoal.dynamics.world import ContinuousWorld
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.mdp.tabular import TabularMDP
from subgoal.options import continuous, execution, tabular
from subgoal.options.continuous import ContinuousOption
from subgoal.options.tabular import Option
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError


def option(posterior: Posterior, candidate: int, *, begin: str = "anywhere") -> Any:
    """The option of one candidate of a posterior: an ``Option`` of a discrete world, a ``ContinuousOption`` of another.

    Parameters
    ----------
    candidate:
        Its index, such as ``goal.candidate`` of a merged subgoal.
    begin:
        "anywhere": wherever the goal can be reached from. "served": only in states, or closer than ε to states, with
        an observation that the best draw assigns to the candidate, as in (6.4).

    Its policy is optimal for the candidate's reward (6.5), and it ends at the candidate (6.6). Raises ``InputError``
    for a candidate that does not exist or a posterior whose actions were not planned.
    """
    if posterior.likelihood is None and posterior.settings.likelihood == GaussianProcessValues.kind:
        raise InputError("posterior", found="no world: it was loaded without", wanted="one with its continuous world",
                         hint="subgoal.load(path, mdp=ContinuousWorld(dynamics, low, high, step))")  # fmt: skip
    source = None if posterior.likelihood is None else posterior.likelihood.source
    make = continuous.option if isinstance(source, GaussianProcessValues) else tabular.option
    return make(posterior, candidate, begin=begin)


@overload
def execute(
    option: Option, world: TabularMDP, *, start: Any, steps: int, hold: bool = ..., trajectories: int = ...,
    seed: int = ...,
) -> Demonstrations: ...  # fmt: skip


@overload
def execute(
    option: ContinuousOption, world: ContinuousWorld | Dynamics, *, start: Any, duration: float, hold: bool = ...,
    every: float | None = ..., disturbance: Any = ..., seed: int = ...,
) -> Demonstrations: ...  # fmt: skip


def execute(option: Any, world: Any, **how: Any) -> Demonstrations:
    """Run an option in its world until it ends, or with ``hold`` past its end; what was done, as demonstrations.

    In a discrete world: ``start``, ``steps``, ``hold``, ``trajectories`` and ``seed``, see ``tabular.execute``. In a
    continuous one: ``start``, ``duration``, ``hold``, ``every``, ``disturbance`` and ``seed``, see
    ``execution.execute``. ``truncated`` where the option did not end.
    """
    if isinstance(option, Option):
        return tabular.execute(option, world, **how)
    if isinstance(option, ContinuousOption):
        return execution.execute(option, world, **how)
    raise InputError("option", found=type(option).__name__, wanted="an Option or a ContinuousOption")
