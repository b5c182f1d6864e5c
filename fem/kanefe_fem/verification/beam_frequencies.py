"""Natural frequencies of beam elements."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import natural_modes, stretching_frequencies_with_tip_mass, system_modes
from kanefe.fe_model.interface import Interface
from kanefe.joints import Planar, Revolute
from kanefe.linear.linearisation import linearise
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle, Section, SolidCircle
from kanefe_fem.materials.isotropic import Material

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

UNIT_SECTION = Section(A=1.0, I_y=1e-6, I_z=1e-6, J=1e-6)
UNIT_MATERIAL = Material(E=1e6, nu=0.0, rho=1.0)
"""Material with EI = rho A = 1, and EA = 1e6 so that the first axial mode of 1 m lies above 1500 rad/s."""

PINNED = Interface(fixed=("x", "y"))


def unit_beam(elements: int, interfaces: dict[str, str | Interface], modes: int | None = None) -> FlexibleBody:
    """Return a planar Euler-Bernoulli beam with EI = rho A = L = 1, unreduced or with the given number of modes."""
    model = straight_beam(
        1.0,
        UNIT_SECTION,
        UNIT_MATERIAL,
        elements=elements,
        theory="euler-bernoulli",
        planar=True,
        rotary_inertia=False,
    )
    return beam_body(model, interfaces, reduction=None if modes is None else CraigBampton(modes=modes))


MANY = CraigBampton(modes=40)
"""Reduction with enough modes for the first ones of each kind."""


def component_frequencies(body: FlexibleBody, component: str) -> np.ndarray:
    """Return the natural frequencies in Hz of the modes that move the nodes along one component only.

    In a straight beam with a symmetric section, stretch, twist and bending in the two planes are uncoupled.
    """
    k = body.free_count
    frequencies, modes = natural_modes(body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k])
    motion = np.abs(body.basis[:, :k] @ modes).reshape(len(body.nodes), len(body.components), -1).max(axis=0)
    chosen = motion[body.components.index(component)] > 1e-3 * motion.max(axis=0)
    return frequencies[chosen] / (2.0 * np.pi)


def bending_roots(reference: Reference) -> Iterator[Check]:
    """B01: roots bL of uniform Euler-Bernoulli beams.

    The relative error of bL with Hermite elements of length h is (bh)^4 / 2880: with 20 of them it is 3.2e-5 for the
    third root of the free-free beam, so all beams except the cantilever have 40.
    """
    supports: tuple[tuple[str, str, int, dict[str, str | Interface]], ...] = (
        ("clamped-free", "clamped-free", 20, {"root": "clamped"}),
        ("free-free", "free-free/clamped-clamped", 40, {}),
        ("clamped-clamped", "free-free/clamped-clamped", 40, {"root": "clamped", "tip": "clamped"}),
        ("clamped-pinned", "clamped-pinned/free-pinned", 40, {"root": "clamped", "tip": PINNED}),
    )
    for name, key, elements, interfaces in supports:
        expected = [float(root) for root in reference.values[key][:3]]
        found = np.sqrt(2.0 * np.pi * unit_beam(elements, interfaces).frequencies[:3])
        yield Check.relative(f"bL 1-3, {name}, {elements} elements", found, expected, 1e-5)
    scene = System()
    scene.add_flexible_body("beam", unit_beam(40, {"root": "clamped"}), joint=Revolute("z"))
    frequencies, _ = system_modes(scene.freeze())
    expected = [float(root) for root in reference.values["clamped-pinned/free-pinned"][:3]]
    yield Check.relative(
        "bL 1-3, free-pinned by a revolute joint, 40 elements", np.sqrt(frequencies[1:4]), expected, 1e-5
    )


def timoshenko_clamped_free(reference: Reference) -> Iterator[Check]:
    """B02a: a thick cantilever and a thick free beam."""
    yield from _timoshenko(reference, {"clamped-free": {"root": "clamped"}, "free-free": {}})


def timoshenko_clamped_pinned(reference: Reference) -> Iterator[Check]:
    """B02b: a thick beam clamped or pinned at both ends."""
    supports: dict[str, dict[str, str | Interface]] = {
        "clamped-clamped": {"root": "clamped", "tip": "clamped"},
        "pinned-pinned": {"root": PINNED, "tip": Interface(fixed=("y",))},
    }
    yield from _timoshenko(reference, supports)


def _timoshenko(reference: Reference, supports: dict[str, dict[str, str | Interface]]) -> Iterator[Check]:
    # the frequencies converge with the second order: with 60 elements the fifth is 1e-3 too high
    elements = 240
    section = Rectangle(width=0.1, height=0.05)  # kappa = 5/6; bends across the width
    model = straight_beam(1.0, section, STEEL, elements=elements, planar=True)
    for name, interfaces in supports.items():
        expected = [float(f) for f in reference.values[name]]
        found = component_frequencies(beam_body(model, interfaces, reduction=MANY), "y")[: len(expected)]
        yield Check.relative(f"f 1-{len(expected)}, {name}, {elements} elements [Hz]", found, expected, 1e-4)


def tip_masses(reference: Reference) -> Iterator[Check]:
    """B03a: a cantilever with a rigid body at its tip, as the modes of the coupled scene."""
    for name, expected in reference.values.items():
        mass, inertia, offset = (float(part.split("=")[1]) for part in name.split(","))
        scene = System()
        beam = scene.add_flexible_body("beam", unit_beam(40, {"root": "clamped", "tip": "rigid"}))
        scene.add_rigid_body("tip", mass, inertia, parent=beam.interface("tip"), com=(offset, 0.0, 0.0))
        found = 2.0 * np.pi * linearise(scene).modes().frequencies[:4]
        yield Check.relative(f"omega 1-4, {name}, 40 elements [rad/s]", found, _omegas(expected), 1e-5)


def hub_and_beams(reference: Reference) -> Iterator[Check]:
    """B04a: two beams on opposite sides of a free rigid hub."""
    for name, expected in reference.values.items():
        radius, inertia, mass = (float(part.split("=")[1]) for part in name.split(","))
        scene = System()
        hub = scene.add_rigid_body("hub", mass, inertia, joint=Planar())
        beam = unit_beam(40, {"root": "clamped"})
        scene.add_flexible_body("right", beam, parent=hub, at=(radius, 0.0, 0.0))
        scene.add_flexible_body("left", beam, parent=hub, at=(-radius, 0.0, 0.0), orientation=(0.0, 0.0, 0.0, 1.0))
        modes = linearise(scene).modes()
        yield Check.absolute(f"number of rigid modes, {name}", np.count_nonzero(modes.is_rigid), 3, 0.0)
        share = np.abs(modes.shape("hub"))
        for kind, entry, label in (("rot", 5, "hub rotates"), ("trans", 1, "hub translates")):
            own = ~modes.is_rigid & (share[:, entry] > 1e3 * np.delete(share, entry, axis=1).max(axis=1))
            found = 2.0 * np.pi * modes.frequencies[own][:4]
            quantity = f"omega 1-4, {name}, {label}, 40 elements [rad/s]"
            yield Check.relative(quantity, found, _omegas(expected[kind]), 1e-5)


def _omegas(pairs: list[list[str]]) -> list[float]:
    """Return the second entries of pairs [bL, omega]."""
    return [float(omega) for _, omega in pairs]


def bars(reference: Reference) -> Iterator[Check]:
    """B06: axial and torsional modes; the elements are linear in stretch and twist, so many are needed."""
    elements = 200
    model = straight_beam(1.0, Rectangle(width=0.02, height=0.02), STEEL, elements=elements, planar=True)
    for name, interfaces in (("axial_fixed_free", {"root": "clamped"}), ("axial_free_free", {})):
        found = component_frequencies(beam_body(model, interfaces, reduction=MANY), "x")[:3]
        label = name.replace("_", " ")
        yield Check.relative(f"f 1-3, {label}, {elements} linear elements [Hz]", found, reference.values[name], 1e-4)

    tipped = beam_body(model, {"root": "clamped", "tip": "rigid"}, reduction=MANY)
    found = stretching_frequencies_with_tip_mass(tipped, STEEL.rho * 0.02**2)[:3]
    expected = reference.values["axial_tipmass_1"]
    yield Check.relative(f"f 1-3, axial, tip mass = bar mass, {elements} linear elements [Hz]", found, expected, 1e-4)

    shaft = straight_beam(1.0, SolidCircle(0.2), STEEL, elements=elements)
    body = beam_body(shaft, {"root": "clamped"}, reduction=MANY)
    found = component_frequencies(body, "rx")[:3]
    expected = reference.values["torsion_fixed_free"]
    yield Check.relative(f"f 1-3, torsion fixed free, {elements} linear elements [Hz]", found, expected, 1e-4)


def craig_bampton(reference: Reference) -> Iterator[Check]:
    """B09: frequencies with n fixed-interface modes, both ends interfaces of 32 Hermite elements."""
    for count, by_support in reference.values.items():
        for name, root in (("cantilever", "clamped"), ("freefree", "rigid")):
            expected = by_support[name]
            body = unit_beam(32, {"root": root, "tip": "rigid"}, modes=int(count))
            found = 2.0 * np.pi * body.frequencies[: len(expected)]
            label = "free-free" if name == "freefree" else name
            quantity = f"omega 1-{len(expected)}, n = {count}, {label}, 32 elements [rad/s]"
            yield Check.relative(quantity, found, expected, 1e-6)


CASES = (
    Case("B01", bending_roots),
    Case("B02a", timoshenko_clamped_free),
    Case("B02b", timoshenko_clamped_pinned),
    Case("B03a", tip_masses),
    Case("B04a", hub_and_beams),
    Case("B06", bars),
    Case("B09", craig_bampton),
)
