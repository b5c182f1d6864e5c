"""Small scenes that every route can solve: a double pendulum in a plane, and an arm of springs and points in space."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import FiniteElementModel, MassField, NodeGroup
from kanefe.joints import Revolute
from kanefe.reduction import CraigBampton, flexible_body
from kanefe.system import System

CELLS = 3
LENGTH, WIDTH = 0.6, 0.1  # m
RATE = 2e4  # N/m, of each spring
MASS = 1.2  # kg
INNER = 3 * 3 * (CELLS - 1)
"""Number of degrees of freedom between the two ends: with as many modes the reduction is exact."""


def double_pendulum() -> System:
    """Return two rods on hinges in the x-y plane, released from the horizontal."""
    scene = System(gravity=(0.0, -9.81, 0.0))
    upper = scene.add_rigid_body("upper", 1.0, 1 / 12, com=(0.5, 0, 0), joint=Revolute("z"))
    lower = {"com": (0.25, 0, 0), "parent": upper, "at": (1, 0, 0)}
    scene.add_rigid_body("lower", 0.5, 1 / 96, joint=Revolute("z", position=0.4), **lower)  # type: ignore[arg-type]
    return scene


def arm(is_reduced: bool) -> System:
    """Return a hub on a hinge with a flexible arm and a tip mass, falling; the arm with all its modes, or unreduced."""
    ends = {"root": "clamped", "tip": "rigid"}
    # a rigid end of three nodes leaves its six motions to the tip
    body = flexible_body(_truss(), ends, reduction=CraigBampton(modes=INNER) if is_reduced else None)
    scene = System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 2.0, 0.02, joint=Revolute((0.1, 1.0, 0.2)))
    member = scene.add_flexible_body("arm", body, parent=hub, at=(0.05, 0, 0))
    scene.add_rigid_body("tip", 0.5, 1e-3, parent=member.interface("tip"))
    return scene


def _truss() -> FiniteElementModel:
    """Return points in triangles along x, each connected by springs to those of its own and the next triangle."""
    corners = WIDTH * np.array([(0.0, 0.6, 0.0), (0.0, -0.3, 0.52), (0.0, -0.3, -0.52)])
    nodes = np.vstack([np.add(corners, (x, 0.0, 0.0)) for x in np.linspace(0.0, LENGTH, CELLS + 1)])
    stiffness = np.zeros((nodes.size, nodes.size))
    for i in range(len(nodes)):
        for j in range(i + 1, len(nodes)):
            if j // 3 - i // 3 <= 1:
                along = (nodes[j] - nodes[i]) / np.linalg.norm(nodes[j] - nodes[i])
                row = np.zeros(nodes.size)
                row[3 * i : 3 * i + 3], row[3 * j : 3 * j + 3] = -along, along
                stiffness += RATE * np.outer(row, row)
    masses = sp.identity(len(nodes), format="csr") * (MASS / len(nodes))
    first, last = np.arange(3), np.arange(len(nodes) - 3, len(nodes))
    return FiniteElementModel(
        nodes=nodes,
        components=("x", "y", "z"),
        stiffness=sp.csr_matrix(stiffness),
        mass=sp.csr_matrix(sp.kron(masses, sp.identity(3))),
        mass_field=MassField(nodes, masses, sp.identity(nodes.size, format="csr")),
        groups={name: NodeGroup(at, nodes[at].mean(axis=0)) for name, at in (("root", first), ("tip", last))},
    )
