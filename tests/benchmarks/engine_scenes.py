"""Our side of the scenes: chains, bars, and how they are stepped and evaluated."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np

import kanefe as kf
import scenes
from kanefe.finite_element_model import FiniteElementModel
from kanefe.integrate.run import integrate
from kanefe.model import Model

GRAVITY = (0.0, 0.0, -9.81)

# A link of S1: a steel-grey box of 0.5 m x 0.05 m x 0.05 m and 1000 kg/m3, hinged at its end.
LENGTH, WIDTH, DENSITY = 0.5, 0.05, 1000.0
MASS = DENSITY * LENGTH * WIDTH**2
INERTIA = MASS / 12 * np.array([2 * WIDTH**2, LENGTH**2 + WIDTH**2, LENGTH**2 + WIDTH**2])
STEP = 1e-3

# S3 and S4: a steel bar along x, its cross-section centred on the axis.
BAR = (1.0, 0.1, 0.05)
SPIN = (1.0, 20.0, 0.3)
FREE_MODES = 16


def chain_start(count: int) -> list[float]:
    """Return q of the chain at the start: hinges about z are turned to either side."""
    return [angle for _, angle in zip(range(count), cycle((0.0, 0.3, 0.0, -0.3)), strict=False)]


def chain_links(count: int) -> list[dict[str, Any]]:
    """Return the links of the chain as numbers: hinges about y and z in turn."""
    return [
        {
            "axis": "yz"[i % 2],
            "at": [LENGTH if i else 0.0, 0.0, 0.0],
            "com": [LENGTH / 2, 0.0, 0.0],
            "mass": MASS,
            "inertia": INERTIA.tolist(),
        }
        for i in range(count)
    ]


def chain_scene(count: int, axes: Sequence[Any] = "yz") -> kf.System:
    """Return S1, a chain of rigid links; `axes` are those of its hinges in turn."""
    scene = kf.System(gravity=GRAVITY)
    last = None
    for i, (link, angle, axis) in enumerate(zip(chain_links(count), chain_start(count), cycle(axes), strict=False)):
        hinge = kf.Revolute(axis, position=angle)
        last = scene.add_rigid_body(
            f"link {i}", MASS, INERTIA, com=link["com"], joint=hinge, parent=last, at=link["at"]
        )
    return scene


def planar_chain(count: int, tilt: float = 0.0) -> Model:
    """Return the chain with all hinges about y, so that it stays in a plane; a tilt (rad) of the last takes it out."""
    return chain_scene(count, ["y"] * (count - 1) + [(tilt, 1.0, 0.0)]).freeze()


def flexible_chain(count: int, modes: int) -> Model:
    """Return a chain of equal flexible bodies of `modes` elastic coordinates, each hinged to the tip of the last."""
    constraint_modes = 6
    body = scenes.lattice_body(
        1,
        {"root": "clamped", "tip": "rigid"},
        interior=modes,
        reduction=kf.CraigBampton(modes=modes - constraint_modes),
    )
    scene = kf.System(gravity=GRAVITY)
    last = None
    for i in range(count):
        member = scene.add_flexible_body(f"body {i}", body, joint=kf.Revolute("yz"[i % 2]), parent=last)
        last = member.interface("tip")
    return scene.freeze()


def bar_model(divisions: tuple[int, int, int]) -> FiniteElementModel:
    """Return the full-order steel bar of S3 and S4, from hexahedra of order 2.

    Raises
    ------
    MissingDependency
        Without dolfinx.
    """
    from fem_meshes import STEEL, box, deformed
    from kanefe_fem.solid import solid_model

    mesh = box("hexahedron", divisions, BAR)
    return solid_model(deformed(mesh, lambda nodes: nodes - [0.0, BAR[1] / 2, BAR[2] / 2]), STEEL, order=2)


def hinged_bar(model: FiniteElementModel, modes: int) -> Model:
    """Return S3: the bar hinged at its root, Craig-Bampton with `modes` normal modes beside the six of its tip."""
    from kanefe_fem._petsc import factorise

    body = kf.flexible_body(
        model,
        {"root": "clamped", "tip": "rigid"},
        reduction=kf.CraigBampton(modes=modes),
        factorise=factorise,
    )
    scene = kf.System(gravity=GRAVITY)
    scene.add_flexible_body("bar", body, joint=kf.Revolute("y"))
    return scene.freeze()


def free_bar_start() -> tuple[np.ndarray, np.ndarray]:
    """Return velocity and angular velocity of the mesh frame of S4; the centre of mass is at rest."""
    omega = np.array(SPIN)
    return -np.cross(omega, [BAR[0] / 2, 0.0, 0.0]), omega


def free_bar(model: FiniteElementModel) -> Model:
    """Return S4: the bar tumbling freely, with its free modes."""
    velocity, omega = free_bar_start()
    scene = kf.System()
    body = kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=FREE_MODES))
    scene.add_flexible_body("bar", body, joint=kf.Free(velocity=velocity, angular_velocity=omega))
    return scene.freeze()


def save_matrices(model: FiniteElementModel, path: Path) -> None:
    """Write nodes, M and K of a model for the peer."""
    arrays = {"nodes": model.nodes}
    for name, matrix in (("mass", model.mass.tocsr()), ("stiffness", model.stiffness.tocsr())):
        arrays |= {f"{name}_{part}": getattr(matrix, part) for part in ("data", "indices", "indptr")}
    np.savez(path, **arrays)


def run(model: Model, steps: int, h: float = STEP) -> np.ndarray:
    """Take steps of the classical Runge-Kutta method from the start and return q at the end."""
    end = steps * h
    return integrate(model, (0.0, end), method="rk4", step=h, output_step=end, progress=False).coordinates[-1]


def evaluation(model: Model) -> Callable[[], np.ndarray]:
    """Return one evaluation of the right-hand side at the start, as a user calls it."""
    y, rhs = model.initial_state, model.rhs
    return lambda: rhs(0.0, y)
