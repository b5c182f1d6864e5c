"""Which stress cases there are: those of kanefe, and those of installed plugins.

A plugin names a module in the entry-point group ``kanefe.robustness``; the module has ``CASES``, a tuple of
`StressCase`.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import entry_points

from kanefe.checks.robustness import (
    determinism,
    drift,
    events,
    flexible_extremes,
    invariances,
    loops,
    mass_extremes,
    overconstrained,
    rotations,
    spin,
    steps,
)
from kanefe.checks.robustness.case import StressCase
from kanefe.errors import ModelError

GROUP = "kanefe.robustness"

OWN: tuple[StressCase, ...] = (
    *drift.CASES, *flexible_extremes.CASES, *mass_extremes.CASES, *rotations.CASES, *loops.CASES,
    *overconstrained.CASES, *spin.CASES, *steps.CASES, *events.CASES, *invariances.CASES, *determinism.CASES,
)  # fmt: skip
"""In the order in which they are run and shown."""


def registered_cases() -> tuple[StressCase, ...]:
    """Return all cases, those of kanefe first.

    Raises
    ------
    ModelError
        If the module of a plugin has no cases, or two cases have one name.
    """
    cases = OWN
    for entry in sorted(entry_points(group=GROUP), key=lambda e: e.name):
        added = getattr(entry.load(), "CASES", None)
        if not isinstance(added, tuple) or not all(isinstance(case, StressCase) for case in added):
            raise ModelError(
                f"the plugin {entry.value!r} of the group {GROUP!r} has no tuple CASES of stress cases. "
                "Remedy: update or remove the package it comes from"
            )
        cases += added
    names = [case.name for case in cases]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ModelError(f"two stress cases are called {twice[0]!r}. Remedy: update or remove the package of one")
    return cases


def select_cases(names: Sequence[str]) -> tuple[StressCase, ...]:
    """Return the cases with these names, or all if there are none given.

    Raises
    ------
    ModelError
        If a name is unknown; the message lists those there are.
    """
    cases = registered_cases()
    known = {case.name.casefold(): case for case in cases}
    unknown = [name for name in names if name.casefold() not in known]
    if unknown:
        raise ModelError(
            f"there is no stress case {', '.join(map(repr, unknown))}. "
            f"Remedy: one or more of {', '.join(case.name for case in cases)}"
        )
    wanted = {name.casefold() for name in names} or set(known)
    return tuple(case for case in cases if case.name.casefold() in wanted)
