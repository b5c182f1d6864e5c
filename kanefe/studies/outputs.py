"""Outputs of a run: a function of the user, a reducer, or several of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from kanefe.errors import ModelError
from kanefe.result import Result


@dataclass(frozen=True)
class Together:
    """Several functions of a result, whose outputs are one dict."""

    parts: tuple[Callable[[Result], Any], ...]

    def __call__(self, result: Result) -> dict[str, Any]:
        """Return all outputs; raise a ModelError if two have the same name."""
        found: dict[str, Any] = {}
        for part in self.parts:
            own = part(result)
            twice = set(own) & set(found)
            if twice:
                raise ModelError(f"two outputs are called {', '.join(sorted(twice))}. Remedy: name= of one of them")
            found |= own
        return found


def outputs_of(outputs: Any) -> Callable[[Result], Any]:
    """Return the argument `outputs` of a study as one function.

    Raises
    ------
    ModelError
        If it is no function, and no sequence of functions.
    """
    if callable(outputs):
        return outputs  # type: ignore[no-any-return]
    if isinstance(outputs, Sequence) and outputs and all(callable(part) for part in outputs):
        return Together(tuple(outputs))
    raise ModelError(
        "outputs must be a function of a Result that returns a dict of numbers, a reducer, or a sequence of them, not "
        f"{outputs!r}"
    )
