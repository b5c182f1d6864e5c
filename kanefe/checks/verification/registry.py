"""Which verification cases there are: those of kanefe, and those of installed plugins.

A plugin names a module in the entry-point group ``kanefe.verification``; the module has ``CASES``, a tuple of `Case`.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points

from kanefe.checks.verification import dumbbell, loops, rigid, rotations, rotors, simeon
from kanefe.checks.verification.case import Case
from kanefe.checks.verification.references import load_references
from kanefe.errors import ModelError

GROUP = "kanefe.verification"


def registered_cases() -> tuple[Case, ...]:
    """Return all cases (and parts of cases), sorted by id.

    Raises
    ------
    ModelError
        If the module of a plugin has no cases, or a case has no reference.
    """
    cases = [*rigid.CASES, *rotations.CASES, *dumbbell.CASES, *loops.CASES, *simeon.CASES, *rotors.CASES]
    for entry in sorted(entry_points(group=GROUP), key=lambda e: e.name):
        added = getattr(entry.load(), "CASES", None)
        if not isinstance(added, tuple) or not all(isinstance(case, Case) for case in added):
            raise ModelError(
                f"the plugin {entry.value!r} of the group {GROUP!r} has no tuple CASES of verification cases. "
                "Remedy: update or remove the package it comes from"
            )
        cases += added
    for case in cases:
        if case.id not in load_references():
            raise ModelError(
                f"the verification case {case.id!r} has no reference. Remedy: update or remove its package"
            )
    return tuple(sorted(cases, key=lambda case: case.id))


def select_cases(ids: Sequence[str]) -> tuple[Case, ...]:
    """Return the cases with these ids, or all if there are none given.

    Raises
    ------
    ModelError
        If an id is unknown; the message lists those there are.
    """
    cases = registered_cases()
    known = list(dict.fromkeys(case.id for case in cases))
    by_folded = {id.casefold(): id for id in known}
    unknown = [id for id in ids if id.casefold() not in by_folded]
    if unknown:
        raise ModelError(
            f"there is no verification case {', '.join(map(repr, unknown))}. Remedy: one or more of {', '.join(known)}"
        )
    wanted = {by_folded[id.casefold()] for id in ids} if ids else set(known)
    return tuple(case for case in cases if case.id in wanted)
