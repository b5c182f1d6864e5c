"""Linear elasticity of a solid as UFL forms: strain, stress, stiffness and mass.

Every function takes the namespace `fx` of `kanefe_fem._fenicsx.load`. The material is constant on each cell, so that
one compiled kernel serves all values and all groups of a material class.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.fe_model.shapes import Shape
from kanefe_fem._fenicsx import cell_function
from kanefe_fem.materials.moduli import IsotropicModuli, Moduli

VOIGT = {
    3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)),
    2: ((0, 0), (1, 1), (0, 1)),
}
"""Tensor indices in the order xx, yy, zz, yz, xz, xy, by dimension."""


@dataclass(frozen=True, eq=False)
class MaterialFields:
    """The moduli as functions of the mesh: (lambda, mu), or one vector of the upper triangle."""

    functions: tuple[Any, ...]


def values_of(moduli: Moduli, original: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the values of the functions of moduli on a mesh, whose cell i is the cell `original[i]` of the moduli."""
    if isinstance(moduli, IsotropicModuli):
        return moduli.lame[original], moduli.shear[original]
    rows, columns = np.triu_indices(moduli.matrices.shape[1])
    return (moduli.matrices[original][:, rows, columns],)


def material_fields(fx: Any, mesh: Any, moduli: Moduli, original: np.ndarray) -> MaterialFields:
    """Return the moduli as functions of the mesh: see `values_of`."""
    return MaterialFields(tuple(cell_function(fx, mesh, values) for values in values_of(moduli, original)))


def strain(fx: Any, u: Any) -> Any:
    """Return the small strain ``e = sym grad u``."""
    return fx.ufl.sym(fx.ufl.grad(u))


def stress(fx: Any, fields: MaterialFields, u: Any) -> Any:
    """Return the stress of a displacement, ``lambda tr(e) I + 2 mu e``, or ``C : e``, in Pa (N/m in 2D)."""
    e = strain(fx, u)
    d = e.ufl_shape[0]
    if len(fields.functions) == 2:
        lame, shear = fields.functions
        return lame * fx.ufl.tr(e) * fx.ufl.Identity(d) + 2.0 * shear * e
    s = _anisotropic_stress(fx, fields, e)
    place = {pair: number for number, pair in enumerate(VOIGT[d])}
    return fx.ufl.as_matrix([[s[place[min(a, b), max(a, b)]] for b in range(d)] for a in range(d)])


def stiffness_integrand(fx: Any, fields: MaterialFields, u: Any, v: Any) -> Any:
    """Return ``s(u) : e(v)``."""
    e_u, e_v = strain(fx, u), strain(fx, v)
    if len(fields.functions) == 2:
        lame, shear = fields.functions
        return lame * fx.ufl.tr(e_u) * fx.ufl.tr(e_v) + 2.0 * shear * fx.ufl.inner(e_u, e_v)
    return sum(s * e for s, e in zip(_anisotropic_stress(fx, fields, e_u), _engineering_strain(e_v), strict=True))


def _anisotropic_stress(fx: Any, fields: MaterialFields, e: Any) -> list[Any]:
    """Return the components ``s_I = C_IJ e_J`` in the order of `VOIGT`."""
    upper = fields.functions[0]
    components = _engineering_strain(e)
    size = len(components)
    rows, columns = np.triu_indices(size)
    place = {(int(i), int(j)): number for number, (i, j) in enumerate(zip(rows, columns, strict=True))}
    return [sum(upper[place[min(i, j), max(i, j)]] * components[j] for j in range(size)) for i in range(size)]


def _engineering_strain(e: Any) -> list[Any]:
    return [e[a, b] if a == b else 2.0 * e[a, b] for a, b in VOIGT[e.ufl_shape[0]]]


def mass_degree(element: Shape, geometry: Shape) -> int:
    """Degree that integrates the mass exactly: total on simplices, in each direction on cubes."""
    d = element.dimension
    if element.is_simplex:
        return 2 * element.order + d * (geometry.order - 1)
    return 2 * element.order + d * geometry.order - 1


def stiffness_degree(element: Shape, geometry: Shape) -> int:
    """Degree of quadrature of the stiffness: exact on straight simplices and on boxes."""
    if element.is_simplex:
        return 2 * (element.order - 1) + 2 * (geometry.order - 1)
    return 2 * element.order
