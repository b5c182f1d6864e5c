"""Objects that are pickled and copied by their fields."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any


class PickledByFields:
    """A frozen dataclass whose pickle holds only its fields, from which it is constructed again.

    Cached results such as factors, tables and compiled code belong to the process and are left out. Arrays that the
    constructor makes read-only are read-only again.
    """

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[Any, ...]]:
        kind: Any = type(self)
        return _made, (kind, {f.name: getattr(self, f.name) for f in fields(kind) if f.init})


def _made(kind: Callable[..., Any], given: dict[str, Any]) -> Any:
    return kind(**given)
