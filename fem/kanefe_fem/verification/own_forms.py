"""Bodies by forms of the user: a graded bar (B14), and a sphere in water by potential flow and by a form (B15)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.model import Cells, FiniteElementModel
from kanefe.fe_model.shapes import shape
from kanefe.joints import Free
from kanefe.reduction import FreeInterface, flexible_body
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model
from kanefe_fem.solids.own_forms import Forms
from kanefe_fem.solids.potential_flow import PotentialFlow

PLASTIC = Material(E=2e9, nu=0.0, rho=1000.0)
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

RADIUS, WATER, GRAVITY = 0.5, 1000.0, 9.81
"""Radius of the sphere in m, density of the water in kg/m3, gravity in m/s2."""

PATCH = 3
"""Number of cells along the sides of the six patches of a sphere."""


def graded_bar(reference: Reference) -> Iterator[Check]:
    """B14: 20 quadratic hexahedra with modulus and density in proportion to (1 + x)^2."""

    def stress(f: Any, u: Any) -> Any:
        return PLASTIC.E * (1.0 + f.x[0]) ** 2 * f.strain(u)

    def mass(f: Any) -> Any:
        return PLASTIC.rho * (1.0 + f.x[0]) ** 2 * f.p * f.q * f.dx

    body = solid_body(
        box_mesh((1.0, 0.05, 0.05), (20, 1, 1), "hexahedron"),
        PLASTIC,
        {"root": "clamped"},
        FreeInterface(modes=24),
        forms=Forms(stress=stress, mass=mass),
    )
    moving = np.asarray(body.inertia_mass.sum(axis=0)) @ body.inertia_basis[::3, : body.free_count]
    motion = moving.ravel()  # momentum along x, which axial modes alone have
    along = np.flatnonzero(np.abs(motion) > 1e-6 * np.abs(motion).max())
    found = body.frequencies[along][:3]
    yield Check.relative("f 1-3, axial [Hz]", found, reference.values["axial"], 1e-4)
    yield Check.relative("mass [kg]", body.mass, reference.values["mass"], 1e-4)


def sphere_in_water(reference: Reference) -> Iterator[Check]:
    """B15: six patches of curved hexahedra, the water to three radii with a dipole beyond."""
    steel = ball_shell(0.8 * RADIUS, RADIUS, 1)
    water = ball_shell(RADIUS, 3.0 * RADIUS, 2 * PATCH)
    flow = PotentialFlow(water, "inner", WATER, far=["outer"])

    def on_surface(f: Any) -> Any:
        return WATER * RADIUS / 2.0 * f.ufl.dot(f.u, f.n) * f.ufl.dot(f.v, f.n) * f.ds("outer")

    half = reference.values["added"]
    for name, fluid in (("potential flow", flow), ("form", on_surface)):
        model = solid_model(steel, STEEL, forms=Forms(added_mass=fluid))
        added = _of_rigid_motions(model)
        yield Check.relative(f"added mass, {name} [kg]", np.diag(added)[:3], np.full(3, half), 1e-3)
        # of a polygonal surface a rotation moves some water: the square of its deviation from the sphere
        yield Check.absolute(
            f"added inertia / (added mass radius^2), {name}", added[3:, 3:].max() / half / 0.25, 0, 1e-3
        )
        displaced = reference.values["displaced"]
        scene = System(gravity=(0.0, 0.0, -GRAVITY))
        body = flexible_body(model, {}, reduction=FreeInterface(modes=6))
        ball = scene.add_flexible_body("ball", body, joint=Free())
        scene.add_force(ball, (0.0, 0.0, displaced * GRAVITY))
        frozen = scene.freeze()
        found = frozen.rhs(0.0, frozen.initial_state)[-frozen.free_count + 2]
        sinking = -(body.mass - displaced) * GRAVITY / (body.mass + half)
        yield Check.relative(f"acceleration, {name} [m/s2]", found, sinking, 1e-3)


def _of_rigid_motions(model: FiniteElementModel) -> np.ndarray:
    R = model.rigid_modes()
    return np.asarray(R.T @ (model.added_mass @ R))


def ball_shell(inner: float, outer: float, layers: int) -> Mesh:
    """Return a spherical shell of 27-node hexahedra: the six faces of a cube, blown up; facets "inner" and "outer"."""
    slopes = np.tan(0.25 * np.pi * np.linspace(-1.0, 1.0, 2 * PATCH + 1))
    a, b = np.meshgrid(slopes, slopes, indexing="ij")
    radii = inner * (outer / inner) ** np.linspace(0.0, 1.0, 2 * layers + 1)
    places = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((*a.shape, 3))
            face[..., axis] = side
            face[..., (axis + 1) % 3], face[..., (axis + 2) % 3] = (a, b) if side > 0 else (b, a)
            face /= np.linalg.norm(face, axis=-1, keepdims=True)
            places.append(face[:, :, None, :] * radii[:, None])
    points = np.array(places).reshape(-1, 3)
    _, first, same = np.unique(np.round(points / outer, 9), axis=0, return_index=True, return_inverse=True)
    number = same.reshape(6, 2 * PATCH + 1, 2 * PATCH + 1, 2 * layers + 1)
    i, j, k = np.meshgrid(*(2 * np.arange(count) for count in (PATCH, PATCH, layers)), indexing="ij")
    x, y, z = np.round(2.0 * shape("hexahedron27").nodes).astype(int).T
    cells = number[:, i[..., None] + x, j[..., None] + y, k[..., None] + z].reshape(-1, 27)
    x, y = np.round(2.0 * shape("quad9").nodes).astype(int).T
    faces = number[:, i[:, :, 0, None] + x, j[:, :, 0, None] + y].reshape(-1, 9, 2 * layers + 1)
    facets = {"inner": (Cells("quad9", faces[..., 0]),), "outer": (Cells("quad9", faces[..., -1]),)}
    return Mesh(points[first], 3, {"shell": (Cells("hexahedron27", cells),)}, facets, source="a spherical shell")


CASES = (Case("B14", graded_bar), Case("B15", sphere_in_water))
