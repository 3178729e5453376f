"""Text and data made harmless for a page: nothing that comes from a file is ever markup or script."""

from __future__ import annotations

import html
import json
import math
from typing import Any

import numpy as np


def text(value: Any) -> str:
    """Anything as text inside an element or a quoted attribute."""
    return html.escape(str(value), quote=True)


def label(value: Any) -> str:
    """Anything as text inside a figure, which reads a few tags and entities."""
    return html.escape(str(value), quote=False)


def script_json(value: Any) -> str:
    """JSON that may stand inside a script element: no "<", ">" or "&", no NaN."""
    packed = json.dumps(_finite(value), separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return packed.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _finite(value: Any) -> Any:
    """Arrays and numbers as plain lists and numbers, what is not finite as null."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        return int(value) if value.is_integer() and abs(value) < 1e15 else value
    return value
