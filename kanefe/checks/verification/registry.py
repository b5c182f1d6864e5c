"""The verification cases of kanefe and of installed plugins.

A plugin names a module in the entry-point group ``kanefe.verification``; the module has ``CASES``, a tuple of `Case`.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points

from kanefe.checks.verification import (
    contact,
    dumbbell,
    impacts,
    joint_friction,
    loops,
    rests,
    rigid,
    rigid_contact,
    rigid_impacts,
    rotations,
    rotors,
    sampled_loops,
    simeon,
    turning,
    waves,
    woodpecker,
)
from kanefe.checks.verification.case import Case
from kanefe.checks.verification.references import load_references
from kanefe.errors import ModelError

GROUP = "kanefe.verification"
"""Group of the entry points of plugins."""

OWN = (
    *rigid.CASES,
    *rotations.CASES,
    *dumbbell.CASES,
    *loops.CASES,
    *simeon.CASES,
    *rotors.CASES,
    *sampled_loops.CASES,
    *contact.CASES,
    *turning.CASES,
    *impacts.CASES,
    *rigid_contact.CASES,
    *rigid_impacts.CASES,
    *woodpecker.CASES,
    *waves.CASES,
    *joint_friction.CASES,
    *rests.CASES,
)


def registered_cases() -> tuple[Case, ...]:
    """Return all cases (and parts of cases), sorted by id.

    Raises
    ------
    ModelError
        If the module of a plugin has no tuple ``CASES``, or a case has no reference.
    """
    cases = (*OWN, *_of_plugins())
    for case in cases:
        if case.id not in load_references():
            raise ModelError(
                f"the verification case {case.id!r} has no reference. Remedy: update or remove its package"
            )
    return tuple(sorted(cases, key=lambda case: case.id))


def _of_plugins() -> Iterator[Case]:
    for entry in sorted(entry_points(group=GROUP), key=lambda e: e.name):
        added = getattr(entry.load(), "CASES", None)
        if not isinstance(added, tuple) or not all(isinstance(case, Case) for case in added):
            raise ModelError(
                f"the plugin {entry.value!r} of the group {GROUP!r} has no tuple CASES of verification cases. "
                "Remedy: update or remove the package it comes from"
            )
        yield from added
