"""Centrifugal statics of beam elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.verification.centrifugal import AREA, DENSITY, LENGTH, YOUNG, centrifugal_statics

ELEMENTS = 20


def beam_bar(interfaces: Mapping[str, str], stiffening: StiffeningLevel = "none") -> FlexibleBody:
    """Return the bar of E02a, of planar beam elements without rotary inertia."""
    model = straight_beam(
        LENGTH,
        Rectangle(width=AREA**0.5, height=AREA**0.5),
        Material(E=YOUNG, nu=0.0, rho=DENSITY),
        elements=ELEMENTS,
        planar=True,
        rotary_inertia=False,
    )
    return beam_body(model, interfaces, stiffening=stiffening)


def spinning_beam(reference: Reference) -> Iterator[Check]:
    """E02a: linear elements suffice, because their nodal displacements under a given load are exact."""
    yield from centrifugal_statics(reference, beam_bar, f"{ELEMENTS} beam elements")


CASES = (Case("E02a", spinning_beam),)
