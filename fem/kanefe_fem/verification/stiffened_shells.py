"""Shells that their loads stiffen or buckle, in scenes: rotating plates and blades, SH23."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.joints import Motion, Revolute
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.surface_grid import surface_mesh
from kanefe_fem.shells.body import shell_body

SPIN = CraigBampton(modes=16, loads=("centrifugal",))


def frequencies_at(body: FlexibleBody, speed: float, count: int = 4) -> np.ndarray:
    """Return the lowest frequencies of a body that spins about z at its root, in the frame that spins with it, Hz."""
    scene = System()
    scene.add_flexible_body("blade", body, joint=Revolute("z", motion=Motion.steady(speed)))
    return equilibrium(scene).linearise().modes().frequencies[:count]


def spinning(reference: Reference) -> Iterator[Check]:
    """SH23: the plate of SH8 as a body of 16 modes, and a curved fan blade beside its solid."""
    t = 0.01
    mesh = surface_mesh(lambda s, r: (s, r - 0.5, 0.0 * s), (16, 16))
    plate = shell_body(mesh, Material(E=1.0, nu=0.3, rho=1.0), {"root": "clamped"}, t, SPIN, stiffening="inertial")
    scale = np.sqrt(t * 12.0 * (1.0 - 0.3**2) / t**3)
    for gamma, expected in reference.values["plate"].items():
        found = 2.0 * np.pi * scale * frequencies_at(plate, float(gamma) / scale)
        yield Check.relative(f"lambda 1-4, plate, gamma {gamma}", found, expected, 5e-4)
    fan = fan_blade()
    for speed, expected in reference.values["blade"].items():
        found = frequencies_at(fan, float(speed))
        yield Check.relative(f"f 1-4, blade at {speed} rad/s [Hz]", found, expected, 1e-3)


def fan_blade() -> FlexibleBody:
    """Return a blade of sheet metal, a part of a cylinder about an axis along it."""
    chord, radius, pitch = 0.10, 0.15, np.radians(5.0)

    def place(s: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
        angle = (r - 0.5) * chord / radius
        across, up = radius * np.sin(angle), radius * (np.cos(angle) - 1.0)
        return (
            0.08 + 0.3 * s,
            np.cos(pitch) * across - np.sin(pitch) * up,
            np.sin(pitch) * across + np.cos(pitch) * up,
        )

    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    return shell_body(surface_mesh(place, (28, 12)), steel, {"root": "clamped"}, 3e-3, SPIN, stiffening="inertial")


CASES = (Case("SH23", spinning),)
