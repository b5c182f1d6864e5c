"""Case of a slider-crank with a rod from coefficient matrices: two sine modes and a quadratic axial element."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.mass_moments import MassMoments
from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import states_at
from kanefe.joints import Motion, Prismatic, Revolute, Spherical
from kanefe.system import System

PI = 3.1415927
"""Value of pi in the test set."""

CRANK, ROD, WIDTH, HEIGHT, RATE = 0.15, 0.30, 0.008, 0.008, 150.0
E, DENSITY = 2e11, 7870.0
CRANK_MASS, ROD_MASS, SLIDER_MASS = 0.36, 0.151104, 0.075552
CRANK_INERTIA, ROD_INERTIA = 0.002727, 0.0045339259
START = (0.0, 0.0, 1.03339863e-5, 1.69327969e-5)
START_RATES = (0.444896105, 4.63434311e-3, -1.78591076e-6, -2.68938672e-6)
ROD_RATE, SLIDER_RATE = -74.9957670, -2.68938672e-6

LATERAL, AXIAL, MOVED_X, MOVED_Y = slice(0, 2), slice(2, 4), 4, 5
"""Coordinates of the rod: lateral sines, axial nodes, and two translations of the root, which are fixed in G."""


def rod_moments() -> MassMoments:
    """Return the mass moments of the test set's coefficients.

    Their axial mass block is fifteen times too large; it is kept, because the case refers to these coefficients.
    """
    volume = WIDTH * HEIGHT * ROD
    c1 = DENSITY * volume * np.array((2 / 3, 1 / 6))
    c2 = DENSITY * volume * np.array((2 / PI, 0.0))
    c12 = DENSITY * volume * ROD * np.array((1 / 3, 1 / 6))
    c21 = DENSITY * volume * ROD * np.array((1 / PI, -0.5 / PI))
    between = DENSITY * volume * np.array(((16 / PI**3, 0.0), (1 / PI - 8 / PI**3, -0.5 / PI)))
    first, second = np.array((0.5 * ROD_MASS * ROD, 0.0, 0.0)), np.zeros((3, 3))
    second[0, 0] = ROD_INERTIA
    shape_first, shape_second, product = np.zeros((3, 6)), np.zeros((3, 3, 6)), np.zeros((3, 3, 6, 6))
    shape_first[0, AXIAL], shape_first[1, LATERAL] = c1, c2
    shape_first[0, MOVED_X] = shape_first[1, MOVED_Y] = ROD_MASS
    shape_second[0, 0, AXIAL], shape_second[0, 1, LATERAL] = c12, c21
    shape_second[0, 0, MOVED_X] = shape_second[0, 1, MOVED_Y] = first[0]
    mass = DENSITY * volume
    product[0, 0, AXIAL, AXIAL] = mass * np.array(((8.0, 1.0), (1.0, 2.0)))
    product[1, 1, LATERAL, LATERAL] = 0.5 * mass * np.eye(2)
    product[0, 1, AXIAL, LATERAL] = between
    product[0, 0, MOVED_X, AXIAL] = product[0, 0, AXIAL, MOVED_X] = product[0, 1, AXIAL, MOVED_Y] = c1
    product[1, 1, MOVED_Y, LATERAL] = product[1, 1, LATERAL, MOVED_Y] = product[0, 1, MOVED_X, LATERAL] = c2
    product[0, 0, MOVED_X, MOVED_X] = product[1, 1, MOVED_Y, MOVED_Y] = product[0, 1, MOVED_X, MOVED_Y] = ROD_MASS
    product[1, 0] = product[0, 1].T
    return MassMoments(np.asarray(ROD_MASS), first, second, shape_first, shape_second, product)


def rod() -> FlexibleBody:
    """Return the rod: the x axis of G is its chord, its root is fixed in G, its tip can move along the chord."""
    stiffness = np.zeros((6, 6))
    tension, slender = E * WIDTH * HEIGHT / ROD, (HEIGHT / ROD) ** 2
    stiffness[LATERAL, LATERAL] = tension * slender * PI**4 * np.diag((1 / 24, 2 / 3))
    stiffness[AXIAL, AXIAL] = tension / 3 * np.array(((16.0, -8.0), (-8.0, 7.0)))
    # x and y of root, middle and tip
    basis = np.zeros((3, 2, 6))
    basis[1, 0, 2] = basis[2, 0, 3] = basis[1, 1, 0] = 1.0
    basis[:, 0, MOVED_X] = basis[:, 1, MOVED_Y] = 1.0
    nodes = np.array(((0.0, 0.0, 0.0), (0.5 * ROD, 0.0, 0.0), (ROD, 0.0, 0.0)))
    root, tip = np.zeros((6, 6)), np.zeros((6, 6))
    root[:2], tip[:2] = basis[0], basis[2]
    root[5, LATERAL], tip[5, LATERAL] = PI / ROD * np.array((1, 2)), PI / ROD * np.array((-1, 2))
    return FlexibleBody(
        nodes=nodes,
        components=("x", "y"),
        basis=basis.reshape(6, 6),
        free_count=4,
        stiffness=stiffness,
        damping=np.zeros((4, 4)),
        moments=rod_moments(),
        interfaces=(
            InterfaceFrame("root", nodes[0], root, fixed_components=(0, 1), fixed_columns=(MOVED_X, MOVED_Y)),
            InterfaceFrame("tip", nodes[2], tip),
        ),
        inertia_points=np.zeros((0, 3)),
        inertia_mass=sp.csr_matrix((0, 0)),
        inertia_basis=np.zeros((0, 6)),
    )


def flexible_slider_crank(reference: Reference) -> Iterator[Check]:
    """C02: the test set's flexible slider-crank, with the crank driven at 150 rad/s."""
    scene = System()
    crank = scene.add_rigid_body("crank", CRANK_MASS, CRANK_INERTIA, joint=Revolute("z", motion=Motion.steady(RATE)))
    member = scene.add_flexible_body(
        "rod",
        rod(),
        parent=crank,
        at=(CRANK, 0.0, 0.0),
        joint=Revolute("z", speed=ROD_RATE - RATE),
        modal_coordinates=START,
        modal_speeds=START_RATES,
    )
    slider = scene.add_rigid_body(
        "slider", SLIDER_MASS, joint=Prismatic("x", position=CRANK + ROD + START[3], speed=SLIDER_RATE)
    )
    scene.add_loop_joint("pin", Spherical(), member.interface("tip"), slider)
    model = scene.freeze()
    values = reference.values["own"]
    state = states_at(model, [0.1], 1e-7, 1e-11)[0]
    terms = model.flexible_terms("rod")
    turn = float(model.bodies[1].joint_coordinates(*state[:2])[0]) + RATE * 0.1
    place = float(model.bodies[2].joint_coordinates(*state[:2])[0])
    expected = values["y"]
    yield Check.relative("angle of the rod at t = 0.1 s [rad]", turn, expected[1], 1e-4)
    yield Check.relative("position of the slider at t = 0.1 s [m]", place, expected[2], 1e-4)
    yield Check.relative("q1 ... q4 at t = 0.1 s [m]", state[1][terms.eta], expected[3:7], 1e-4)


CASES = (Case("C02", flexible_slider_crank),)
