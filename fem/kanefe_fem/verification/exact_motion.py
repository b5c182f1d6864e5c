"""Exact beams in motion: in free flight, at a right angle, and on a hub that spins up."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.scenes import Sample, frame_at, states_at
from kanefe.equations.model import Model
from kanefe.frames import rotation_about
from kanefe.joints import Planar
from kanefe.system import System
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.exact import exact_beam
from kanefe_fem.beams.sections import Section
from kanefe_fem.verification import spin_up

LENGTH = 10.0
"""Length of each beam, m."""

PULL, PUSH, END_OF_LOAD = 8.0, -80.0, 2.5
"""Force (N) and couple (N m) on the flying beam, and when they end (s)."""

FORCE = 50.0
"""Largest force on the elbow, N; it rises for a second and falls for another."""


def as_they_are(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function."""
    return function


def section_of_motion(EA: float, EI: float) -> BeamSection:
    """Return a section with GA = EA, EI and GJ equal, 1 kg/m and the large rotary inertia of both cases."""
    return Section.from_stiffness(EA=EA, GA_y=EA, GA_z=EA, EI_y=EI, EI_z=EI, GJ=EI, rho_A=1.0, rho_I=10.0)


def flying(functions: int, given: Callable[..., Any] = as_they_are) -> Model:
    """Return the flying beam of G01, with so many functions of each of its three strains.

    `given` may compile the functions of the loads.
    """
    beam = exact_beam(LENGTH, section_of_motion(1e4, 500.0), theory="shear-deformable", planar=True, basis=functions)
    scene = System()
    start = rotation_about("z", math.atan2(8.0, -6.0))
    root = scene.add_flexible_body("beam", beam, joint=Planar(), at=(6.0, 0.0, 0.0), orientation=start).interface(
        "root"
    )
    scene.add_force(root, given(lambda t: (PULL if t <= END_OF_LOAD else 0.0, 0.0, 0.0)))
    scene.add_torque(root, given(lambda t: (0.0, 0.0, PUSH if t <= END_OF_LOAD else 0.0)))
    return scene.freeze()


def right_angle(bending: int, stretch: int, given: Callable[..., Any] = as_they_are) -> Model:
    """Return the cantilever of G10 with so many functions of bending and twist, and of stretch and shear."""
    basis = {
        **dict.fromkeys(("twist", "curvature_y", "curvature_z"), bending),
        **dict.fromkeys(("stretch", "shear_y", "shear_z"), stretch),
    }
    beam = exact_beam(LENGTH, section_of_motion(1e6, 1e3), theory="shear-deformable", basis=basis)
    scene = System()
    elbow = scene.add_flexible_body("first", beam).interface("tip")
    scene.add_flexible_body("second", beam, parent=elbow, orientation=rotation_about("z", 0.5 * math.pi))
    scene.add_force(elbow, given(lambda t: (0.0, 0.0, FORCE * max(0.0, 1.0 - abs(t - 1.0)))))
    return scene.freeze()


def section_place(model: Model, body: str, name: str, state: Sample) -> np.ndarray:
    """Return the place of an interface of a beam in N."""
    terms = model.flexible_terms(body)
    eta = state[1][terms.eta]
    inner = terms.body.interface(name)
    G = frame_at(model, body, state)
    return np.asarray(G.p_NoFo_N + G.A_NF @ (inner.position + inner.moved(eta)[0][:3]))


def flying_beam(reference: Reference) -> Iterator[Check]:
    """G01: loads that jump make the error fall with a power of the number of functions, not exponentially."""
    values = reference.values
    for functions, tolerance in ((6, 1e-2), (8, 1e-3), (12, 5e-4)):
        model = flying(functions)
        states = states_at(model, values["T"], 1e-6)
        places = [
            np.concatenate([section_place(model, "beam", end, state)[:2] for end in ("root", "tip")])
            for state in states
        ]
        quantity = f"ends to t = 10 s over the length, {functions} functions a strain"
        yield Check.absolute(quantity, np.array(places) / LENGTH, np.array(values["ends"]) / LENGTH, tolerance)


def right_angle_cantilever(reference: Reference) -> Iterator[Check]:
    """G10: two beams, of which the second hangs on the first."""
    values = reference.values
    model = right_angle(6, 4)
    states = states_at(model, values["T"], 1e-7)
    places = [
        np.concatenate([section_place(model, leg, "tip", state) for leg in ("first", "second")]) for state in states
    ]
    expected = np.array(values["elbow and tip"])
    quantity = f"elbow and tip to t = {values['T'][-1]:g} s over the length of a leg"
    yield Check.absolute(quantity, np.array(places) / LENGTH, expected / LENGTH, 1e-3)


def exact_arm(reference: Reference) -> Iterator[Check]:
    """D01: the arm as one exact beam, which the reference is as well."""
    inertia = spin_up.LINE_INERTIA
    section = Section.from_stiffness(
        EA=spin_up.EA, GA_y=spin_up.GA, EI_z=spin_up.EI, rho_A=spin_up.LINE_MASS, rho_I=inertia
    )
    basis = {"stretch": 4, "shear_y": 4, "curvature_z": 6}
    beam = exact_beam(spin_up.LENGTH, section, theory="shear-deformable", planar=True, basis=basis)
    yield from spin_up.spun_checks(reference, beam, "exact beam", (1e-4, 1e-3, 1e-3, 1e-3))


CASES = (
    Case("D01", exact_arm),
    Case("G01", flying_beam),
    Case("G10", right_angle_cantilever),
)
