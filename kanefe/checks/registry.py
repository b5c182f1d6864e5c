"""Which cases there are: those of kanefe, and those of installed plugins, found by their names."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from typing import Generic, TypeVar

from kanefe.errors import ModelError

SomeCase = TypeVar("SomeCase")


@dataclass(frozen=True)
class Registry(Generic[SomeCase]):
    """Cases of one kind.

    Attributes
    ----------
    kind : str
        In messages.
    group : str
        Of the entry points: a plugin names a module there that has ``CASES``, a tuple of cases.
    cls : type
        Of a case.
    name_of : callable
        Case -> the name by which it is asked for; parts of a case share it. Upper and lower case are the same.
    """

    kind: str
    group: str
    cls: type[SomeCase]
    name_of: Callable[[SomeCase], str]

    def of_plugins(self) -> Iterator[SomeCase]:
        """Yield the cases of installed plugins.

        Raises
        ------
        ModelError
            If the module of a plugin has none.
        """
        for entry in sorted(entry_points(group=self.group), key=lambda e: e.name):
            added = getattr(entry.load(), "CASES", None)
            if not isinstance(added, tuple) or not all(isinstance(case, self.cls) for case in added):
                raise ModelError(
                    f"the plugin {entry.value!r} of the group {self.group!r} has no tuple CASES of {self.kind} cases. "
                    "Remedy: update or remove the package it comes from"
                )
            yield from added

    def select(self, cases: Sequence[SomeCase], names: Sequence[str]) -> list[SomeCase]:
        """Return the cases with these names, in their own order, or all if there are none given.

        Raises
        ------
        ModelError
            If a name is unknown; the message lists those there are.
        """
        known = {self.name_of(case).casefold(): self.name_of(case) for case in cases}
        unknown = [name for name in names if name.casefold() not in known]
        if unknown:
            raise ModelError(
                f"there is no {self.kind} case {', '.join(map(repr, unknown))}. "
                f"Remedy: one or more of {', '.join(known.values())}"
            )
        wanted = {name.casefold() for name in names or known}
        return [case for case in cases if self.name_of(case).casefold() in wanted]
