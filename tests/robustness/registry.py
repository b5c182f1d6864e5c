"""Which stress cases there are: those of the package, the long ones beside the tests, and those of finite elements."""

from __future__ import annotations

from kanefe.checks.robustness import cases
from robustness import (
    contact,
    determinism,
    events,
    far_bent,
    finite_elements,
    flexible_extremes,
    invariances,
    mass_extremes,
    overconstrained,
    rigid_contact,
    rocking,
    rotations,
    shaken_blocks,
    steps,
    vibrations,
)

CASES = (
    *cases.CASES,
    *flexible_extremes.CASES,
    *far_bent.CASES,
    *vibrations.CASES,
    *mass_extremes.CASES,
    *rotations.CASES,
    *overconstrained.CASES,
    *steps.CASES,
    *events.CASES,
    *contact.CASES,
    *rigid_contact.CASES,
    *rocking.CASES,
    *shaken_blocks.CASES,
    *invariances.CASES,
    *determinism.CASES,
    *finite_elements.CASES,
)
"""In the order in which they are run and shown."""
