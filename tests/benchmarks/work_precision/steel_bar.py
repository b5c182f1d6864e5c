"""S3 and S4: a steel bar of 1 x 0.1 x 0.05 m from a mesh, swinging on a hinge or tumbling freely."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

from benchmarks.work_precision.scene import BenchScene, Setting
from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification.scenes import displaced_node
from kanefe.equations.model import Model
from kanefe.fe_model.damping import ModalDamping
from kanefe.fe_model.model import FiniteElementModel
from kanefe.joints import Free, Revolute
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body
from kanefe_fem.solids.model import solid_model

SIZE = (1.0, 0.1, 0.05)
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
GRAVITY = (0.0, 0.0, -9.81)
ENDS = {"root": "clamped", "tip": "rigid"}
CORNER = (SIZE[0], -SIZE[1] / 2, -SIZE[2] / 2)
"""Node whose position is compared, m."""

HINGED_CELLS, FREE_CELLS = (21, 4, 3), (10, 2, 1)
"""Numbers of quadratic hexahedra along the edges: 2709 and 693 nodes."""

RATIO = 0.01
"""Damping ratio of every elastic mode of S3. Without damping the phase of irrelevant modes hides convergence."""

FREE_MODES = 16
SPIN = (1.0, 20.0, 0.3)
"""Initial angular velocity of S4, rad/s."""

END = 2.0


def bar_mesh(cells: tuple[int, int, int]) -> Mesh:
    """Return the bar along x, its cross-section centred on the axis, as hexahedra."""
    return box_mesh(SIZE, cells, "hexahedron", start=(0.0, -SIZE[1] / 2, -SIZE[2] / 2))


def bar_model(cells: tuple[int, int, int]) -> FiniteElementModel:
    """Return the full-order bar of quadratic hexahedra.

    Raises
    ------
    MissingDependency
        Without dolfinx.
    """
    return solid_model(bar_mesh(cells), STEEL, order=2)


def made_body(
    modes: int, cells: tuple[int, int, int] = HINGED_CELLS, order: int = 2, *, is_cached: bool = False
) -> FlexibleBody:
    """Return the bar with its root clamped in G and `modes` normal modes beside the six of its tip."""
    reduction, damping = CraigBampton(modes=modes), ModalDamping(RATIO)
    return solid_body(
        bar_mesh(cells), STEEL, ENDS, reduction=reduction, damping=damping, order=order, cache=is_cached, progress=False
    )


hinged_body = cache(made_body)


def hinged_bar(body: FlexibleBody) -> Model:
    """Return S3: the bar on a hinge about y, released under gravity."""
    scene = System(gravity=GRAVITY)
    scene.add_flexible_body("bar", body, joint=Revolute("y"))
    return scene.freeze()


@cache
def free_body() -> FlexibleBody:
    """Return the bar with its free modes."""
    return solid_body(bar_mesh(FREE_CELLS), STEEL, {}, reduction=CraigBampton(modes=FREE_MODES))


def free_start() -> tuple[list[float], list[float]]:
    """Return velocity and angular velocity of the mesh frame of S4; the centre of mass is at rest."""
    return (-np.cross(SPIN, [SIZE[0] / 2, 0.0, 0.0])).tolist(), list(SPIN)


def free_bar(body: FlexibleBody) -> Model:
    """Return S4: the bar tumbling freely."""
    velocity, omega = free_start()
    scene = System()
    scene.add_flexible_body("bar", body, joint=Free(velocity=velocity, angular_velocity=omega))
    return scene.freeze()


def corner(model: Model, t: float, q: np.ndarray) -> np.ndarray:
    """Return the position in N of the node at the far corner, m."""
    nodes = model.flexible_terms("bar").body.nodes
    node = int(np.argmin(np.linalg.norm(nodes - CORNER, axis=1)))
    return displaced_node(model, "bar", node, (t, q, np.zeros(model.free_count)))[0]


def hinged(modes: int, name: str) -> BenchScene:
    """Return S3 with so many normal modes."""
    return BenchScene(
        name=name,
        title=f"S3 · hinged bar from a mesh, {modes + 6} modes",
        build=lambda: hinged_bar(hinged_body(modes)),
        measure=corner,
        quantity=f"corner position at {END:g} s",
        end=END,
        reference=Setting("dop853", rtol=1e-10),
        agreement=3e-8,
        largest_step=0.25,
        parameters=_parameters(HINGED_CELLS, modes=modes, ratio=RATIO, gravity=GRAVITY),
        needs="dolfinx",
    )


def tumbling() -> BenchScene:
    """Return S4."""
    return BenchScene(
        name="S4",
        title=f"S4 · tumbling bar, {FREE_MODES} modes, no damping",
        build=lambda: free_bar(free_body()),
        measure=corner,
        quantity=f"corner position at {END:g} s",
        end=END,
        reference=Setting("dop853", rtol=1e-10),
        agreement=3e-8,
        largest_step=0.02,
        parameters=_parameters(FREE_CELLS, modes=FREE_MODES, spin=SPIN),
        needs="dolfinx",
    )


def _parameters(cells: tuple[int, int, int], **others: Any) -> dict[str, Any]:
    return {"size": SIZE, "cells": cells, "E": STEEL.E, "nu": STEEL.nu, "rho": STEEL.rho, **others}


SCENES: dict[str, Callable[[], BenchScene]] = {
    "S3": partial(hinged, 8, "S3"),
    "S3-16": partial(hinged, 16, "S3-16"),
    "S3-32": partial(hinged, 32, "S3-32"),
    "S4": tumbling,
}
