"""From settings to the one sampler that draws all that is to be learned; and settings in words."""

from __future__ import annotations

import numpy as np

from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.noise import NoiseSpec
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.learning import Learning, Noise
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Sampler
from subgoal.runtime.errors import InputError
from subgoal.storage.archive import digest_arrays

MODELS = {
    "persistent": "subgoal.models.Persistent()",
    "stickyhmm": "subgoal.models.StickyHMM()",
    "grouped": "subgoal.models.Grouped(demonstrations.group)",
}
"""How a model is made, by its name in lower case without underscores."""


def composed(
    likelihood: LogLikelihood, sampler: Sampler, model: Sampler | None, concentration: float | Gamma,
    confidence: NoiseSpec | None,
) -> tuple[Sampler, Noise | None]:  # fmt: skip
    """The sampler that draws everything that is to be learned, and the noise that it learns.

    A model whose ``refuse(offset)`` raises for the trajectories of the table is not run.
    """
    for what, each in (("sampler", sampler), ("model", model)):
        if each is not None:
            name_of(each, what)
            getattr(each, "refuse", lambda _: None)(likelihood.offset)
    if model is not None and sampler is not collapsed_blocks:
        raise InputError("sampler", found=name_of(sampler), wanted="none beside a model, which has its own")
    if confidence is not None and (isinstance(confidence, type) or not hasattr(confidence, "of")):
        raise InputError("confidence", found=repr(confidence), wanted="OneConfidence(), OwnConfidence(), NoiseLevels()",
                         hint="a fixed number is given to the likelihood")  # fmt: skip
    if confidence is not None and isinstance(likelihood.source, FixedTable):
        raise InputError("confidence", found="a plain table, of which only these numbers are known",
                         wanted="a likelihood that knows its noise, for it to be learned",
                         hint="confidence=None, or a likelihood of subgoal.action_comparison")  # fmt: skip
    base = sampler if model is None else model
    learned = concentration if isinstance(concentration, Gamma) else None
    if learned is None and confidence is None:
        return base, None
    noise = None if confidence is None else confidence.of(likelihood)
    learning: Sampler = Learning(base, learned, noise)
    return learning, noise


def told(setting: object) -> float | str:
    """A setting for the record: a number as it is; a prior or a law in words."""
    return float(setting) if isinstance(setting, (int, float)) else words(setting)


def words(setting: object) -> str:
    """A setting in words that tell it from every other."""
    if isinstance(setting, np.ndarray):
        return f"{setting.size} numbers, checksum {digest_arrays(setting)[:12]}"
    if isinstance(setting, Levels):
        return f"levels, checksum {digest_arrays(setting.confidences, setting.shares)[:12]}"
    return repr(setting)


def name_of(sampler: object, what: str = "sampler") -> str:
    """The name of a sampler; raises ``InputError`` for what cannot be called, for a class and for a mere name."""
    if isinstance(sampler, type):
        made = MODELS.get(sampler.__name__.lower(), f"{sampler.__name__}(...)")
        raise InputError(
            what, found=f"the class {sampler.__name__}", wanted="one of its kind, with brackets", hint=made
        )
    if not callable(sampler):
        called = str(sampler).lower().replace("_", "")
        usual = "subgoal.samplers.collapsed_blocks" if what == "sampler" else "subgoal.models.Persistent()"
        raise InputError(what, found=repr(sampler), wanted=f"a function, such as {usual}", hint=MODELS.get(called))
    return str(getattr(sampler, "__name__", type(sampler).__name__))
