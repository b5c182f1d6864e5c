"""The rotor of two discs of Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), example 5.9.1."""

from __future__ import annotations

from functools import cache

import numpy as np

import kanefe as kf
from kanefe_fem import Material, SolidCircle
from kanefe_fem.beams.body import beam_body, beam_model

DIMENSIONS = {
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
"""SI units; discs by the node and the outer diameter, with a bore of the shaft's diameter; bearings at both ends."""

PUBLISHED = (85.389467, 87.7958637, 251.78460413, 294.71333087, 600.17936195, 827.07536193)
"""Whirl at 4000 rpm, rad/s, from the documents of ross-rotordynamics for this example, of six elements."""

PLACES = {"left": 0, "one": 2, "two": 4, "right": 6}


@cache
def _shaft() -> kf.FlexibleBody:
    E, G, rho = DIMENSIONS["E"], DIMENSIONS["G"], DIMENSIONS["rho"]
    x = np.linspace(0.0, DIMENSIONS["length"], DIMENSIONS["elements"] + 1)
    model = beam_model(
        np.column_stack((x, 0 * x, 0 * x)),
        [(i, i + 1) for i in range(DIMENSIONS["elements"])],
        SolidCircle(DIMENSIONS["diameter"]),
        Material(E=E, nu=E / (2.0 * G) - 1.0, rho=rho),
        groups=PLACES,
    )
    return beam_body(model, dict.fromkeys(PLACES, "rigid"), kf.CraigBampton(modes=12), stiffening="full")


def rotor_of_two_discs(speed: float) -> kf.System:
    """Return the rotor in a frame that spins with it at a speed (rad/s)."""
    scene = kf.System()
    turning = scene.add_frame("turning", joint=kf.Revolute("x", motion=kf.Motion.steady(speed)))
    shaft = scene.add_flexible_body("shaft", _shaft(), parent=turning, joint=kf.Free())
    bore, width, rho = DIMENSIONS["diameter"], DIMENSIONS["width"], DIMENSIONS["rho"]
    for (_, outer), name in zip(DIMENSIONS["discs"], ("one", "two"), strict=True):
        mass = rho * np.pi * width * (outer**2 - bore**2) / 4.0
        along, across = mass * (outer**2 + bore**2) / 8.0, mass * (3.0 * (outer**2 + bore**2) / 4.0 + width**2) / 12.0
        scene.add_rigid_body(f"disc {name}", mass, (along, across, across), parent=shaft.interface(name))
    for name, at in (("left", 0.0), ("right", DIMENSIONS["length"])):
        ends = (scene.ground.frame(at=(at, 0, 0)), shaft.interface(name))
        scene.add(kf.Bearing(name, ends, DIMENSIONS["stiffness"] * np.eye(2)))
    return scene


def seen_from_the_ground(modes: kf.Modes, speed: float) -> np.ndarray:
    """Return the frequencies that modes of the spinning frame may have there, rad/s."""
    rates = modes.eigenvalues.imag
    return np.abs(np.concatenate((rates - speed, rates + speed)))
