"""Assembly of a shell in FEniCSx: its spaces, its fields and its stiffness.

Integration is full for bending. Of the membrane, of shear and of the turn about the normal a share is integrated in
full and the rest by assumed strains (quadrangles) or at fewer points, so that thin shells do not lock:

    membrane  ``1 / (1 + (s / t)^2 / SAGITTA)``,  s: the rise of the cell over its chord;  a flat cell: 1
    shear     ``min(1, C t^2 / area)`` (Lyly, Stenberg and Vihinen, Comput. Methods Appl. Mech. Eng. 110 (1993) 343)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.block_diagonal import block_diagonal
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import Shape, quadrature, shape
from kanefe_fem import _fenicsx
from kanefe_fem.shells import forms as shell_forms
from kanefe_fem.shells.assumed import FIELDS, energy_of_moments
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.sections import ShellSection

SAGITTA = 1.25e-3
"""Square of the rise of a cell over its thickness at which half of the membrane is integrated in full: 28 rises to a
thickness. From a tenth to ten times of it displacements and frequencies of the cases SH change by 0.03 % at most."""

SHEAR = {"quad9": 0.25, "triangle6": 5.0}
"""Square of the size of a cell over its thickness from which shear is integrated at fewer points."""

TURN = {"quad9": 1.0, "triangle6": 5.0}
"""Square of the size of a cell over its thickness from which the turn about the normal has fewer points."""

DEGREES = {"quad9": (5, 3, 3), "triangle6": (4, 2, 1)}
"""Degrees of quadrature: full, few, fewest."""

RULES = ("full", "few", "fewest")
"""Names of the rules of `kanefe_fem.shells.forms.energy`. A form with a rule of one point beside another one is summed
wrongly by FFCx on curved cells, so that each has a form of its own in triangles."""

FLAT = 1e-9
"""Square of thickness times curvature, dimensionless, below which strains through the thickness are those of plates."""


@dataclass(frozen=True, eq=False)
class ShellCells:
    """The cells of one shape, with what they are made of.

    Attributes
    ----------
    cells : Cells
        "quad9" or "triangle6", normals consistent.
    sides : ndarray of int, shape (m, nodes per cell)
        Numbers of their directors.
    thickness : ndarray, shape (m, nodes per cell)
        At the nodes, m.
    along : ndarray, shape (m, 3)
        Direction whose part in the surface is the first axis of the material.
    sections : tuple of ShellSection
    of_cell : ndarray of int, shape (m,)
        Number of the section of each cell.
    """

    cells: Cells
    sides: np.ndarray
    thickness: np.ndarray
    along: np.ndarray
    sections: tuple[ShellSection, ...]
    of_cell: np.ndarray


class ShellProblem:
    """The spaces and fields of the cells of one shape."""

    def __init__(self, nodes: np.ndarray, directors: Directors, given: ShellCells) -> None:
        self.fx = fx = _fenicsx.load()
        self.nodes = nodes
        self.element = element = shape(given.cells.kind)
        self.mesh = _fenicsx.create_mesh(fx, nodes, given.cells.nodes, element, 3)
        original = np.asarray(self.mesh.topology.original_cell_index)
        self.cells, self.given, self.original = given.cells.nodes[original], given, original
        self.normals = directors.normal[given.sides[original]]
        self.space = _fenicsx.lagrange_space(fx, self.mesh, element, 6)
        self.nodes_of_space = _fenicsx.node_of_dof(fx, self.space, self.cells, element)
        self.corners, self.thickness = nodes[self.cells], given.thickness[original]
        self.area, rise = cell_sizes(element, self.corners, self.normals)
        _fenicsx.check_numbering(self.space, nodes, self.nodes_of_space)
        self.typical = self.thickness.mean(axis=1)
        self.membrane_share = 1.0 / (1.0 + (rise / self.typical) ** 2 / SAGITTA)
        self.curved = float(((rise / self.area * self.typical) ** 2).max()) > FLAT
        fields = shell_forms.ShellFields(
            director=_fenicsx.discontinuous_function(fx, self.mesh, self.normals, element),
            thickness=_fenicsx.discontinuous_function(fx, self.mesh, self.thickness, element),
            along=_fenicsx.cell_function(fx, self.mesh, given.along[original]),
            section=_fenicsx.cell_function(fx, self.mesh, self._of_sections(_moduli)),
            membrane=_fenicsx.cell_function(fx, self.mesh, self.membrane_share),
            shear=self._share(SHEAR),
            turn=self._share(TURN),
            reference=self._reference(),
        )
        self.surface = shell_forms.Surface(fx, self.mesh, fields)

    def _share(self, limits: Mapping[str, float]) -> Any:
        """Return the share of an energy that is integrated in full: all in cells smaller than the thickness."""
        ratio = limits[self.element.kind] * self.typical**2 / self.area
        return _fenicsx.cell_function(self.fx, self.mesh, np.minimum(1.0, ratio))

    def _of_sections(self, values: Any) -> np.ndarray:
        table = np.array([values(section) for section in self.given.sections])
        return np.asarray(table[self.given.of_cell[self.original]])

    def _reference(self) -> Any:
        """Return the coordinates of the reference quadrangle, from -1 to 1, as a function."""
        if self.element.is_simplex:
            return None
        linear = shape("quad")
        values = np.broadcast_to(2.0 * linear.nodes - 1.0, (len(self.cells), 4, 2))
        return _fenicsx.discontinuous_function(self.fx, self.mesh, np.ascontiguousarray(values), linear)

    def measure(self, rule: int) -> Any:
        """Return dx with the quadrature number `rule` of `DEGREES`."""
        degree = DEGREES[self.element.kind][rule]
        return self.fx.ufl.Measure("dx", domain=self.mesh)(metadata={"quadrature_degree": degree})

    def matrix(self, integrand: Any, rule: int) -> sp.csr_matrix:
        """Return the matrix of an integrand in the order of the space."""
        return _fenicsx.assemble_matrix(self.fx, self.fx.fem.form(integrand * self.measure(rule)))

    def stiffness(self, count: int) -> sp.csr_matrix:
        """Return K in the order of `count` nodes, N/m, N and N m."""
        ufl = self.fx.ufl
        w, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        integrated = _fenicsx.assemble_sum(self.fx, self._forms(w, v))
        stiffness = blocks_at_nodes(integrated, self.nodes_of_space, count)
        if self.element.is_simplex:
            coupling, inner = (self._columns_at_nodes(part, count) for part in self.bubbles(w))
            return stiffness - coupling.T @ inner
        for pair in self.assumed(v).values():
            moments, forces = (self._columns_at_nodes(part, count) for part in pair)
            stiffness = stiffness + moments.T @ forces
        return stiffness

    def _columns_at_nodes(self, matrix: sp.csr_matrix, count: int) -> sp.csr_matrix:
        """Return a matrix whose columns are those of the space with the coordinates of `count` nodes instead."""
        matrix, places = matrix.tocsr(), (6 * self.nodes_of_space[:, None] + np.arange(6)).ravel()
        return sp.csr_matrix((matrix.data, places[matrix.indices], matrix.indptr), shape=(matrix.shape[0], 6 * count))

    def _forms(self, w: Any, v: Any) -> Iterator[Any]:
        """Yield the forms of the stiffness: those through the thickness for one point of a layer after the other."""
        yield from self._energy(w, v)
        if self.curved:
            surface = self.surface
            flat = surface.strains(w), surface.strains(v)
            layer, height = self.layer()
            form = self.through_thickness(flat, (surface.at(height, w), surface.at(height, v)), layer)
            yield from self.at_points(form, layer)

    def _energy(self, w: Any, v: Any) -> list[Any]:
        """Return the compiled forms of the energy, of quadrangles one with all rules: see `RULES`."""
        parts = self.energy(self.surface.strains(w), self.surface.strains(v))
        integrals = [parts[name] * self.measure(rule) for rule, name in enumerate(RULES)]
        together = integrals if self.element.is_simplex else [sum(integrals[1:], integrals[0])]
        return [self.fx.fem.form(one) for one in together]

    def energy(self, x: Any, y: Any) -> dict[str, Any]:
        """Return the integrands of the work of the forces of strains x on strains y, by the names of `RULES`."""
        return shell_forms.energy(self.surface, x, y, not self.element.is_simplex)

    def bubbles(self, w: Any) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Return the forces of displacements on the bubbles (3 m, N), and the bubbles that balance them, reversed."""
        ufl = self.fx.ufl
        x, y = ufl.TrialFunction(self.bubble_space), ufl.TestFunction(self.bubble_space)
        own = sp.bsr_matrix(_fenicsx.assemble_sum(self.fx, self._energy(x, y)), blocksize=(3, 3))
        blocks = np.linalg.inv(own.data[np.argsort(own.indices)])
        coupling = _fenicsx.assemble_sum(self.fx, self._energy(w, y))
        return coupling, block_diagonal(blocks) @ coupling

    @cached_property
    def bubble_space(self) -> Any:
        """The space of cubic displacements that vanish on the sides of triangles."""
        return _fenicsx.bubble_space(self.fx, self.mesh)

    def assumed(self, w: Any) -> dict[str, tuple[sp.csr_matrix, sp.csr_matrix]]:
        """Return the moments of the strains of the membrane, and the forces that work on them, (11 m, N) each.

        Those of assumed strains; of bending too, where its forces are coupled with those of the membrane.
        """
        A, B = (self._of_sections(lambda one, power=power: one.stiffness(power)) for power in (0, 1))
        share = (1.0 - self.membrane_share)[:, None, None]
        arguments = self.corners, self.given.along[self.original], self.thickness
        moments = self._moments(w, "membrane")
        forces = block_diagonal(share * energy_of_moments(*arguments, A, 1)) @ moments
        if np.abs(B).max() <= 1e-12 * np.abs(A).max():
            return {"membrane": (moments, forces)}
        of_bending = self._moments(w, "bending")
        coupling = block_diagonal(share * energy_of_moments(*arguments, B, 2))
        return {
            "membrane": (moments, forces + coupling @ of_bending),
            "bending": (of_bending, coupling.T @ moments),
        }

    def of_moments(self) -> Any:
        """Return a function with one number a cell for each moment."""
        return _fenicsx.cell_function(self.fx, self.mesh, np.zeros((len(self.cells), len(FIELDS))))

    def _moments(self, w: Any, part: str) -> sp.csr_matrix:
        """Return the moments of strains of the cells from a function, shape (11 m, N)."""
        fx, count = self.fx, len(FIELDS)
        space = self.of_moments().function_space
        numbers = _fenicsx.cell_dofs(space, len(self.cells))
        q, trial = fx.ufl.TestFunction(space), fx.ufl.TrialFunction(self.space)
        integrand = sum(q[i] * density for i, density in enumerate(self.surface.moments(trial, part)))
        matrix = self.matrix(integrand, 0)
        rows = (count * numbers[:, None] + np.arange(count)).ravel()
        return matrix[rows]

    def layer(self) -> tuple[Any, Any]:
        """Return a function for the numbers of a point of each layer, and the height of the point in m."""
        layer = _fenicsx.cell_function(self.fx, self.mesh, np.zeros((len(self.cells), 11)))
        return layer, self.surface.fields.thickness * layer[0]

    def through_thickness(self, flat: Any, curved: Any, layer: Any) -> Any:
        """Return the compiled form of `kanefe_fem.shells.forms.through_thickness`."""
        integrand = shell_forms.through_thickness(self.surface, flat, curved, layer)
        return self.fx.fem.form(integrand * self.measure(1))

    def at_points(self, form: Any, layer: Any) -> Iterator[Any]:
        """Yield the form for one point of a layer after the other."""
        for number in range(max(len(section.layers) for section in self.given.sections)):
            for end in (-1.0, 1.0):
                values = self._of_sections(lambda one, n=number, e=end: _point_of_layer(one, n, e))
                _fenicsx.put_in_cells(layer, values)
                yield form


def blocks_at_nodes(matrix: sp.csr_matrix, node: np.ndarray, count: int) -> sp.csr_matrix:
    """Return a matrix of whole blocks in the order of `count` nodes.

    Parameters
    ----------
    matrix : csr_matrix, shape (6 k, 6 k)
        Of whole blocks (6, 6), as FEniCSx makes it; not changed.
    node : ndarray of int, shape (k,)
        Node of each block.
    count : int
    """
    starts = matrix.indptr[::6] // 36
    width = np.diff(starts)
    # pieces of six entries: `upper` is the number of the piece in the first row of each block
    upper = np.repeat(5 * starts[:-1], width) + np.arange(starts[-1])
    columns = matrix.indices[6 * upper] // 6
    places = np.repeat(node, width), node[columns]
    block = sp.csr_matrix((np.arange(starts[-1]), places), shape=(count, count))  # number of each block, moved
    own_width = np.diff(block.indptr)
    beside = np.repeat(own_width, own_width)
    moved = np.repeat(5 * block.indptr[:-1], own_width) + np.arange(block.nnz)
    source, column = np.empty((2, 6 * block.nnz), dtype=matrix.indices.dtype)
    for row in range(6):
        source[moved + row * beside] = upper[block.data] + row * beside
        column[moved + row * beside] = 6 * block.indices
    indptr = np.append(0, np.cumsum(np.repeat(6 * own_width, 6)))
    indices = (column[:, None] + np.arange(6, dtype=column.dtype)).ravel()
    return sp.csr_matrix((matrix.data.reshape(-1, 6)[source].ravel(), indices, indptr), shape=(6 * count, 6 * count))


def cell_sizes(element: Shape, corners: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the area of cells in m2, and how far they rise over their chords, in m, shapes (m,).

    The rise is the second fundamental form along the edges of the reference cell, ``x,a . n,b``, its mean square.
    """
    points, weights = quadrature(element.kind, 5)
    gradients = element.gradients(points)
    J, turned = (np.einsum("pna,mni->mpia", gradients, field) for field in (corners, normals))
    stretch = weights * np.linalg.norm(np.cross(J[..., 0], J[..., 1]), axis=2)
    form = np.einsum("mpia,mpib->mpab", J, turned)
    area = stretch.sum(axis=1)
    return area, np.sqrt(np.einsum("mp,mpab,mpab->m", stretch, form, form) / area)


def _moduli(section: ShellSection) -> np.ndarray:
    """Return the upper triangles of A1, B1, D1 and S1, shape (21,)."""
    upper = [section.stiffness(power)[np.triu_indices(3)] for power in range(3)]
    return np.concatenate((*upper, section.shear[np.triu_indices(2)]))


def _point_of_layer(section: ShellSection, number: int, end: float) -> np.ndarray:
    """Return height, weight and moduli of one of the two points of a layer, shape (11,); zeros if there is none."""
    if number >= len(section.layers):
        return np.zeros(11)
    layer = section.layers[number]
    half = (layer.top - layer.bottom) / 2.0
    height = layer.bottom + half * (1.0 + end / np.sqrt(3.0))
    scale = section.shear_scale
    plane, shear = layer.plane[np.triu_indices(3)], (scale * layer.shear)[np.triu_indices(2)]
    return np.concatenate(((height, half), plane, shear))
