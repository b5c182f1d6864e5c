"""Cases by their names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from kanefe.errors import ModelError

SomeCase = TypeVar("SomeCase")


def select(
    kind: str, cases: Sequence[SomeCase], names: Sequence[str], name_of: Callable[[SomeCase], str]
) -> list[SomeCase]:
    """Return the cases with these names, in their own order, or all if there are none given.

    Parameters
    ----------
    kind : str
        Of the cases, in messages.
    cases : sequence
    names : sequence of str
        Upper and lower case are the same.
    name_of : callable
        Case -> the name by which it is asked for; parts of a case share it.

    Raises
    ------
    ModelError
        If a name is unknown; the message lists those there are.
    """
    known = {name_of(case).casefold(): name_of(case) for case in cases}
    unknown = [name for name in names if name.casefold() not in known]
    if unknown:
        there = ", ".join(known.values())
        raise ModelError(f"there is no {kind} case {', '.join(map(repr, unknown))}. Remedy: one or more of {there}")
    wanted = {name.casefold() for name in names or known}
    return [case for case in cases if name_of(case).casefold() in wanted]
