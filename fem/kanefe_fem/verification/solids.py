"""Verification cases of solid and plane meshes, which need dolfinx but not gmsh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import scipy.linalg

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.checks.verification.rigid import attitude_checks
from kanefe.checks.verification.scenes import natural_modes, states_at, stretching_frequencies_with_tip_mass
from kanefe.joints import Free
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh, rectangle_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model
from kanefe_fem.verification import (
    damped_beams,
    experiments,
    imported_shells,
    joined_shells,
    loaded_shells,
    own_forms,
    plates,
    satellite,
    shell_stresses,
    shells,
    sliding_block,
    stiffened_shells,
    stiffened_solids,
)
from kanefe_fem.verification.centrifugal import AREA, DENSITY, LENGTH, YOUNG, centrifugal_statics

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
STEEL_BAR = Material(E=210e9, nu=0.0, rho=7850.0)
"""Steel without lateral contraction, so that a plane bar stretches like a one-dimensional one."""

BLOCK = (1.0, 0.2, 0.1)


def directed_frequencies(body: FlexibleBody, component: str) -> np.ndarray:
    """Return the natural frequencies in Hz of the modes with most of their kinetic energy along one component."""
    k = body.free_count
    frequencies, modes = natural_modes(body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k])
    shapes = (body.inertia_basis[:, :k] @ modes).reshape(-1, 3, k)
    momenta = (body.inertia_mass @ shapes.reshape(len(shapes), -1)).reshape(shapes.shape)
    moving = np.einsum("pai,pai->ai", shapes, momenta)
    return frequencies[moving["xyz".index(component)] > 0.5 * moving.sum(axis=0)] / (2.0 * np.pi)


def thick_beams(reference: Reference) -> Iterator[Check]:
    """B02a: the thick beam as a solid, whose sections differ from Timoshenko's by up to 1 %."""
    mesh = box_mesh((1.0, 0.1, 0.05), (30, 4, 2), "hexahedron")
    for name, interfaces in (("clamped-free", {"root": "clamped"}), ("free-free", {})):
        expected = [float(f) for f in reference.values[name]]
        body = solid_body(mesh, STEEL, interfaces, reduction=CraigBampton(modes=24))
        found = directed_frequencies(body, "y")[: len(expected)]
        quantity = f"f 1-{len(expected)}, {name}, solid of {mesh.cell_count} quadratic hexahedra [Hz]"
        yield Check.relative(quantity, found, expected, 1e-2)


def bars(reference: Reference) -> Iterator[Check]:
    """B06: axial modes of a plane-stress bar, 20 quadratic elements long."""
    width = thickness = 0.02
    mesh = rectangle_mesh(1.0, width, 20)

    def plane_body(interfaces: Mapping[str, str]) -> FlexibleBody:
        modes = CraigBampton(modes=40)
        return solid_body(mesh, STEEL_BAR, interfaces, reduction=modes, plane="stress", thickness=thickness)

    label = "20 quadratic elements"
    supports: dict[str, dict[str, str]] = {"axial_fixed_free": {"root": "clamped"}, "axial_free_free": {}}
    for name, interfaces in supports.items():
        found = directed_frequencies(plane_body(interfaces), "x")[:3]
        yield Check.relative(f"f 1-3, {name.replace('_', ' ')}, {label} [Hz]", found, reference.values[name], 1e-4)
    tipped = plane_body({"root": "clamped", "tip": "rigid"})
    found = stretching_frequencies_with_tip_mass(tipped, STEEL_BAR.rho * width * thickness)[:3]
    expected = reference.values["axial_tipmass_1"]
    yield Check.relative(f"f 1-3, axial, tip mass = bar mass, {label} [Hz]", found, expected, 1e-4)


def free_block(reference: Reference) -> Iterator[Check]:
    """B08a: elastic and rigid modes of a free block of quadratic tetrahedra."""
    mesh = box_mesh(BLOCK, (24, 8, 4), "tetra")
    found = solid_body(mesh, STEEL, {}, reduction=CraigBampton(modes=6)).frequencies[:4]
    expected = np.array(reference.values[:4])
    yield Check.relative(f"f 1-4, {mesh.cell_count} quadratic tetrahedra [Hz]", found, expected, 1e-3)
    # the reference has five accurate digits
    below = np.max(np.maximum(1.0 - found / expected, 0.0))
    yield Check.absolute("share by which one of f 1-4 is below the reference", below, 0.0, 1e-5)
    # the six lowest frequencies are at most those of rigid motions of the mesh (Courant, Fischer)
    model = solid_model(mesh, STEEL)
    R = model.rigid_modes()
    squares = scipy.linalg.eigh(R.T @ (model.stiffness @ R), R.T @ (model.mass @ R), eigvals_only=True)
    share = np.sqrt(np.abs(squares).max()) / (2.0 * np.pi * found[0])
    yield Check.absolute("highest rigid frequency / first elastic one", share, 0.0, 1e-3)


def tumbling_block(reference: Reference) -> Iterator[Check]:
    """E01a: a free block of 8 quadratic hexahedra, stiff at 2 rad/s, by the implicit method."""
    mesh = box_mesh(BLOCK, (8, 1, 1), "hexahedron", start=(-0.5, -0.1, -0.05))
    body = solid_body(mesh, STEEL, {}, reduction=CraigBampton(modes=6))
    values = reference.values
    yield Check.relative("mass [kg]", body.mass, values["mass"], 1e-12)
    yield Check.relative("principal moments of inertia [kg m2]", np.diag(body.inertia), values["I"], 1e-12)
    scene = System()
    scene.add_flexible_body("block", body, joint=Free(angular_velocity=values["w0"]))
    states = states_at(scene.freeze(), values["times"], rtol=1e-9, method="generalised-alpha")
    yield from attitude_checks(states, reference, 1e-5)


def spinning_bar(reference: Reference) -> Iterator[Check]:
    """E02a: a plane-stress bar, 20 quadratic elements long, spun about y so that all loads are along x."""
    yield from centrifugal_statics(reference, plane_bar, "20 quadratic elements")


def plane_bar(interfaces: Mapping[str, str]) -> FlexibleBody:
    """Return the bar of E02a, unreduced."""
    height = 0.1
    mesh = rectangle_mesh(LENGTH, height, 20)
    material = Material(E=YOUNG, nu=0.0, rho=DENSITY)
    return solid_body(mesh, material, interfaces, None, plane="stress", thickness=AREA / height)


CASES = (
    Case("B02a", thick_beams),
    Case("B06", bars),
    Case("B08a", free_block),
    Case("E01a", tumbling_block),
    Case("E02a", spinning_bar),
    *damped_beams.SOLID_CASES,
    *experiments.SOLID_CASES,
    *own_forms.CASES,
    *plates.CASES,
    *satellite.CASES,
    *shells.CASES,
    *shell_stresses.CASES,
    *joined_shells.CASES,
    *loaded_shells.CASES,
    *imported_shells.CASES,
    *sliding_block.CASES,
    *stiffened_shells.CASES,
    *stiffened_solids.CASES,
)
