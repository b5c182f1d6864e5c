"""Beams that are stiffened by their own motion or their loads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.rotors import spin_eigenvalues
from kanefe.checks.verification.scenes import displaced_node, frame_at, states_at
from kanefe.equations.model import Model
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import FiniteElementModel
from kanefe.joints import Motion, Revolute
from kanefe.reduction import CraigBampton
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle, Section, SolidCircle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.verification import spin_up
from kanefe_fem.verification.beam_motion import ALUMINIUM
from kanefe_fem.verification.beam_statics import ELEMENTS as BAR_ELEMENTS
from kanefe_fem.verification.beam_statics import beam_bar
from kanefe_fem.verification.centrifugal import centrifugal_statics
from kanefe_fem.verification.slider_crank import ELEMENTS, slider_crank

THIN_SECTION = Section(A=1.0, I_y=1e-8, I_z=1e-8, J=1e-8)
THIN_MATERIAL = Material(E=1e8, nu=0.0, rho=1.0)
"""Material with EI = rho A = 1, and EA = 1e8: at 12 rad/s a bar of 1 m stretches by 5e-7."""


def thin_beam(elements: int, length: float = 1.0) -> FiniteElementModel:
    """Return the planar Euler-Bernoulli beam with EI = rho A = 1, nearly inextensible."""
    return straight_beam(
        length,
        THIN_SECTION,
        THIN_MATERIAL,
        elements=elements,
        theory="euler-bernoulli",
        planar=True,
        rotary_inertia=False,
    )


def rotating_cantilever(reference: Reference) -> Iterator[Check]:
    """D03a: flap and chord frequencies of a rotating beam, a planar body that spins about y or z."""
    body = beam_body(thin_beam(20), {"root": "clamped"}, reduction=CraigBampton(modes=14), stiffening="inertial")
    first, others = [], []
    for name, expected in reference.values.items():
        speed = float(name.split("gamma=")[1])
        for axis, kind in (("y", "flap"), ("z", "chord")):
            found = spin_eigenvalues(_spun(body, axis, speed))[:3].imag
            first.append((found[0], expected[kind][0]))
            others += list(zip(found[1:], expected[kind][1:], strict=True))
    label = "flap and chord at 0 ... 12, 20 elements"
    yield Check.relative(f"first frequency, {label}", [p[0] for p in first], [p[1] for p in first], 1e-4)
    yield Check.relative(f"second and third frequency, {label}", [p[0] for p in others], [p[1] for p in others], 1e-3)


def spin_softening(reference: Reference) -> Iterator[Check]:
    """D05: the same without stiffening: chord frequencies decrease, flap frequencies are as at rest."""
    body = beam_body(thin_beam(40), {"root": "clamped"}, reduction=CraigBampton(modes=14))
    at_rest = reference.values["0"]
    for name, expected in reference.values.items():
        found = spin_eigenvalues(_spun(body, "z", float(name)))[:3].imag
        yield Check.relative(f"chord frequencies 1-3 at {name}, 40 elements", found, expected, 1e-4)
        found = spin_eigenvalues(_spun(body, "y", float(name)))[:3].imag
        yield Check.relative(f"flap frequencies 1-3 at {name}, 40 elements", found, at_rest, 1e-4)


def _spun(body: FlexibleBody, axis: str, speed: float) -> Model:
    scene = System()
    scene.add_flexible_body("blade", body, joint=Revolute(axis, motion=Motion.steady(speed)))
    return scene.freeze()


def arm_of_beams(reference: Reference) -> Iterator[Check]:
    """D01: 20 planar Timoshenko elements."""
    section = Section(
        A=spin_up.AREA, I_y=spin_up.LINE_INERTIA / spin_up.DENSITY, I_z=spin_up.LINE_INERTIA / spin_up.DENSITY, J=1e-6
    )
    E = spin_up.EA / spin_up.AREA
    material = Material(E=E, nu=section.shear_y * spin_up.EA / spin_up.GA / 2.0 - 1.0, rho=spin_up.DENSITY)
    model = straight_beam(spin_up.LENGTH, section, material, elements=20, planar=True)

    def arm(stiffening: StiffeningLevel) -> FlexibleBody:
        interfaces = {"root": "clamped", "tip": "rigid"}
        return beam_body(model, interfaces, reduction=CraigBampton(modes=8), stiffening=stiffening)

    yield from spin_up.spin_up_checks(reference, arm, "20 beam elements")


def stiffened_bar(reference: Reference) -> Iterator[Check]:
    """E02a: second-order motion does not change a bar that only stretches."""

    def bar(interfaces: Mapping[str, str]) -> FlexibleBody:
        return beam_bar(interfaces, stiffening="full")

    yield from centrifugal_statics(reference, bar, f"{BAR_ELEMENTS} beam elements with stiffening")


def foreshortened_pendulum(reference: Reference) -> Iterator[Check]:
    """C01: beam S with foreshortening, against the geometrically exact beam."""
    model = straight_beam(1.0, Rectangle(width=0.005, height=0.02), ALUMINIUM, elements=40, planar=True)
    interfaces = {"root": "clamped", "tip": "rigid"}
    body = beam_body(model, interfaces, reduction=CraigBampton(modes=4), stiffening="full")
    scene = System(gravity=(0.0, -9.81, 0.0))
    scene.add_flexible_body("beam", body, joint=Revolute("z"))
    frozen = scene.freeze()
    places = []
    for state in states_at(frozen, reference.values["T"], 1e-7, method="generalised-alpha"):
        G, tip = frame_at(frozen, "beam", state), body.interface("tip")
        moved = tip.moved(state[1][frozen.flexible_terms("beam").eta])[0]
        places.append((G.p_NoFo_N + G.A_NF @ (tip.position + moved[:3]))[:2])
    exact = [row[1:3] for row in reference.values["geometrically_exact"]]
    yield Check.absolute("tip x, y with foreshortening, against the geometrically exact beam [m]", places, exact, 2e-5)


def stiffened_slider_crank(reference: Reference) -> Iterator[Check]:
    """C06: the rod with stiffening by its axial force, and a chord that shortens in bending."""
    frozen = slider_crank({"root": Interface(fixed=("x", "y")), "tip": Interface(fixed=("y",))}, stiffening="full")
    states = states_at(frozen, reference.values["T"], 1e-6, method="generalised-alpha")
    bends = [displaced_node(frozen, "rod", ELEMENTS // 2, state)[1][1] for state in states]
    expected = np.array(reference.values["GE"])[:, 0]
    quantity = "deflection of the middle with stiffening, against the geometrically exact rod [m]"
    yield Check.absolute(quantity, bends, expected, 1.5e-5)


def whirling_beam(reference: Reference) -> Iterator[Check]:
    """D04a: the same shaft as one body of beams, with the inertia of tilted sections to second order."""
    beams = straight_beam(
        1.0, SolidCircle(0.05), Material(E=210e9, nu=0.3, rho=7850.0), elements=24, theory="euler-bernoulli"
    )
    supports = {"root": Interface(fixed=("x", "y", "z", "rx")), "tip": Interface(fixed=("y", "z"))}
    body = beam_body(beams, supports, reduction=CraigBampton(modes=24), stiffening="inertial")
    for spin, pairs in reference.values["whirl"].items():
        expected = np.sort(np.concatenate([pair["rotframe"] for pair in pairs]))
        values = spin_eigenvalues(_spun(body, "x", float(spin))).imag
        found = [values[np.abs(values - omega).argmin()] for omega in expected]  # without stretch and twist
        quantity = f"whirl in the spinning frame at {float(spin):g} rad/s, one body with stiffening [rad/s]"
        yield Check.relative(quantity, found, expected, 1e-4)


CASES = (
    Case("C01", foreshortened_pendulum),
    Case("C06", stiffened_slider_crank),
    Case("D01", arm_of_beams),
    Case("D03a", rotating_cantilever),
    Case("D04a", whirling_beam),
    Case("D05", spin_softening),
    Case("E02a", stiffened_bar),
)
