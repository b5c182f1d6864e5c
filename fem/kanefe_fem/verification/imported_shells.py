"""Matrices whose nodes rotate, SH30 and SH31: against exact integrals, and against the body of the same elements.

M and K are those of own elements, as another program would give them: what a reader makes of them knows no shape
functions.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import COMPONENTS, FiniteElementModel
from kanefe.fe_model.places import OnPlane
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.joints import Free
from kanefe.reduction import flexible_body
from kanefe.reduction.craig_bampton import CraigBampton
from kanefe.system import System
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.surface_grid import surface_mesh
from kanefe_fem.shells.body import shell_model

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)

RADIUS, LENGTH, THICKNESS = 0.2, 0.5, 0.01
"""Sizes of half a cylinder, m: the thickness makes 6e-4 of the moment about its axis."""


@cache
def half_cylinder() -> FiniteElementModel:
    """Return the model of a free half cylinder about x, from nine-node quadrangles: 16 around, 6 along."""

    def place(s: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
        return LENGTH * (s - 0.5), RADIUS * np.cos(np.pi * r), RADIUS * np.sin(np.pi * r)

    return shell_model(surface_mesh(place, (6, 16)), STEEL, THICKNESS)


def as_imported(model: FiniteElementModel) -> FiniteElementModel:
    """Return the model that a reader makes of matrices, whose rows are all x, then all y, ..."""
    rows = np.arange(model.size).reshape(-1, len(model.components)).T.ravel()
    M, K = (sp.csr_matrix(one)[rows][:, rows] for one in (model.mass, model.stiffness))
    return model_from_matrices(M, K, model.nodes, components=COMPONENTS, order="components", cells=model.cells)


def reduced(model: FiniteElementModel) -> FlexibleBody:
    """Return a free body with an interface at one end."""
    end = Interface("all", kind="average", at=OnPlane((model.nodes[:, 0].min(), 0.0, 0.0), (1.0, 0.0, 0.0)))
    return flexible_body(model, {"end": end}, reduction=CraigBampton(modes=4))


def tumbled(body: FlexibleBody) -> tuple[np.ndarray, float]:
    """Return the way of the end of a body that tumbles and so bends, and how much its angular momentum changes."""
    scene = System()
    spin = Free(angular_velocity=(5.0, 6.0, -2.0))
    scene.add_flexible_body("body", body, joint=spin)
    result = scene.simulate((0.0, 0.05), output_step=5e-3, rtol=1e-10, atol=1e-12)
    momentum = result.momentum.angular
    change = np.linalg.norm(momentum - momentum[0], axis=1).max() / np.linalg.norm(momentum[0])
    return result.position("body", "end"), float(change)


def beside_own(model: FiniteElementModel) -> Iterator[Check]:
    """Yield what is compared of a body of matrices with that of the elements that they are of."""
    read = as_imported(model)
    yield Check.absolute("estimated part of the inertia", read.provenance.get("estimated_inertia", 0.0), 0.0, 0.0)
    own, other = reduced(model), reduced(read)
    elastic = own.frequencies[own.frequencies > 1.0]
    yield Check.relative("frequencies [Hz]", other.frequencies[-len(elastic) :], elastic, 1e-6)
    (way, _), (same, change) = tumbled(own), tumbled(other)
    size = float(np.ptp(np.asarray(model.nodes), axis=0).max())
    yield Check.absolute("way of its end in a tumble, over its size", same / size, way / size, 1e-6)
    yield Check.absolute("change of angular momentum, relative", change, 0.0, 1e-8)


def shell_matrices(reference: Reference) -> Iterator[Check]:
    """SH30: a half cylinder."""
    read = as_imported(half_cylinder())
    found, values = read.provenance["self_check"], reference.values
    yield Check.relative("mass [kg]", found["mass"], values["mass"], 1e-5)
    yield Check.relative("height of its centre [m]", found["center_of_mass"][2], values["centre"], 1e-5)
    moments = np.diag(found["inertia"])
    yield Check.relative("moments of inertia about the origin [kg m2]", moments, values["moments"], 1e-5)
    yield from beside_own(half_cylinder())


def beam_matrices(reference: Reference) -> Iterator[Check]:
    """SH31: a beam of cubic functions, whose shear and rotary inertia are in M."""
    model = straight_beam(1.0, Rectangle(0.02, 0.05), STEEL, elements=10)
    found = as_imported(model).provenance["self_check"]
    yield Check.relative("mass [kg]", found["mass"], reference.values["mass"], 1e-9)
    yield Check.relative("moments [kg m2]", np.diag(found["inertia"]), reference.values["moments"], 1e-9)
    yield from beside_own(model)


CASES = (Case("SH30", shell_matrices), Case("SH31", beam_matrices))
