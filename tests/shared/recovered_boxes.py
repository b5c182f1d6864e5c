"""Fields of a small box in given motions, as if a run had them."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from fem_meshes import box, deformed
from kanefe.fe_model.model import TRANSLATIONS, Elasticity
from kanefe.results.body_shape import BodyShape
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.recovery.recovery import Recovery, recover
from kanefe_fem.recovery.strain_fields import StrainFields

E, NU = 210e9, 0.3
G = E / (2 * (1 + NU))
SIZE = (0.3, 0.1, 0.08)


def isotropic(dimension: int = 3) -> np.ndarray:
    """Moduli (6, 6): of plane stress in the places of xx, yy and xy if plane."""
    C = np.zeros((6, 6))
    if dimension == 2:
        C[:2, :2] = E / (1 - NU**2) * np.array([[1, NU], [NU, 1]])
        C[5, 5] = G
        return C
    C[:3, :3] = E * NU / ((1 + NU) * (1 - 2 * NU))
    C[range(3), range(3)] += 2 * G
    C[range(3, 6), range(3, 6)] = G
    return C


def mesh_of(kind: str, order: int, bent: bool = False) -> Mesh:
    mesh = box(kind, (3, 2, 2), SIZE).with_order(order)
    if not bent:
        return mesh

    def move(x: np.ndarray) -> np.ndarray:
        y = x.copy()
        y[:, 0] += 0.9 * x[:, 0] ** 2 if order == 2 else 0.2 * x[:, 1]
        y[:, 1] += 0.6 * x[:, 0] ** 2 + 1.5 * x[:, 0] * x[:, 1]
        return y

    return deformed(mesh, move)


def fields_of(mesh: Mesh, u: np.ndarray, table: np.ndarray | None = None, of_cell: np.ndarray | None = None):
    """Fields with the columns (n, 3, k) of displacements as coordinates."""
    d = mesh.dimension
    table = isotropic(d)[None] if table is None else table
    of_cell = np.zeros(mesh.cell_count, dtype=int) if of_cell is None else of_cell
    basis = u[:, :d].reshape(len(mesh.nodes) * d, -1)
    return StrainFields(mesh.nodes, TRANSLATIONS[:d], basis, mesh.cell_blocks, Elasticity(table, of_cell))


def shape_of(fields: StrainFields) -> BodyShape:
    """A body of a result with these fields and nothing else."""
    zero = np.zeros(3)
    return BodyShape(
        "b",
        "",
        "",
        "fixed",
        (),
        (),
        (),
        1.0,
        zero,
        np.eye(3),
        (),
        fields.components,
        fields.nodes,
        fields.basis,
        fields.cells,
        True,
        {"materials": {"left": {}, "right": {}}},
        fields.elasticity,
    )


def recovered(fields: StrainFields, eta: np.ndarray, material: int | str | None = None) -> Recovery:
    """What `recover` gives for a run with these coordinates at 0, 1, 2, ... s."""
    shape = shape_of(fields)
    result = SimpleNamespace(
        loads=(),
        body=lambda name: shape,
        modal_coordinates=lambda name: eta,
        times=np.arange(len(eta), dtype=float),
        run=None,
    )
    return recover(result, "b", material=material)
