"""Shells that their loads stiffen or buckle, in scenes: rotating plate and blade, critical loads, SH23 to SH25."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
import scipy.linalg

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.places import InBox, OnPlane
from kanefe.joints import Motion, Revolute
from kanefe.linear.equilibrium.equilibria import equilibrium
from kanefe.linear.stability.buckling_modes import buckling
from kanefe.reduction import CraigBampton
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.surface_grid import joined_surfaces, surface_mesh
from kanefe_fem.shells.body import shell_body
from kanefe_fem.shells.faces import ShellFace

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


def buckling_in_scenes(reference: Reference) -> Iterator[Check]:
    """SH24: critical loads of a plate, of strips and of a cylinder by `kanefe.buckling`."""
    value = reference.values
    yield Check.relative("b^2 N/(pi^2 D), plate", critical_loads_of_plate(), np.asarray(value["plate"]), 5e-3)
    metal = Material(E=70e9, nu=0.0, rho=2700.0)
    mesh = surface_mesh(lambda s, r: (s, 0.0 * s, 0.05 * (r - 0.5)), (24, 2))
    held = {"root": "clamped", "tip": "average"}
    strip = shell_body(mesh, metal, held, 5e-4, CraigBampton(modes=16), stiffening="full")
    scene = System()
    scene.add_force(scene.add_flexible_body("strip", strip).interface("tip"), (0.0, 0.0, -1.0))
    yield Check.relative("P of a strip that tips [N]", buckling(scene).factors[0], value["tipping"], 2e-3)
    mesh = surface_mesh(lambda s, r: (0.5 * s, 0.05 * (r - 0.5), 0.0 * s), (8, 2))
    held = {"root": "clamped", "tip": "rigid"}
    half = shell_body(mesh, metal, held, 2e-3, CraigBampton(modes=6), stiffening="full")
    scene = System()
    first = scene.add_flexible_body("first", half)
    second = scene.add_flexible_body("second", half, parent=first.interface("tip"))
    scene.add_force(second.interface("tip"), (-1.0, 0.0, 0.0))
    euler = np.pi**2 * 70e9 * 0.05 * 2e-3**3 / 12.0 / 4.0
    found = buckling(scene).factors[:3] / euler
    yield Check.relative("P over Euler's, strip in two bodies", found, np.asarray(value["euler"]), 2e-3)
    yield Check.relative("N R sqrt(3)/(E t^2), cylinder", critical_load_of_cylinder(), value["cylinder"], 2e-3)


def critical_loads_of_plate() -> np.ndarray:
    """Return the lowest three critical loads of a thin square plate on simple supports, over pi^2 D / a^2."""
    t = 1e-3

    def sides(x: np.ndarray) -> np.ndarray:
        return np.asarray((np.abs(x[:, :2] - 0.5) > 0.5 - 1e-9).any(axis=1))

    held = {
        "sides": Interface(("z", "rx", "ry"), released=("x", "y", "rx", "ry", "rz"), at=sides),
        "middle": Interface(("x", "y", "rz"), kind="average", at=InBox((0.3125, 0.3125, -1.0), (0.6875, 0.6875, 1.0))),
    }
    mesh = surface_mesh(lambda s, r: (s, r, 0.0 * s), (16, 16))
    statics = CraigBampton(modes=16, loads=("tip", "root"))
    metal = Material(E=70e9, nu=0.3, rho=2700.0)
    plate = shell_body(mesh, metal, held, t, statics, stiffening="full", surfaces=["tip", "root"])
    scene = System()
    body = scene.add_flexible_body("plate", plate)
    scene.add_line_load(body, "tip", (-1.0, 0.0, 0.0))
    scene.add_line_load(body, "root", (1.0, 0.0, 0.0))
    return buckling(scene).factors[:3] / (np.pi**2 * 70e9 * t**3 / 12.0 / (1.0 - 0.3**2))


def critical_load_of_cylinder() -> float:
    """Return the critical load of a cylinder between rigid rings on which it turns, over that of thin shells."""
    t = 0.01
    length = 2.0 * np.pi * np.sqrt(t) / 12.0**0.25

    def quarter(number: int) -> Mesh:
        return surface_mesh(
            lambda s, r: (np.cos((s + number) * np.pi / 2.0), np.sin((s + number) * np.pi / 2.0), length * r), (6, 6)
        )

    held = {
        "low": Interface("all", released=("rx", "ry", "rz"), at=OnPlane((0, 0, 0), (0, 0, 1))),
        "top": Interface(("x", "y", "rx", "ry", "rz"), released=("rx", "ry"), at=OnPlane((0, 0, length), (0, 0, 1))),
    }
    metal = Material(E=70e9, nu=0.0, rho=2700.0)
    tube = shell_body(
        joined_surfaces([quarter(number) for number in range(4)]),
        metal,
        held,
        t,
        CraigBampton(modes=60),
        stiffening="full",
    )
    scene = System()
    scene.add_force(scene.add_flexible_body("tube", tube).interface("top"), (0.0, 0.0, -2.0 * np.pi))
    return float(buckling(scene, count=1).factors[0] / (70e9 * t**2 / np.sqrt(3.0)))


def following_pressure(reference: Reference) -> Iterator[Check]:
    """SH25: a long tube that an outside pressure buckles, one that follows its surface and one of fixed directions."""
    t = 0.01
    whole, bare = (tube_under_pressure(8, t, "middle", level) for level in ("full", "none"))
    scene = System()
    scene.add_pressure(scene.add_flexible_body("tube", whole), "wall", 1.0, follows=True)
    unit = 70e9 * t**3 / 12.0
    expected = np.asarray(reference.values["follows"])
    yield Check.relative("p R^3/EI, follows", buckling(scene, count=4).factors / unit, expected, 2e-3)
    change, of_face = (np.asarray(body.load_pattern("wall").pressure_change) for body in (whole, bare))
    k, by_stress = whole.free_count, change - of_face
    factors = 1.0 / scipy.linalg.eigvalsh(by_stress[6 : 6 + k, :k], whole.stiffness[:k, :k])[: -len(expected) - 1 : -1]
    yield Check.relative("p R^3/EI, fixed directions", factors / unit, reference.values["fixed"], 2e-3)


def tube_under_pressure(
    cells: int, t: float, side: Literal["top", "middle", "bottom"], stiffening: StiffeningLevel = "full"
) -> FlexibleBody:
    """Return a part of a long tube of radius 1 m, `cells` a quarter, with a face "wall": its rims stay in planes."""

    def quarter(number: int) -> Mesh:
        return surface_mesh(
            lambda s, r: (np.cos((s + number) * np.pi / 2.0), np.sin((s + number) * np.pi / 2.0), 0.2 * r - 0.1),
            (cells, 2),
        )

    in_plane, free = ("z", "rx", "ry"), ("x", "y", "rz")
    held = {
        "low": Interface(in_plane, released=free, at=OnPlane((0, 0, -0.1), (0, 0, 1))),
        "top": Interface(in_plane, released=free, at=OnPlane((0, 0, 0.1), (0, 0, 1))),
        "middle": Interface(("x", "y", "rz"), kind="average", at=OnPlane((0, 0, 0), (0, 0, 1))),
    }
    return shell_body(
        joined_surfaces([quarter(number) for number in range(4)]),
        Material(E=70e9, nu=0.0, rho=2700.0),
        held,
        t,
        CraigBampton(modes=12, loads=("wall",)),
        stiffening=stiffening,
        surfaces={"wall": ShellFace(side)},
    )


CASES = (Case("SH23", spinning), Case("SH24", buckling_in_scenes), Case("SH25", following_pressure))
