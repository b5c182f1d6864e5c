"""A slider-crank with a flexible rod, hinged at both ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import displaced_node, frame_at, states_at
from kanefe.equations.model import Model
from kanefe.fe_model.interface import Interface
from kanefe.joints import Motion, Prismatic, Revolute, Spherical
from kanefe.reduction import CraigBampton
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material

STEEL = Material(E=200e9, nu=0.3, rho=7870.0)
CRANK, ROD, RATE, SLIDER = 0.15, 0.3, 150.0, 0.075552

ELEMENTS = 20
PEAK = 1.6e-3
"""Largest deflection of the reference, m; its tolerance is relative to it."""


def slider_crank(interfaces: Mapping[str, Interface], stiffening: StiffeningLevel = "none") -> Model:
    """Return the slider-crank with the given interfaces at the ends of the rod."""
    model = straight_beam(
        ROD,
        Rectangle(width=0.008, height=0.008),
        STEEL,
        elements=ELEMENTS,
        theory="euler-bernoulli",
        rotary_inertia=False,
        planar=True,
    )
    body = beam_body(model, interfaces, reduction=CraigBampton(modes=4), stiffening=stiffening)
    scene = System()
    crank = scene.add_rigid_body("crank", 0.1, 1e-4, joint=Revolute("z", motion=Motion.steady(RATE)))
    rod = scene.add_flexible_body("rod", body, parent=crank, at=(CRANK, 0.0, 0.0), joint=Revolute("z"))
    slider = scene.add_rigid_body("slider", SLIDER, at=(CRANK + ROD, 0.0, 0.0), joint=Prismatic("x"))
    scene.add_loop_joint("pin", Spherical(), rod.interface("tip"), slider)
    return scene.freeze()


def flexible_slider_crank(reference: Reference) -> Iterator[Check]:
    """C06: a steel rod driven at 150 rad/s; the linear model, without stiffening by axial forces."""
    # G is the chord, on which both ends are held and free to rotate; as in the reference, its length is constant
    held = Interface(fixed=("x", "y"))
    frozen = slider_crank({"root": held, "tip": held})
    values = reference.values
    states = states_at(frozen, values["T"], 1e-7, 1e-9)
    expected = np.array(values["linear_FFR"])
    bends, angles, places = [], [], []
    for state in states:
        bends.append(displaced_node(frozen, "rod", ELEMENTS // 2, state)[1][1])
        A = frame_at(frozen, "rod", state).A_NF
        angles.append(np.arctan2(A[1, 0], A[0, 0]))
        places.append(frame_at(frozen, "slider", state).p_NoFo_N[0])
    yield Check.absolute("deflection of the middle to t = 0.04 s [m]", bends, expected[:, 0], 1.5e-5)
    yield Check.absolute("deflection as a share of the peak", np.array(bends) / PEAK, expected[:, 0] / PEAK, 5e-3)
    yield Check.absolute("angle of the rod to t = 0.04 s [rad]", angles, expected[:, 1], 1.5e-5)
    yield Check.absolute("place of the slider to t = 0.04 s [m]", places, expected[:, 3], 1.5e-5)


CASES = (Case("C06", flexible_slider_crank),)
