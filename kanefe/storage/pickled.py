"""Objects that are pickled, and copied, by the fields they were made with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any


class PickledByFields:
    """A frozen dataclass whose pickle holds its fields alone, and that is made again of them.

    What it has computed from them and kept is left out: factors, tables and compiled code belong to the process. Arrays
    that its constructor makes read-only are so again.
    """

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        kind: Any = type(self)
        return _made, (kind, {f.name: getattr(self, f.name) for f in fields(kind) if f.init})


def _made(kind: Callable[..., Any], given: dict[str, Any]) -> Any:
    return kind(**given)
