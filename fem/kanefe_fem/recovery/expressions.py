"""UFL expressions of the displacement of a body in a run, evaluated by dolfinx on the mesh of the body."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells, Elasticity
from kanefe.fe_model.shapes import shape
from kanefe.results.body_shape import BodyShape
from kanefe_fem import _fenicsx
from kanefe_fem.recovery.cell_strains import centroid, gauss_samples
from kanefe_fem.recovery.strain_fields import checked_elasticity
from kanefe_fem.solids.forms import VOIGT, strain


class ExpressionTerms:
    """Terms for a UFL expression.

    Attributes
    ----------
    ufl : module
        UFL itself.
    u : UFL function
        Displacement in m, a vector of the dimension of the mesh, in the axes of G.
    x : UFL expression
        Position in G, m.
    """

    def __init__(self, fx: Any, mesh: Any, u: Any, elasticity: Elasticity, of_cell: np.ndarray) -> None:
        self._fx = fx
        self._mesh = mesh
        self._elasticity = elasticity
        self._of_cell = of_cell
        self.ufl = fx.ufl
        self.u = u
        self.x = fx.ufl.SpatialCoordinate(mesh)

    @cached_property
    def strain(self) -> Any:
        """Small strain, a tensor."""
        return strain(self._fx, self.u)

    @cached_property
    def stress(self) -> Any:
        """Stress in Pa, a tensor of the dimension of the mesh."""
        e = self.strain
        d = e.ufl_shape[0]
        kept = [0, 1, 2, 3, 4, 5] if d == 3 else [0, 1, 5]
        moduli = self._elasticity.table[self._of_cell][:, kept][:, :, kept].reshape(len(self._of_cell), -1)
        C = _fenicsx.cell_function(self._fx, self._mesh, np.ascontiguousarray(moduli))
        engineering = [e[a, b] if a == b else 2.0 * e[a, b] for a, b in VOIGT[d]]
        count = len(engineering)
        s = [sum(C[i * count + j] * engineering[j] for j in range(count)) for i in range(count)]
        place = {pair: number for number, pair in enumerate(VOIGT[d])}
        return self._fx.ufl.as_matrix([[s[place[min(a, b), max(a, b)]] for b in range(d)] for a in range(d)])


def evaluate_expression(
    name: str,
    body: BodyShape,
    displacements: np.ndarray,
    function: Callable[[ExpressionTerms], Any],
    at: Literal["nodes", "cells", "gauss"],
) -> np.ndarray:
    """Return the values of an expression at every time, as `Recovery.expression` describes, from (T, n, 3) m."""
    if at not in ("nodes", "cells", "gauss"):
        raise ModelError(f"an expression is evaluated at 'nodes', 'cells' or 'gauss', not {at!r}")
    elasticity = checked_elasticity(name, body)
    if len({block.kind for block in body.cells}) > 1:
        raise ModelError(f"body {name!r} mixes shapes of cells, which dolfinx does not support")
    if body.cells[0].kind not in _fenicsx.SHAPES:
        raise ModelError(
            f"body {name!r} has cells of the shape {body.cells[0].kind}, on which dolfinx evaluates no expressions. "
            "Remedy: the stresses and strains of recover(...)"
        )
    kind, connectivity = body.cells[0].kind, np.concatenate([block.nodes for block in body.cells])
    fx = _fenicsx.load()
    with _fenicsx.quiet(), _fenicsx.compiling(fx):
        evaluator = _Evaluator(fx, body.nodes, Cells(kind, connectivity), elasticity, function, at)
        values = np.array([evaluator.values(u) for u in displacements])
    if at == "nodes":
        gather = _mean_of_cells(connectivity, len(body.nodes))
        flat = values.reshape(len(values), connectivity.size, -1)
        values = np.array([gather @ frame for frame in flat])
        return values.reshape(len(values), len(body.nodes), *evaluator.shape)
    points = () if at == "cells" else (values.shape[2],)
    return values.reshape(len(values), len(connectivity), *points, *evaluator.shape)


class _Evaluator:
    """An expression on the mesh of a body, compiled once."""

    def __init__(
        self,
        fx: Any,
        nodes: np.ndarray,
        cells: Cells,
        elasticity: Elasticity,
        function: Callable[[ExpressionTerms], Any],
        at: str,
    ) -> None:
        element = shape(cells.kind)
        self.dimension = element.dimension
        mesh = _fenicsx.create_mesh(fx, nodes, cells.nodes, element)
        self.original = np.asarray(mesh.topology.original_cell_index)
        space = _fenicsx.lagrange_space(fx, mesh, element, element.dimension)
        self.numbering = _fenicsx.node_of_dof(fx, space, cells.nodes[self.original], element)
        _fenicsx.check_numbering(space, nodes, self.numbering)
        self.u = fx.fem.Function(space)
        terms = ExpressionTerms(fx, mesh, self.u, elasticity, elasticity.of_cell[self.original])
        expression = function(terms)
        if not hasattr(expression, "ufl_shape"):
            raise ModelError(
                f"the function of the expression returned {expression!r}, which is not a UFL expression. Remedy: "
                "return one made of its argument's u, x, strain, stress and ufl"
            )
        self.shape: tuple[int, ...] = tuple(expression.ufl_shape)
        points = {"nodes": element.nodes, "cells": centroid(cells.kind), "gauss": gauss_samples(cells.kind).points}[at]
        self.compiled = _fenicsx.compiled_expression(fx, mesh, expression, points)

    def values(self, displacement: np.ndarray) -> np.ndarray:
        """Return the values in every cell from displacements (n, 3), shape (cells, points, numbers)."""
        self.u.x.array[:] = displacement[self.numbering, : self.dimension].ravel()
        found = self.compiled(len(self.original)).reshape(len(self.original), -1, int(np.prod(self.shape, dtype=int)))
        values = np.empty_like(found)
        values[self.original] = found
        return values


def _mean_of_cells(connectivity: np.ndarray, count: int) -> sp.csr_matrix:
    """Return the matrix (n, cells * nodes per cell) of means over the cells that meet at each node."""
    owners = connectivity.ravel()
    meeting = np.bincount(owners, minlength=count)
    return sp.csr_matrix((1.0 / meeting[owners], (owners, np.arange(len(owners)))), (count, len(owners)))
