"""Numbers and tables as text of C."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ESCAPES = {'"': '\\"', "\\": "\\\\", "\n": "\\n"}


def define(name: str, value: object) -> str:
    """Return the line that defines a constant, a whole number or a text."""
    return f"#define {name} {text(value) if isinstance(value, str) else value}"


def text(value: str) -> str:
    """Return a text in quotes."""
    return '"' + "".join(ESCAPES.get(c, c) for c in value) + '"'


def integers(name: str, values: Sequence[int] | Sequence[Sequence[int]], width: int = 0) -> str:
    """Return a table of whole numbers, with rows of `width` numbers if given. An empty table gets one zero."""
    array = np.array(values, dtype=np.int64).reshape(-1, width) if width else np.array(values, dtype=np.int64)
    if not array.size:
        array = np.zeros((1, width) if width else 1, dtype=np.int64)
    shape = "".join(f"[{n}]" for n in array.shape)
    rows = ["{" + ", ".join(map(str, row)) + "}" for row in array.tolist()] if width else list(map(str, array.tolist()))
    return f"static const int64_t {name}{shape} = {{{', '.join(rows)}}};"


def numbers(name: str, values: Sequence[float] | np.ndarray) -> str:
    """Return a table of numbers, exact to the last bit."""
    flat = np.asarray(values, dtype=float).ravel().tolist() or [0.0]
    return f"static const double {name}[{len(flat)}] = {{{', '.join(map(number, flat))}}};"


def number(value: float) -> str:
    """Return a number exactly; zero for one that is not finite."""
    return value.hex() if value == value and abs(value) != float("inf") else "0.0"
