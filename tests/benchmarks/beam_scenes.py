"""Our side of the races of exact beams: scenes, and what the peer is asked for."""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

import kanefe as kf
import kanefe_fem as fem
from kanefe.equations.model import Model
from kanefe_fem.verification.exact_motion import flying, right_angle, section_place

LENGTH = 10.0

FLYING = {"length": LENGTH, "EA": 1e4, "GA": 1e4, "EI": 500.0, "rho_A": 1.0, "rho_I": 10.0}
ANGLED = {"length": LENGTH, "EA": 1e6, "GA": 1e6, "EI": 1e3, "GJ": 1e3, "rho_A": 1.0, "rho_I": 10.0}
SLEWED = {"length": LENGTH, "EA": 1e4, "GA": 1e4, "EI": 1e3, "rho_A": 1.0, "rho_I": 1.0}
ANGLE, RAMP = 1.5, 2.5  # rad, s

ASKED: dict[str, dict[str, Any]] = {
    "flying": {
        "section": FLYING,
        "start": [6.0, 0.0],
        "along": math.atan2(8.0, -6.0),
        "force": 8.0,
        "torque": -80.0,
        "loaded": 2.5,
    },
    "right angle": {"section": ANGLED, "force": 50.0},
    "slewing": {"section": SLEWED, "angle": ANGLE, "ramp": RAMP},
}
"""Arguments of the peer's scenes."""

ENDS = {"flying": 5.0, "right angle": 10.0, "slewing": 5.0}
"""Time at which places are compared, s."""


def slewing(functions: int) -> Model:
    """Return a beam whose root is turned by 1.5 rad within 2.5 s (Simo and Vu-Quoc 1986), here without a kink."""

    def turn(t: float) -> float:
        x = min(t / RAMP, 1.0)
        return ANGLE * x**3 * (10.0 - 15.0 * x + 6.0 * x * x)

    def rate(t: float) -> float:
        x = min(t / RAMP, 1.0)
        return ANGLE / RAMP * 30.0 * x * x * (1.0 - x) ** 2

    def acceleration(t: float) -> float:
        x = min(t / RAMP, 1.0)
        return ANGLE / RAMP**2 * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)

    of = SLEWED
    section = fem.Section.from_stiffness(
        EA=of["EA"], GA_y=of["GA"], EI_z=of["EI"], rho_A=of["rho_A"], rho_I=of["rho_I"]
    )
    beam = fem.exact_beam(LENGTH, section, theory="shear-deformable", planar=True, basis=functions)
    scene = kf.System()
    scene.add_flexible_body("beam", beam, joint=kf.Revolute("z", motion=kf.Motion(turn, rate, acceleration).compiled()))
    return scene.freeze()


SCENES = {
    "flying": (lambda n: flying(n, numba.njit), (("beam", "root"), ("beam", "tip"))),
    "right angle": (lambda n: right_angle(n, max(n - 2, 2), numba.njit), (("first", "tip"), ("second", "tip"))),
    "slewing": (slewing, (("beam", "tip"),)),
}
"""Scenes by the number of their functions, with compiled loads and motions, and the places that are compared."""


def places(name: str, model: Model, q: np.ndarray) -> np.ndarray:
    """Return the places that are compared, from coordinates at the end."""
    state = ENDS[name], q, np.zeros(model.free_count)
    return np.concatenate([section_place(model, body, end, state) for body, end in SCENES[name][1]])
