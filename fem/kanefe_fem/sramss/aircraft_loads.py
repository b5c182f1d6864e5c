"""Loads on the helicopter: rotors, wind, a haul-down cable. All numbers are assumed.

Axes of aircraft and deck: x forward, y to port, z up; the airframe's origin is its centre of mass.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.loads import Aerodynamics, PeriodicLoad, Winch, Wind
from kanefe.scene.scene import Frame
from kanefe.system import System

MAIN_HUB, MAIN_RATE, MAIN_BLADES = (0.0, 0.0, 1.6), 40.0, 4
"""Main rotor: position of the hub from the centre of mass, m; speed, rad/s, anticlockwise seen from above; number of
blades."""

TORQUE_ARM = 0.35
"""Torque of the main rotor divided by its thrust, m."""

BLADE_SHARE, TRACK_SHARE = 0.03, 0.01
"""Amplitudes of harmonics as fractions of the thrust: at the blade-passing frequency along z, and at the frequency of
rotation in the plane of the rotor, due to blades out of track."""

TAIL_HUB, TAIL_GEAR, TAIL_BLADES = (-5.6, 0.0, 0.9), 5.25, 2
"""Tail rotor: position of the hub from the centre of mass, m; speed relative to that of the main rotor; number of
blades."""

FUSELAGE = np.array((0.0, 0.0, 0.3))
"""Reference point of the wind forces, from the centre of mass, m."""

LENGTH, FRONT, SIDE, FLAT, LIFT = 6.0, 1.2, 5.0, 4.5, 0.5
"""Fuselage: length, m; drag areas along x, across and along z, and largest lift area, m2."""

YAW_SHARE = 0.12
"""Distance of the side force behind the centre of mass in wind from ahead, relative to the length."""


def add_rotors(scene: System, thrust: float, *, rate: float = MAIN_RATE, share: Any = None) -> None:
    """Add the thrust and torque of the main rotor and the thrust of the tail rotor, with their harmonics.

    The loads are named "main rotor" and "tail rotor". At full speed the frequency of rotation of the main rotor is 6.4
    Hz and its blade-passing frequency 25 Hz; the airframe rolls on its gear at about 7 Hz.

    Parameters
    ----------
    scene : System
        Scene with a body "airframe", as made by `spatial_scene` and `wheeled_scene`.
    thrust : float
        Thrust of the main rotor along the airframe's z, N.
    rate : float
        Angular velocity of the main rotor, rad/s; that of the tail rotor is proportional to it.
    share : (times, values), optional
        Factor on the loads as a function of time: see `kanefe.PeriodicLoad`.
    """
    airframe = scene.body("airframe")
    torque = TORQUE_ARM * thrust
    mean = (0.0, 0.0, thrust, 0.0, 0.0, -torque)
    shakes: dict[int, Any] = {
        1: ((TRACK_SHARE * thrust, 0, 0, 0, 0, 0), (0, TRACK_SHARE * thrust, 0, 0, 0, 0)),
        MAIN_BLADES: ((0, 0, BLADE_SHARE * thrust, 0, 0, 0), np.zeros(6)),
    }
    scene.add(PeriodicLoad("main rotor", airframe.frame(MAIN_HUB), rate, mean, shakes, share=share))
    push = torque / TAIL_HUB[0]  # moment about z = arm along x times force along y
    shakes = {TAIL_BLADES: ((0, BLADE_SHARE * push, 0, 0, 0, 0), np.zeros(6))}
    mean = (0.0, push, 0.0, 0.0, 0.0, 0.0)
    scene.add(PeriodicLoad("tail rotor", airframe.frame(TAIL_HUB), TAIL_GEAR * rate, mean, shakes, share=share))


def fuselage_areas(count: int = 13) -> tuple[np.ndarray, np.ndarray]:
    """Return angles of the wind from ahead (0) through port to astern (pi), rad, and the areas there, m2 and m3.

    They give drag and side force of a slender body, a lift that is largest abeam, and a yawing moment that turns the
    tail downwind.
    """
    angles = np.linspace(0.0, math.pi, count)
    along, across = np.cos(angles), np.sin(angles)
    areas = np.zeros((count, 6))
    areas[:, 0], areas[:, 1], areas[:, 2] = -FRONT * along, -SIDE * across, LIFT * across**2
    areas[:, 5] = YAW_SHARE * LENGTH * SIDE * across * along
    return angles, areas


def add_wind(scene: System, wind: Wind) -> None:
    """Add the wind on the fuselage as a load "fuselage".

    Parameters
    ----------
    scene : System
        Scene with a body "airframe".
    wind : Wind
        Wind relative to the deck: on a ship under way, the apparent wind.
    """
    angles, areas = fuselage_areas()
    at = scene.body("airframe").frame(tuple(FUSELAGE))
    scene.add(Aerodynamics("fuselage", at, wind, angles=angles, areas=areas, is_symmetric=True, flat_area=FLAT))


PROBE = (0.0, 0.0, -0.9)
"""Point of the airframe that the cable holds, from its centre of mass, m."""

CABLE_STIFFNESS, CABLE_DAMPING, CABLE_SPEED, CABLE_BELOW = 4e5, 800.0, 3.0, 2.0
"""Cable: stiffness, N/m; damping, N s/m; speed, m/s; and depth of the winch below the deck, m."""


def add_haul_down(
    scene: System, tension: Any, *, at: tuple[float, float] = (0.0, 0.0), breaking_load: float | None = None
) -> None:
    """Add a cable from a winch below the deck through a hole in it to the airframe, as a load "haul-down".

    Parameters
    ----------
    scene : System
        Scene with a body "airframe"; the deck is a body "deck" or the ground.
    tension : float or (times, tensions)
        Tension that the winch holds, N: see `kanefe.Winch`.
    at : (float, float)
        x and y of the hole on the deck, m.
    breaking_load : float, optional
        Breaking load of the cable, N.
    """
    deck = deck_of(scene)
    way = deck.frame((*at, -CABLE_BELOW)), deck.frame((*at, 0.0)), scene.body("airframe").frame(PROBE)
    cable = {"stiffness": CABLE_STIFFNESS, "damping": CABLE_DAMPING, "speed": CABLE_SPEED}
    scene.add(Winch("haul-down", way, tension=tension, breaking_load=breaking_load, **cable))


def deck_of(scene: System) -> Frame:
    """Return the deck of a scene, the ground if it does not move."""
    try:
        return scene.body("deck")
    except ModelError:
        return scene.ground
