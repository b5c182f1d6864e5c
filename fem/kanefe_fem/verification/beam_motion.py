"""Beams in motion: pendulum, hub under torque, spinning rod."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.rigid import attitude_checks
from kanefe.checks.verification.scenes import displaced_node, states_at
from kanefe.joints import Free, Revolute
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle, SolidCircle
from kanefe_fem.materials.isotropic import Material

ALUMINIUM = Material(E=70e9, nu=0.3, rho=2700.0)
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

TIP = 40
"""Index of the last node of the beams below."""

RTOL, ATOL = 1e-9, 1e-9
"""Tolerances of the runs with beam S. With 1e-6, a run would not be faster, since stability limits the steps, and the
angle of C03 would differ by 1e-6 between machines: round-off would decide which steps end near the kink of the torque.
"""


def beam_S() -> FlexibleBody:
    """Return the beam "S" of the cases, 1 m x 5 mm x 20 mm, clamped at the root, where G is its tangent frame.

    Six modes reach up to 350 Hz; more modes make the scene stiffer and change the position of the tip by at most 3e-6
    m.
    """
    model = straight_beam(1.0, Rectangle(width=0.005, height=0.02), ALUMINIUM, elements=TIP, planar=True)
    return beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=6))


def flexible_pendulum(reference: Reference) -> Iterator[Check]:
    """C01: beam S hinged at its root and released from the horizontal."""
    scene = System(gravity=(0.0, -9.81, 0.0))
    scene.add_flexible_body("beam", beam_S(), joint=Revolute("z"))
    model = scene.freeze()
    values = reference.values
    found = [displaced_node(model, "beam", TIP, state)[0][:2] for state in states_at(model, values["T"], RTOL, ATOL)]
    exact = [row[1:3] for row in values["geometrically_exact"]]
    yield Check.absolute("tip x, y to t = 1 s [m], against the geometrically exact beam", found, exact, 1.5e-4)
    # the same linear model in the tangent frame is closer, but has converged only to 2e-6 at t = 0.2 s
    same = values["linear_FFR_tangent_frame"]
    yield Check.absolute("tip x, y to t = 1 s [m], against the linear tangent frame", found, same, 1e-5)
    refined = values["refined"]["ffr_cant_o1_n10"]
    yield Check.absolute("tip x, y to t = 0.3 s [m], against the same, refined", found[: len(refined)], refined, 2e-6)


def hub_under_torque(reference: Reference) -> Iterator[Check]:
    """C03: beam S on a hub that is turned by a sinusoidal torque."""
    scene = System()
    hub = scene.add_rigid_body("hub", mass=1.0, inertia=0.5, joint=Revolute("z"))
    scene.add_flexible_body("beam", beam_S(), parent=hub, at=(0.1, 0.0, 0.0))
    scene.add_torque(hub, lambda t: math.sin(2.0 * math.pi * t) if t < 1.0 else 0.0)
    model = scene.freeze()
    states = states_at(model, reference.values["T"], RTOL, ATOL)
    expected = np.array(reference.values["linear_FFR"])
    angles = [q[0] for _, q, _ in states]
    yield Check.absolute("hub angle to t = 2 s [rad]", angles, expected[:, 0], 5e-7)
    deflections = [displaced_node(model, "beam", TIP, state)[1][1] for state in states]
    yield Check.absolute("tip deflection in the hub to t = 2 s [m]", deflections, expected[:, 1], 2e-6)


def spinning_rod(reference: Reference) -> Iterator[Check]:
    """E01c: a free round rod that spins about its axis and precesses."""
    rod = straight_beam(1.0, SolidCircle(0.04), STEEL, elements=20, start=(-0.5, 0.0, 0.0))
    # the loads are odd about the middle, so that the first pair of bending modes, which is even, does not contribute
    body = beam_body(rod, {}, reduction=CraigBampton(modes=4))
    yield Check.relative("mass [kg]", body.mass, reference.values["m"], 1e-12)
    yield Check.relative("principal moments of inertia [kg m2]", np.diag(body.inertia), reference.values["J"], 1e-12)
    scene = System()
    scene.add_flexible_body("rod", body, joint=Free(angular_velocity=reference.values["w0"]))
    # an error of 1e-7 of the spin would be twice the tolerance
    states = states_at(scene.freeze(), reference.values["times"], rtol=1e-8, atol=1e-8)
    yield from attitude_checks(states, reference, 1e-5)


CASES = (Case("C01", flexible_pendulum), Case("C03", hub_under_torque), Case("E01c", spinning_rod))
