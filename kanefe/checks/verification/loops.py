"""Cases of closed loops of rigid bodies: the N-four-bar, Andrews' squeezing mechanism, the slider-crank."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import frame_at, states_at, whole_run
from kanefe.equations.model import Model
from kanefe.joints import Prismatic, Revolute, Spherical
from kanefe.kane.assemble import accelerations
from kanefe.kane.reactions import loop_forces
from kanefe.scene.scene import Frame
from kanefe.states.state import State
from kanefe.system import System

GRAVITY = (0.0, -9.81, 0.0)
ROD = 1.0 / 12.0


def parallelograms(count: int) -> Model:
    """Return `count` parallelograms side by side: vertical cranks on the ground, couplers between their upper ends."""
    scene = System(gravity=GRAVITY)
    crank: dict[str, Any] = {"mass": 1.0, "inertia": ROD, "com": (0.0, 0.5, 0.0)}
    cranks = [
        scene.add_rigid_body(f"crank {i}", **crank, at=(i, 0.0, 0.0), joint=Revolute("z", speed=-1.0))
        for i in range(count + 1)
    ]
    for i in range(count):
        coupler = scene.add_rigid_body(
            f"coupler {i}", 1.0, ROD, com=(0.5, 0, 0), parent=cranks[i], at=(0, 1, 0), joint=Revolute("z", speed=1.0)
        )
        ends = coupler.frame(at=(1, 0, 0)), cranks[i + 1].frame(at=(0, 1, 0))
        scene.add_loop_joint(f"pin {i}", Spherical(), *ends)
    return scene.freeze()


def n_four_bar(reference: Reference) -> Iterator[Check]:
    """A02: parallelograms that pass the position in which all bars are collinear."""
    for count, rtol in ((2, 1e-9), (40, 1e-8)):
        model = parallelograms(count)
        expected = reference.values[str(count)]["B0"]
        run = whole_run(model, (0.0, 10.0), rtol, method="dop853", output_step=1.0)
        angle = run.coordinates[1:, 0]
        tops = np.column_stack((-np.sin(angle), np.cos(angle)))
        yield Check.absolute(f"B0 at t = 1 ... 10 s, N = {count} [m]", tops, list(expected.values()), 1e-5)


# Andrews' mechanism: lengths (m), masses (kg), inertias about the centres of mass (kg m2)
M1, M2, M3, M4, M5, M6, M7 = 0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498
I1, I2, I3, I4, I5, I6, I7 = 2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5
A, B, C = (-0.06934, -0.00227, 0.0), (-0.03635, 0.03273, 0.0), (0.014, 0.072, 0.0)
D_, DA, E_, EA, RR, RA = 28e-3, 115e-4, 2e-2, 1421e-5, 7e-3, 92e-5
SS, SA, SB, SC, SD, TA, TB = 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2, 2308e-5, 916e-5
U_, UA, UB, ZF, ZT, FA = 4e-2, 1228e-5, 449e-5, 2e-2, 4e-2, 1421e-5
STIFFNESS, REST, MOMENT = 4530.0, 7785e-5, 33e-3
START = (
    -0.0617138900142764496358948458001,
    0.0,
    0.455279819163070380255912382449,
    0.222668390165885884674473185609,
    0.487364979543842550225598953530,
    -0.222668390165885884674473185609,
    1.23054744454982119249735015568,
)
ANDREWS = ("beta", "Theta", "gamma", "Phi", "delta", "Omega", "epsilon")
"""Names of the bodies, those of their joint angles, in the order of the reference."""


def andrews_mechanism() -> Model:
    """Return the mechanism of seven bodies: crank, coupler, arm with the spring, two pairs of links; three loops."""
    scene = System()
    start = dict(zip(ANDREWS, START, strict=True))

    def add(
        name: str, mass: float, inertia: float, com: tuple[float, float], at: Any, parent: Frame | None = None
    ) -> Frame:
        joint = Revolute("z", position=start[name])
        return scene.add_rigid_body(name, mass, inertia, com=(*com, 0.0), at=at, parent=parent, joint=joint)

    crank = add("beta", M1, I1, (RA, 0.0), (0.0, 0.0, 0.0))
    coupler = add("Theta", M2, I2, (-DA, 0.0), (RR, 0.0, 0.0), crank)
    arm = add("gamma", M3, I3, (SB, -SA), B)
    lower = add("delta", M5, I5, (TA, TB), A)
    lower_link = add("Phi", M4, I4, (0.0, EA - E_), (ZT, 0.0, 0.0), lower)
    upper = add("epsilon", M7, I7, (UA, -UB), A)
    upper_link = add("Omega", M6, I6, (ZF - FA, 0.0), (0.0, -U_, 0.0), upper)
    end = coupler.frame(at=(-D_, 0.0, 0.0))
    for name, body, place in (
        ("arm", arm, (0.0, -SS, 0.0)),
        ("lower", lower_link, (0.0, -E_, 0.0)),
        ("upper", upper_link, (ZF, 0.0, 0.0)),
    ):
        scene.add_loop_joint(name, Spherical(), body.frame(at=place), end)
    scene.add_spring(
        "spring", scene.ground.frame(at=C), arm.frame(at=(SD, -SC, 0.0)), stiffness=STIFFNESS, rest_length=REST
    )
    scene.add_motor(crank, MOMENT)
    return scene.freeze()


def squeezing_mechanism(reference: Reference) -> Iterator[Check]:
    """A05: Andrews' squeezing mechanism: angles, rates, accelerations and loop forces."""
    model = andrews_mechanism()
    states = states_at(model, reference.values["times"], 1e-10)
    order = [int(model.bodies[model.index(name)].coordinates[0]) for name in ANDREWS]
    angles, rates = np.array([q[order] for _, q, _ in states]), np.array([u[order] for _, _, u in states])
    for what, found, expected in (("angles [rad]", angles, "q"), ("rates [rad/s]", rates, "qd")):
        yield Check.relative(f"{what} at t = 0.005 ... 0.03 s", found, reference.values[expected], 1e-7)
    last = State(model, *states[-1])
    du = accelerations(last)
    yield Check.relative("accelerations at t = 0.03 s [rad/s2]", du[order], reference.values["acc"], 1e-7)
    # multipliers of the reference are the opposite forces on the end of the coupler, in axes of N
    A_NK = frame_at(model, "Theta", states[-1]).A_NF
    forces = loop_forces(last)
    pushes = np.array([-(A_NK @ forces[name][:3])[:2] for name in ("arm", "lower", "upper")])
    yield Check.relative("forces of the loops at t = 0.03 s [N]", pushes.ravel(), reference.values["lam"], 1e-7)


def slider_crank(reference: Reference) -> Iterator[Check]:
    """A08: a slider-crank with a constant torque and gravity."""
    crank_length, rod_length = 0.2, 0.5
    scene = System(gravity=GRAVITY)
    crank = scene.add_rigid_body(
        "crank", 1.0, ROD * crank_length**2, com=(crank_length / 2, 0, 0), joint=Revolute("z", position=np.pi / 4)
    )
    rod = scene.add_rigid_body(
        "rod",
        1.5,
        1.5 * ROD * rod_length**2,
        com=(rod_length / 2, 0, 0),
        parent=crank,
        at=(crank_length, 0, 0),
        joint=Revolute("z"),
    )
    slider = scene.add_rigid_body("slider", 2.0, at=(crank_length + rod_length, 0, 0), joint=Prismatic("x"))
    scene.add_loop_joint("pin", Revolute("z"), rod.frame(at=(rod_length, 0, 0)), slider)
    scene.add_motor(crank, 2.0)
    model = scene.freeze()
    states = states_at(model, reference.values["T"], 1e-11)
    angle, place = (int(model.bodies[model.index(name)].coordinates[0]) for name in ("crank", "slider"))
    for name, column, expected in (
        ("crank angle [rad]", [q[angle] for _, q, _ in states], "theta"),
        ("crank rate [rad/s]", [u[angle] for _, _, u in states], "omega"),
        ("slider [m]", [crank_length + rod_length + q[place] for _, q, _ in states], "slider"),
    ):
        yield Check.absolute(f"{name} at t = 0.25 ... 2 s", column, reference.values[expected], 1e-7)


CASES = (Case("A02", n_four_bar), Case("A05", squeezing_mechanism), Case("A08", slider_crank))
