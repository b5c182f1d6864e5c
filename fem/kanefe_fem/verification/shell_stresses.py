"""Stresses, section forces, pressures and critical loads of shells, SH12 to SH16, against closed forms."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np
import scipy.sparse.linalg as spla

from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.model import Elasticity, StressStiffness
from kanefe.fe_model.shell_stack import ShellStack
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.laminate import Laminate, Ply
from kanefe_fem.materials.orthotropic import Orthotropic
from kanefe_fem.mesh.surface_grid import surface_mesh
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_forces import shell_forces
from kanefe_fem.recovery.shell_points import ShellStrains
from kanefe_fem.shells.body import shell_model
from kanefe_fem.shells.faces import ShellFace
from kanefe_fem.verification.shells import CELLS, Shell, along_line, at

ONE = np.ones((1, 1))


class Stressed:
    """A shell with a static displacement (n, 6)."""

    def __init__(self, one: Shell, u: np.ndarray) -> None:
        stack = cast(ShellStack, cast(Elasticity, one.model.elasticity).shell)
        self.strains = ShellStrains(one.x, u.reshape(-1, 1), one.model.cells, stack)

    def stress(self, face: str, ply: int | None = None) -> np.ndarray:
        """Return the stress at the nodes in the axes of the layer, shape (n, 6)."""
        return ShellStrainFields(self.strains, "shell", face, ply).in_layers("nodes", ONE)[0]

    def forces(self, along: tuple[float, float, float]) -> dict[str, np.ndarray]:
        """Return the section forces at the nodes."""
        found = shell_forces(ShellStrainFields(self.strains, "shell"), np.zeros(1), ONE, along)
        return {name: found[name][0] for name in ("N11", "N22", "M11", "M22", "M12", "Q1", "Q2")}


def relative(quantity: str, values: np.ndarray, expected: float | np.ndarray, limit: float) -> Check:
    """Compare values with one number, or with as many."""
    return Check.relative(quantity, values, np.broadcast_to(expected, np.shape(values)), limit)


def on_supports(one: Shell) -> None:
    """Hold the sides of a unit square simply, as in Navier's series."""
    x, y, _ = one.x.T
    across, beside = at(x, 0.0) | at(x, 1.0), at(y, 0.0) | at(y, 1.0)
    one.hold(across | beside, "z")
    one.hold(across, "y rx")
    one.hold(beside, "x ry")


def plate(reference: Reference) -> Iterator[Check]:
    """SH12: a simply supported square plate under a pressure on its top."""
    t = 0.01
    mesh = surface_mesh(lambda s, r: (s, r, 0.0 * s), (CELLS, CELLS))
    one = Shell(mesh, shell_model(mesh, Material(E=1e9, nu=0.3, rho=1.0), t, surfaces={"top": ShellFace("top")}))
    on_supports(one)
    pressure = np.asarray(one.model.load_patterns["top"].pressure).reshape(-1, 6)
    found = Stressed(one, one.displaced(pressure))
    x, y, _ = one.x.T
    middle, corner = at(x, 0.5) & at(y, 0.5), at(x, 0.0) & at(y, 0.0)
    side = at(x, 0.0) & at(y, 0.5)
    forces, value = found.forces((1.0, 0.0, 0.0)), reference.values
    yield relative("M11 in the middle / q a^2", -forces["M11"][middle], value["M11"], 5e-3)
    yield relative("M12 at a corner / q a^2", np.abs(forces["M12"][corner]), value["M12"], 2e-2)
    yield relative("Q1 at a side / q a", np.abs(forces["Q1"][side]), value["Q1"], 1e-2)
    expected = 6.0 * value["M11"] / t**2
    for face, sign in (("top", -1.0), ("bottom", 1.0)):
        yield relative(f"stress 11 at the {face} / q", found.stress(face)[middle, 0], sign * expected, 5e-3)
    shear = np.abs(found.stress("middle")[side, 4])
    yield relative("shear stress 13 in the middle / q", shear, 1.5 * value["Q1"] / t, 1e-2)


def graded(r: np.ndarray) -> np.ndarray:
    """Return places from 0 to 1, with cells that are smaller near 0."""
    ends = np.linspace(0.0, 1.0, 2 * CELLS + 1)
    return np.interp(r, ends, ends**1.5)


def tank(reference: Reference) -> Iterator[Check]:
    """SH13: a cylinder under internal pressure, free to grow and clamped at one end, a quarter of it."""
    radius, length = 1.0, 1.0
    for t in (0.1, 0.01):
        mesh = surface_mesh(
            lambda s, r: (radius * np.cos(s * np.pi / 2.0), radius * np.sin(s * np.pi / 2.0), length * graded(r)),
            (CELLS // 2, 2 * CELLS),
        )
        model = shell_model(mesh, Material(E=1e9, nu=0.3, rho=1.0), t, surfaces={"inside": ShellFace("bottom")})
        one = Shell(mesh, model)
        x, y, z = one.x.T
        one.hold(np.abs(x) < 1e-9, "x ry rz")
        one.hold(np.abs(y) < 1e-9, "y rx rz")
        one.hold(at(z, 0.0), "z")
        inside = radius - t / 2.0
        pressure = np.asarray(model.load_patterns["inside"].pressure).reshape(-1, 6)
        found = Stressed(one, one.displaced(pressure))
        forces = found.forces((0.0, 0.0, 1.0))
        yield relative(f"hoop force / p, R/t {radius / t:g}", forces["N22"], inside, 1e-2 if t == 0.1 else 2e-3)
        for face, r in (("bottom", inside), ("top", radius + t / 2.0)):
            lame = inside**2 / ((radius + t / 2.0) ** 2 - inside**2) * (1.0 + (radius + t / 2.0) ** 2 / r**2)
            hoop = ShellStrainFields(found.strains, "tank", face).scalar("max_principal", "nodes", ONE)[0]
            limit = reference.values["thick"] if t == 0.1 else reference.values["thin"]
            yield relative(f"hoop stress at the {face} / p, Lame, R/t {radius / t:g}", hoop, lame, limit)
    one.hold(at(z, 0.0), "x y z rx ry rz")
    found = Stressed(one, one.displaced(pressure))
    beta = (3.0 * (1.0 - 0.3**2)) ** 0.25 / np.sqrt(radius * t)
    clamped = np.abs(found.forces((0.0, 0.0, 1.0))["M11"][at(z, 0.0)])
    yield relative("moment at the clamp / p", clamped, 1.0 / (2.0 * beta**2), 2e-2)


def strip(reference: Reference) -> Iterator[Check]:
    """SH14: a cantilever under a force at its tip: bending stress, and a parabola of shear stress."""
    length, width, t = 1.0, 0.1, 0.02
    mesh = surface_mesh(lambda s, r: (length * s, width * r, 0.0 * s), (CELLS, 2))
    one = Shell(mesh, shell_model(mesh, Material(E=1e9, nu=0.0, rho=1.0), t))
    one.hold(at(one.x[:, 0], 0.0), "x y z rx ry rz")
    tip, weights = along_line(one, "tip")
    force = np.zeros((len(one.x), 6))
    force[tip, 2] = weights
    found = Stressed(one, one.displaced(force))
    x = one.x[:, 0]
    bending = 6.0 * (length - x) / (width * t**2)
    error = np.abs(found.stress("bottom")[:, 0] - bending).max() / bending.max()
    yield Check.absolute("bending stress along the strip, error over the largest", error, 0.0, 2e-3)
    shear = found.stress("middle")[:, 4]
    yield relative("shear stress in the middle over Q / t", shear * width * t, reference.values["shear"], 1e-3)
    faces = np.abs(np.stack([found.stress(face)[:, 4] for face in ("top", "bottom")])).max() / shear.max()
    yield Check.absolute("shear stress at the faces over that", faces, 0.0, 1e-12)


def cross_ply(reference: Reference) -> Iterator[Check]:
    """SH15: stresses in the plies of 0/90/90/0 under a sine load, in their axes, in first-order theory."""
    ply = Orthotropic(E1=25.0, E2=1.0, E3=1.0, nu12=0.25, nu13=0.25, nu23=0.25, G12=0.5, G13=0.5, G23=0.2, rho=1.0)
    ratio, mesh = 10.0, surface_mesh(lambda s, r: (s, r, 0.0 * s), (CELLS, CELLS))
    t = 1.0 / ratio
    stack = Laminate([Ply(ply, t / 4.0, np.radians(angle)) for angle in (0, 90, 90, 0)])
    one = Shell(mesh, shell_model(mesh, stack, shear_factor=5.0 / 6.0))
    on_supports(one)
    x, y, _ = one.x.T
    sine = np.sin(np.pi * x) * np.sin(np.pi * y)
    force = np.zeros((len(x), 6))
    force[:, 2] = one.model.mass[2::6, 2::6] @ sine / t
    found = Stressed(one, one.displaced(force))
    middle, corner = at(x, 0.5) & at(y, 0.5), at(x, 0.0) & at(y, 0.0)
    for number, face in ((0, "bottom"), (0, "top"), (1, "bottom"), (3, "top")):
        expected = reference.values[f"{number} {face}"]
        stress = found.stress(face, number)[middle, :2].ravel() / ratio**2
        yield relative(f"stresses 11, 22 of ply {number}, {face}", stress, np.asarray(expected), 1e-2)
    twist = np.abs(found.stress("top", 3)[corner, 5]) / ratio**2
    yield relative("stress 12 at a corner", twist, reference.values["12"], 1e-2)
    shear = np.abs(found.forces((1.0, 0.0, 0.0))["Q1"])[at(x, 0.0) & at(y, 0.5)]
    yield relative("Q1 at a side / q a", shear, reference.values["Q1"], 1e-2)


def buckling(reference: Reference) -> Iterator[Check]:
    """SH16: critical loads of a plate under compression and under shear, and of a cylinder under axial compression."""
    E, nu, t = 70e9, 0.3, 0.01
    mesh = surface_mesh(lambda s, r: (s, r, 0.0 * s), (CELLS, CELLS))
    one = Shell(mesh, shell_model(mesh, Material(E=E, nu=nu, rho=2700.0), t))
    on_supports(one)
    x, y, _ = one.x.T
    one.fixed[:, :2] = False
    one.fixed[at(x, 0.0) & at(y, 0.0), :2] = True
    one.fixed[at(x, 1.0) & at(y, 0.0), 1] = True
    scale = np.pi**2 * E * t**3 / 12.0 / (1.0 - nu**2)
    pushed = on_lines(one, {"tip": (-1.0, 0.0, 0.0), "root": (1.0, 0.0, 0.0)})
    found = critical_loads(one, pushed, 3) / scale
    yield relative("b^2 N/(pi^2 D), compressed plate", found, np.asarray(reference.values["compression"]), 5e-3)
    sheared = {"tip": (0.0, 1.0, 0.0), "root": (0.0, -1.0, 0.0), "top": (1.0, 0.0, 0.0), "bottom": (-1.0, 0.0, 0.0)}
    found = critical_loads(one, on_lines(one, sheared), 1) / scale
    yield relative("b^2 N/(pi^2 D), sheared plate", found, reference.values["shear"], 5e-3)

    length = 2.0 * np.pi * np.sqrt(t) / 12.0**0.25  # two half waves of the symmetric shape, nu = 0
    mesh = surface_mesh(
        lambda s, r: (np.cos(s * np.pi / 2.0), np.sin(s * np.pi / 2.0), length * r), (CELLS, CELLS // 2)
    )
    one = Shell(mesh, shell_model(mesh, Material(E=E, nu=0.0, rho=2700.0), t))
    x, y, z = one.x.T
    one.hold(np.abs(y) < 1e-9, "y rx rz")
    one.hold(np.abs(x) < 1e-9, "x ry rz")
    one.hold(at(z, 0.0), "x y z rz")
    one.hold(at(z, length), "x y rz")
    # 1 for thin shells; shear takes 0.34 % of it, and the work of the stress on the stretch of bent fibres 0.29 %
    found = critical_loads(one, on_lines(one, {"top": (0.0, 0.0, -1.0)}), 1) / (np.pi / 2.0) / (E * t**2 / np.sqrt(3.0))
    yield relative("N R sqrt(3)/(E t^2), compressed cylinder", found, reference.values["cylinder"], 1e-3)


def on_lines(one: Shell, totals: dict[str, tuple[float, float, float]]) -> np.ndarray:
    """Return the forces (n, 6) of even loads on lines, of these totals in N."""
    force = np.zeros((len(one.x), 6))
    for line, total in totals.items():
        nodes, weights = along_line(one, line)
        force[nodes, :3] += weights[:, None] * np.array(total)
    return force


def critical_loads(one: Shell, force: np.ndarray, count: int) -> np.ndarray:
    """Return the lowest factors on forces (n, 6) at which a shell buckles."""
    free, stress_stiffness = one.free, cast(StressStiffness, one.model.stress_stiffness)
    K = one.model.stiffness[free][:, free].tocsc()
    softer = stress_stiffness(one.displaced(force).ravel())[free][:, free]
    lu = spla.splu(K, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    inverse = spla.LinearOperator(K.shape, lu.solve)
    start = np.random.default_rng(0).standard_normal(len(free))
    # six at least: Lanczos' method may miss the lowest of a close pair, or one that lies apart
    found = spla.eigsh(-softer, max(count, 6), K, Minv=inverse, which="LA", v0=start)[0]
    return np.asarray(np.sort(1.0 / found)[:count])


CASES = (
    Case("SH12", plate),
    Case("SH13", tank),
    Case("SH14", strip),
    Case("SH15", cross_ply),
    Case("SH16", buckling),
)
