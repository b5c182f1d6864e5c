"""Which stress cases there are: those of kanefe, and those of installed plugins.

A plugin names a module in the entry-point group ``kanefe.robustness``; the module has ``CASES``, a tuple of
`StressCase`.
"""

from __future__ import annotations

from collections import Counter
from operator import attrgetter

from kanefe.checks.registry import Registry
from kanefe.checks.robustness import (
    contact,
    contact_changes,
    determinism,
    drift,
    events,
    flexible_extremes,
    invariances,
    loops,
    mass_extremes,
    overconstrained,
    rigid_contact,
    rotations,
    shaken_blocks,
    spin,
    steps,
    vibrations,
)
from kanefe.checks.robustness.case import StressCase
from kanefe.errors import ModelError

REGISTRY = Registry("stress", "kanefe.robustness", StressCase, attrgetter("name"))

OWN: tuple[StressCase, ...] = (
    *drift.CASES,
    *flexible_extremes.CASES,
    *vibrations.CASES,
    *mass_extremes.CASES,
    *rotations.CASES,
    *loops.CASES,
    *overconstrained.CASES,
    *spin.CASES,
    *steps.CASES,
    *events.CASES,
    *contact.CASES,
    *contact_changes.CASES,
    *rigid_contact.CASES,
    *shaken_blocks.CASES,
    *invariances.CASES,
    *determinism.CASES,
)
"""Cases in the order in which they are run and shown."""


def registered_cases() -> tuple[StressCase, ...]:
    """Return all cases, those of kanefe first.

    Raises
    ------
    ModelError
        If the module of a plugin has no cases, or two cases have one name.
    """
    cases = (*OWN, *REGISTRY.of_plugins())
    twice = sorted(name for name, count in Counter(case.name for case in cases).items() if count > 1)
    if twice:
        raise ModelError(f"two stress cases are called {twice[0]!r}. Remedy: update or remove the package of one")
    return cases
