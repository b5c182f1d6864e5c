"""The rotor of two discs of Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), example 5.9.1."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.joints import Free, Motion, Revolute
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.modes.modes import Modes
from kanefe.loads import Bearing
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, beam_model
from kanefe_fem.beams.sections import SolidCircle
from kanefe_fem.materials.isotropic import Material

DIMENSIONS: dict[str, Any] = {
    "E": 211e9,
    "G": 81.2e9,
    "rho": 7810.0,
    "length": 1.5,
    "diameter": 0.05,
    "elements": 6,
    "width": 0.07,
    "discs": ((2, 0.28), (4, 0.35)),
    "stiffness": 1e6,
}
"""Parameters in SI units; discs by node and outer diameter, with the shaft's diameter as bore; bearings at both ends.
"""

PLACES = {"left": 0, "one": 2, "two": 4, "right": 6}


@cache
def _shaft() -> FlexibleBody:
    E, G, rho = DIMENSIONS["E"], DIMENSIONS["G"], DIMENSIONS["rho"]
    x = np.linspace(0.0, DIMENSIONS["length"], DIMENSIONS["elements"] + 1)
    model = beam_model(
        np.column_stack((x, 0 * x, 0 * x)),
        [(i, i + 1) for i in range(DIMENSIONS["elements"])],
        SolidCircle(DIMENSIONS["diameter"]),
        Material(E=E, nu=E / (2.0 * G) - 1.0, rho=rho),
        groups=PLACES,
    )
    return beam_body(model, dict.fromkeys(PLACES, "rigid"), CraigBampton(modes=12), stiffening="full")


def rotor_of_two_discs(speed: float) -> System:
    """Return the rotor in a frame that spins with it at a speed (rad/s)."""
    scene = System()
    turning = scene.add_frame("turning", joint=Revolute("x", motion=Motion.steady(speed)))
    shaft = scene.add_flexible_body("shaft", _shaft(), parent=turning, joint=Free())
    bore, width, rho = DIMENSIONS["diameter"], DIMENSIONS["width"], DIMENSIONS["rho"]
    for (_, outer), name in zip(DIMENSIONS["discs"], ("one", "two"), strict=True):
        mass = rho * np.pi * width * (outer**2 - bore**2) / 4.0
        along, across = mass * (outer**2 + bore**2) / 8.0, mass * (3.0 * (outer**2 + bore**2) / 4.0 + width**2) / 12.0
        scene.add_rigid_body(f"disc {name}", mass, (along, across, across), parent=shaft.interface(name))
    for name, at in (("left", 0.0), ("right", DIMENSIONS["length"])):
        ends = (scene.ground.frame(at=(at, 0, 0)), shaft.interface(name))
        scene.add(Bearing(name, ends, DIMENSIONS["stiffness"] * np.eye(2)))
    return scene


def seen_from_the_ground(modes: Modes, speed: float) -> np.ndarray:
    """Return the possible frequencies in the fixed frame of modes of the spinning frame, rad/s."""
    rates = modes.eigenvalues.imag
    return np.abs(np.concatenate((rates - speed, rates + speed)))


def two_discs(reference: Reference) -> Iterator[Check]:
    """R04: whirl of two discs on a flexible shaft, against published values."""
    speed = 4000.0 * np.pi / 30.0
    balance = equilibrium(rotor_of_two_discs(speed))
    seen = seen_from_the_ground(balance.linearise(inputs=(), outputs=()).modes(), speed)
    published = np.array(reference.values["whirl"])
    found = seen[np.abs(seen[:, None] - published).argmin(axis=0)]
    yield Check.relative("whirl at 4000 rpm, six beams [rad/s]", found, published, 1e-4)


CASES = (Case("R04", two_discs),)
