"""What a posterior was sampled with, read back from its settings, so that it can be sampled again."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

from subgoal import models, samplers
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import EXCHANGEABLE, Posterior
from subgoal.runtime.errors import InputError


@dataclass(frozen=True)
class AsSampled:
    """Arguments of ``sample``: the table, and what was learned or fixed beside it."""

    likelihood: LogLikelihood
    concentration: float | Gamma
    confidence: Any
    model: Sampler | None
    sampler: Sampler

    @property
    def arguments(self) -> dict[str, Any]:
        """All but the table."""
        return {
            "concentration": self.concentration, "confidence": self.confidence, "model": self.model,
            "sampler": self.sampler,
        }  # fmt: skip


def as_sampled(posterior: Posterior, model: Sampler | None = None) -> AsSampled:
    """The arguments behind a posterior, also a loaded one.

    ``model`` is a model or sampler of one's own, of which settings have only the name. Raises ``InputError`` where the
    likelihood is lost, and for such a model that was not given.
    """
    if posterior.likelihood is None:
        hint = "load(path, mdp=...) with the world of the posterior, or the posterior in memory"
        raise InputError("posterior", found="no likelihood", wanted="one that can be made again", hint=hint)
    used = posterior.settings
    exchangeable = used.model == EXCHANGEABLE
    own = model if model is not None else _read("model", used.model) if not exchangeable else None
    sampler = collapsed_blocks if not exchangeable else model or _sampler(used.sampler)
    law = used.confidence
    learned = isinstance(law, str) and law.split("(")[0] in models.__all__
    eta = used.concentration
    return AsSampled(
        posterior.likelihood, _read("concentration", eta) if isinstance(eta, str) else eta,
        _read("confidence", law) if learned else None, None if exchangeable else own, sampler,
    )  # fmt: skip


def _sampler(name: str) -> Sampler:
    if name not in samplers.__all__:
        raise _unknown("sampler", name)
    sampler: Sampler = getattr(samplers, name)
    return sampler


def _read(what: str, words: Any) -> Any:
    """A record of ``subgoal.models`` from its words, which are parsed and not run."""
    try:
        return _value(ast.parse(words, mode="eval").body)
    except (SyntaxError, KeyError, TypeError, RecursionError) as problem:
        raise _unknown(what, words) from problem


def _value(node: ast.AST) -> Any:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.Tuple(elts=parts):
            return tuple(_value(part) for part in parts)
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=value)):
            return -value  # type: ignore[operator]
        case ast.Call(func=ast.Name(id=name), args=[], keywords=fields) if name in models.__all__:
            return getattr(models, name)(**{str(field.arg): _value(field.value) for field in fields})
        case ast.Call(func=ast.Attribute(value=ast.Name(id="np")), args=[ast.Constant(value=value)], keywords=[]):
            return value
    raise KeyError(type(node).__name__)


def _unknown(what: str, words: str) -> InputError:
    wanted = "one of this library, or the one that was used as model="
    return InputError(f"the posterior's {what}", found=words[:80], wanted=wanted)
