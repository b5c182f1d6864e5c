"""Selection of cases by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from kanefe.errors import ModelError

SomeCase = TypeVar("SomeCase")


def select(
    kind: str, cases: Sequence[SomeCase], names: Sequence[str], name_of: Callable[[SomeCase], str]
) -> list[SomeCase]:
    """Return the cases with the given names, in the order of `cases`; all of them if no name is given.

    Parameters
    ----------
    kind : str
        Kind of case, for messages.
    cases : sequence
    names : sequence of str
        Not case-sensitive.
    name_of : callable
        Case -> its name, which the parts of a case share.

    Raises
    ------
    ModelError
        If a name is unknown; the message lists the known ones.
    """
    known = {name_of(case).casefold(): name_of(case) for case in cases}
    unknown = ", ".join(repr(name) for name in names if name.casefold() not in known)
    if unknown:
        raise ModelError(f"there is no {kind} case {unknown}. Remedy: one or more of {', '.join(known.values())}")
    wanted = {name.casefold() for name in names or known}
    return [case for case in cases if name_of(case).casefold() in wanted]
