"""A helicopter on wheels: three legs with oleo struts and tyres, on a deck that moves. All parameters are assumed.

Axes of aircraft and deck: x forward, y to port, z up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kanefe.contact import Coulomb, KelvinVoigt
from kanefe.contact.shapes import Box, Plane, Sphere, Torus
from kanefe.contact.surface import Surface
from kanefe.joints import CoordinateForce, Free, Prismatic, Revolute
from kanefe.joints.given_pose import GivenPose
from kanefe.loads import Oleo
from kanefe.scene.scene import Frame
from kanefe.system import System
from kanefe_fem.sramss import parameters as given
from kanefe_fem.sramss.spatial import INERTIA, started_on


class Leg(NamedTuple):
    """A leg: position (x and y, m), piston (m2), gas at full extension (m3), oil (N s2/m2) and brake (N m)."""

    x: float
    y: float
    area: float
    volume: float
    compression: float
    rebound: float
    brake: float


LEGS = {
    "nose": Leg(1.9, 0.0, 1.4e-3, 4.0e-4, 1200.0, 4000.0, 0.0),
    "starboard": Leg(-0.5, -1.1, 2.5e-3, 7.2e-4, 2500.0, 8000.0, 1500.0),
    "port": Leg(-0.5, 1.1, 2.5e-3, 7.2e-4, 2500.0, 8000.0, 1500.0),
}

PRESSURE, EXPONENT = 7e5, 1.3
"""Absolute pressure of the gas at full extension, Pa, and its polytropic exponent."""

STROKE, STOP_STIFFNESS, STOP_DAMPING = 0.24, 1e7, 1e4
"""Stroke, m; stiffness (N/m) and damping (N s/m) of the stops at both ends."""

SEAL_FRICTION = 150.0
"""Seal friction of a strut, N."""

PISTON_MASS, WHEEL_MASS, WHEEL_INERTIA = 12.0, 8.0, (0.1, 0.18, 0.1)
"""Masses of piston and wheel, kg; principal inertias of the wheel, kg m2."""

RING, TUBE = 0.15, 0.07
"""Radii of a tyre: circle of centres, and cross-section, m."""

TYRE_STIFFNESS, TYRE_DAMPING, GRIP_STIFFNESS, GRIP_DAMPING = 3.5e5, 1500.0, 3e5, 1e3
"""Vertical stiffness and damping of a tyre, and those of its tread along and across, N/m and N s/m."""

CYLINDER = 0.9
"""Distance from the axle to the fastening of the extended strut in the airframe, m."""

CHOCK, CHOCK_GAP = (0.10, 0.30, 0.12), 2e-3
"""Length, breadth and height of a chock, and its gap to the tyre, m."""


def wheeled_scene(
    motion: GivenPose | None = None,
    *,
    mu: float = 0.6,
    at: tuple[float, float] = (0.0, 0.0),
    height: float = 0.0,
    sink: float = 0.0,
    lift: float = 0.0,
    brakes: bool = True,
    chocks: bool = False,
) -> System:
    """Return the aircraft on three wheels, with its struts extended and its tyres touching the deck.

    The bodies are "airframe", "nose piston", "nose wheel" and so on, the loads "nose oleo" and so on, the contacts
    "nose tyre" and so on, and with chocks "port chock aft" and so on. The wheels do not swivel.

    Parameters
    ----------
    motion : GivenPose, optional
        Motion of the deck: `kanefe.PoseTable`, or the motion of a ship. Default: none.
    mu : float
        Coefficient of friction of tyres on the deck and on chocks.
    at : (float, float)
        x and y of the aircraft on the deck, m.
    height, sink : float
        Initial height of the tyres above the deck, m, and speed towards it, m/s.
    lift : float
        Lift of the rotor along the airframe's z, N.
    brakes : bool
        Whether the brakes of the main wheels are set.
    chocks : bool
        Whether there are chocks in front of and behind the main wheels.
    """
    scene = System(gravity=(0.0, 0.0, -given.GRAVITY))
    deck = scene.add_frame("deck", joint=Free(motion=motion)) if motion is not None else scene.ground
    place = np.array((*at, given.CG_HEIGHT + height))
    airframe = scene.add_rigid_body("airframe", given.AIRFRAME_MASS, INERTIA, joint=started_on(motion, place, sink))
    surface = scene.add_surface("deck", deck, Plane("z"))
    for name, leg in LEGS.items():
        wheel = _add_leg(scene, name, leg, airframe, surface, mu, brakes)
        if chocks and leg.brake:
            _add_chocks(scene, name, leg, wheel, deck, at, mu)
    if lift:
        scene.add_force(airframe, (0.0, 0.0, lift), follows=True)
    return scene


def _add_leg(scene: System, name: str, leg: Leg, airframe: Frame, surface: Surface, mu: float, brakes: bool) -> Frame:
    """Add piston, wheel, oleo strut and tyre of a leg; return the wheel."""
    axle = (leg.x, leg.y, RING + TUBE - given.CG_HEIGHT)
    ends = CoordinateForce(
        limits=(0.0, STROKE), limit_stiffness=STOP_STIFFNESS, limit_damping=STOP_DAMPING, friction=SEAL_FRICTION
    )
    piston = scene.add_rigid_body(
        f"{name} piston",
        PISTON_MASS,
        PISTON_MASS * np.array((0.1, 0.1, 0.01)),
        parent=airframe,
        at=axle,
        joint=Prismatic("z", forces=ends),
    )
    top = (axle[0], axle[1], axle[2] + CYLINDER)
    gas = {"area": leg.area, "volume": leg.volume, "pressure": PRESSURE, "exponent": EXPONENT}
    oil = {"orifice": leg.compression, "rebound": leg.rebound}
    scene.add(Oleo(f"{name} oleo", (airframe.frame(top), piston), extended=CYLINDER, **gas, **oil))
    brake = CoordinateForce(friction=leg.brake) if brakes and leg.brake else None
    wheel = scene.add_rigid_body(
        f"{name} wheel", WHEEL_MASS, WHEEL_INERTIA, parent=piston, joint=Revolute("y", forces=brake)
    )
    tyre = scene.add_surface(f"{name} tyre", wheel, Torus(RING, TUBE, axis="y"))
    grip = Coulomb(mu, stiffness=GRIP_STIFFNESS, damping=GRIP_DAMPING)
    scene.add_contact(f"{name} tyre", tyre, surface, normal=KelvinVoigt(TYRE_STIFFNESS, TYRE_DAMPING), friction=grip)
    return wheel


def _add_chocks(
    scene: System, name: str, leg: Leg, wheel: Frame, deck: Frame, at: tuple[float, float], mu: float
) -> None:
    """Add boxes on the deck in front of and behind a wheel, in contact with a sphere of the tyre's outer radius."""
    length, _, height = CHOCK
    radius = RING + TUBE
    # distance of the box at which its edge has the gap CHOCK_GAP to the tyre
    away = math.sqrt(radius**2 - (radius - height) ** 2) + CHOCK_GAP + 0.5 * length
    ball = scene.add_surface(f"{name} ball", wheel, Sphere(radius))
    for where, sign in (("aft", -1.0), ("forward", 1.0)):
        place = (at[0] + leg.x + sign * away, at[1] + leg.y, 0.5 * height)
        box = scene.add_surface(f"{name} chock {where}", deck, Box(CHOCK), at=place)
        scene.add_contact(
            f"{name} chock {where}",
            ball,
            box,
            normal=KelvinVoigt(TYRE_STIFFNESS, TYRE_DAMPING),
            friction=Coulomb(mu, stiffness=GRIP_STIFFNESS, damping=GRIP_DAMPING),
        )
