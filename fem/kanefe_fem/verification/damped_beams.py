"""Damping of materials: roots of a viscoelastic beam (B12), and a constrained layer from solid elements (B13)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import Cells
from kanefe.linear.linearisation import linearise
from kanefe.linear.modes.modes import Modes
from kanefe.reduction import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh

LENGTH, WIDTH, FACE, LAYER = 177.8e-3, 12.7e-3, 1.524e-3, 0.127e-3
"""Length and width of the sandwich, thickness of its faces and of its core, m."""

BRICKS = 32
"""Number of elements along the sandwich: with 20 the third loss factor is 0.7 % off."""


def prony_beam(reference: Reference) -> Iterator[Check]:
    """B12: a simply supported beam of one arm; its stiffness is set so that the elastic frequency is that given."""
    held = {"root": Interface(("x", "y")), "tip": Interface(("y",))}

    def modes(E: float) -> tuple[float, Modes]:
        material = Material(E=E, nu=0.3, rho=7850.0, prony=[(1.0 / 3.0, 0.02)])
        model = straight_beam(
            1.0, Rectangle(0.05, 0.01), material, planar=True, theory="euler-bernoulli", rotary_inertia=False
        )
        body = beam_body(model, held, CraigBampton(modes=2))
        scene = System()
        scene.add_flexible_body("beam", body)
        return body.frequencies[0], linearise(scene).modes()

    first, _ = modes(1e9)
    _, found = modes(1e9 * (10.0 / first) ** 2)
    for name, value in reference.values.items():
        root = complex(*value)
        nearest = found.eigenvalues[np.argmin(np.abs(found.eigenvalues - root))]
        for part, a, b in (("real", nearest.real, root.real), ("imaginary", nearest.imag, root.imag)):
            if b:
                yield Check.relative(f"{name}, {part} part [1/s]", a, b, 1e-8)


def sandwich() -> Mesh:
    """Return a bar of three layers along z, of the groups "face" and "core"."""
    mesh = box_mesh((LENGTH, WIDTH, 3.0), (BRICKS, 1, 3))
    x, y, z = mesh.nodes.T
    (bricks,) = mesh.cells["body"]
    is_core = np.abs(z[bricks.nodes].mean(axis=1) - 1.5) < 0.1
    heights = np.interp(z, range(4), np.cumsum([0.0, FACE, LAYER, FACE]))
    groups = {"face": bricks.nodes[~is_core], "core": bricks.nodes[is_core]}
    cells = {name: (Cells(bricks.kind, nodes),) for name, nodes in groups.items()}
    return replace(mesh, nodes=np.column_stack([x, y, heights]), cells=cells)


def constrained_layer(reference: Reference) -> Iterator[Check]:
    """B13: a clamped sandwich with a lossy core, one quadratic element across each layer."""
    from kanefe_fem.solids.body import solid_body  # only here: beams need no dolfinx

    eta = 0.1
    core = Material(E=2.6 * 0.896e6, nu=0.3, rho=968.1, loss_factor=eta)
    face = Material(E=69e9, nu=0.0, rho=2766.0)
    scene = System()
    body = solid_body(sandwich(), {"face": face, "core": core}, {"root": "clamped"}, CraigBampton(modes=6))
    scene.add_flexible_body("beam", body)
    modes = linearise(scene).modes()
    bending = [i for i in range(6) if modes.loss_factors[i] > 0.05 * eta][:3]
    yield Check.relative("frequencies 1-3 [Hz]", modes.frequencies[bending], reference.values["frequency"], 1e-2)
    yield Check.relative(
        "loss factors 1-3, over that of the core", modes.loss_factors[bending] / eta, reference.values["loss"], 1e-2
    )


BEAM_CASES = (Case("B12", prony_beam),)
SOLID_CASES = (Case("B13", constrained_layer),)
