"""Strain and stress fields of one body at given coordinates.

A field is linear in the coordinates eta, so its modes (the fields of unit coordinates) are computed once, and a field
at one time is one matrix product. For bodies with very many coordinates (unreduced ones), fields are computed from the
displacements instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Literal
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, TRANSLATIONS, Cells, Elasticity
from kanefe.fe_model.shapes import is_supported, shape
from kanefe.fe_model.skin import skin
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.cell_strains import centroid, gauss_samples, strains
from kanefe_fem.recovery.mesh_error import Patch
from kanefe_fem.recovery.scalars import SCALARS

Tensor = Literal["strain", "stress"]
Place = Literal["nodes", "cells", "gauss"]

MOST_MODES = 150
"""Number of coordinates above which fields are computed from displacements: stress modes would take much memory."""

CHUNK = 2**22
"""Number of values in one piece of the work: 32 MiB."""

_KEPT: WeakKeyDictionary[FlexibleBody | BodyShape, StrainFields] = WeakKeyDictionary()


class StrainFields:
    """Strains and stresses of a solid or plane body.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Coordinates in G, m.
    components : tuple of str
        Degrees of freedom of every node.
    basis : ndarray or sparse matrix, shape (n components, k)
        Motion of the nodes from the coordinates.
    cells : tuple of Cells
        All of one dimension, 2 or 3.
    elasticity : Elasticity
    """

    def __init__(
        self,
        nodes: np.ndarray,
        components: tuple[str, ...],
        basis: np.ndarray | sp.spmatrix,
        cells: tuple[Cells, ...],
        elasticity: Elasticity,
    ) -> None:
        self.nodes = nodes
        self.components = components
        self.basis = basis
        self.cells = cells
        self.elasticity = elasticity
        self._modes: dict[tuple[str, str, int | None], np.ndarray] = {}

    @classmethod
    def of_body(cls, name: str, body: BodyShape) -> StrainFields:
        """Return the fields of a body, made once for it.

        Raises
        ------
        ModelError
            If the body is not a solid or plane body with moduli.
        """
        key: FlexibleBody | BodyShape = body if body.flexible is None else body.flexible
        if key not in _KEPT:
            elasticity = checked_elasticity(name, body)
            _KEPT[key] = cls(body.nodes, body.components, body.basis, body.cells, elasticity)
        return _KEPT[key]

    @property
    def cell_count(self) -> int:
        """Number of cells."""
        return sum(len(block.nodes) for block in self.cells)

    @cached_property
    def centroids(self) -> np.ndarray:
        """Centres of the cells in G, shape (cells, 3), m."""
        return np.concatenate(
            [np.einsum("n,mnx->mx", shape(b.kind).values(centroid(b.kind))[0], self.nodes[b.nodes]) for b in self.cells]
        )

    def displacements(self, eta: np.ndarray) -> np.ndarray:
        """Return the displacements of the nodes, shape (n, 3, T), from coordinates (T, k)."""
        motion = np.asarray(self.basis @ eta.T).reshape(len(self.nodes), len(self.components), len(eta))
        moved = np.zeros((len(self.nodes), 3, len(eta)))
        for column, component in enumerate(self.components):
            if component in TRANSLATIONS:
                moved[:, COMPONENTS.index(component)] = motion[:, column]
        return moved

    def evaluate(self, what: Tensor, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a field at coordinates.

        Parameters
        ----------
        what : {"strain", "stress"}
        at : {"nodes", "cells", "gauss"}
        eta : ndarray, shape (T, k)
        material : int, optional
            Average at the nodes over the cells of this row of the table of moduli only; NaN where there are none.

        Returns
        -------
        ndarray, shape (T, n, 6), (T, cells, 6) or (T, cells, g, 6)
        """
        if self.basis.shape[1] > MOST_MODES:
            field = self._field(what, at, self.displacements(eta), material)
            return np.moveaxis(field, -1, 0)
        return np.tensordot(eta, self.modes(what, at, material), axes=(1, -1))

    @property
    def outside(self) -> tuple[Cells, ...]:
        """Cells with the nodes of the surface of the body."""
        return skin(self.cells) or self.cells

    @property
    def scalars(self) -> tuple[str, ...]:
        """Names of the scalars that there are."""
        return tuple(SCALARS)

    def scalar(self, quantity: str, at: Place, eta: np.ndarray, material: int | None = None) -> np.ndarray:
        """Return a scalar of the stress, shape (T, n) or (T, cells), from coordinates (T, k)."""
        return SCALARS[quantity](self.evaluate("stress", at, eta, material))

    def several(
        self, quantities: Sequence[str], at: Place, eta: np.ndarray, material: int | None = None
    ) -> dict[str, np.ndarray]:
        """Return scalars, "stress" and "strain" by their names; the stress is evaluated once."""
        tensors: tuple[Tensor, ...] = ("stress", "strain")
        asked = {"stress" if name in SCALARS else name for name in quantities}
        found = {what: self.evaluate(what, at, eta, material) for what in tensors if what in asked}
        return {name: found[name] if name in found else SCALARS[name](found["stress"]) for name in quantities}

    def modes(self, what: Tensor, at: Place, material: int | None = None) -> np.ndarray:
        """Return the field of every unit coordinate, shape (n, 6, k), (cells, 6, k) or (cells, g, 6, k); kept."""
        key = (what, at, material)
        if key not in self._modes:
            self._modes[key] = self._field(what, at, self.displacements(np.eye(self.basis.shape[1])), material)
            self._modes[key].flags.writeable = False
        return self._modes[key]

    def surface_modes(self, material: int | None = None) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield nodes of the surface (r,), and the stress there of every unit coordinate, (r, 6, k)."""
        blocks = self.outside
        every = np.arange(len(self.nodes))  # of elements of the user without cells
        outside = np.unique(np.concatenate([block.nodes.ravel() for block in blocks])) if blocks else every
        part, numbers = self.around(outside)
        yield outside, part.modes("stress", "nodes", material)[numbers]

    def chosen_cells(self, material: int | None) -> np.ndarray:
        """Return which cells have the material, shape (cells,); all if it is None."""
        if material is None:
            return np.ones(self.cell_count, dtype=bool)
        return self.elasticity.of_cell == material

    def patches(self, node: int, eta: np.ndarray, material: int | None = None) -> list[Patch]:
        """Return the stresses around a node for coordinates (1, k), of each material there or of one."""
        ring = np.unique(np.concatenate([b.nodes[(b.nodes == node).any(axis=1)].ravel() for b in self.cells]))
        part, numbers = self.around(ring)
        here, u = numbers[np.searchsorted(ring, node)], part.displacements(eta)
        meeting = np.concatenate([(block.nodes == here).any(axis=1) for block in part.cells])
        found, own = [], part.elasticity.of_cell
        for row in np.unique(own[meeting]) if material is None else [material]:
            places, stresses, order = [], [], 0
            for kind, cell, table in part._pieces(1, own == row):
                points = gauss_samples(kind).points if shape(kind).order > 1 else centroid(kind)
                places.append(np.einsum("pn,mni->mpi", shape(kind).values(points), part.nodes[table]).reshape(-1, 3))
                stresses.append(part._at_points("stress", kind, cell, table, u, points).reshape(-1, 6))
                order = max(order, shape(kind).order)
            mean = part._averaged("stress", u, row)[here, :, 0]
            found.append(Patch(np.concatenate(places) - part.nodes[here], np.concatenate(stresses), mean, order))
        return found

    def around(self, chosen: np.ndarray) -> tuple[StrainFields, np.ndarray]:
        """Return the fields of only those cells that touch some nodes, and the numbers of these nodes there."""
        touched = [np.isin(block.nodes, chosen).any(axis=1) for block in self.cells]
        kept = [block.nodes[rows] for block, rows in zip(self.cells, touched, strict=True)]
        used = np.unique(np.concatenate([nodes.ravel() for nodes in kept]))
        width = len(self.components)
        part = StrainFields(
            self.nodes[used],
            self.components,
            self.basis[(used[:, None] * width + np.arange(width)).ravel()],
            tuple(Cells(b.kind, np.searchsorted(used, nodes)) for b, nodes in zip(self.cells, kept, strict=True)),
            Elasticity(self.elasticity.table, self.elasticity.of_cell[np.concatenate(touched)]),
        )
        return part, np.searchsorted(used, chosen)

    def _field(self, what: Tensor, at: Place, u: np.ndarray, material: int | None) -> np.ndarray:
        if at == "nodes":
            return self._averaged(what, u, material)
        pieces = []
        for kind, numbers, cells in self._pieces(u.shape[2], self.chosen_cells(None)):
            points = centroid(kind) if at == "cells" else gauss_samples(kind).points
            pieces.append(self._at_points(what, kind, numbers, cells, u, points))
        if at == "gauss" and len({piece.shape[1] for piece in pieces}) > 1:
            raise ModelError("cells of different shapes have different Gauss points. Remedy: at='cells'")
        field = np.concatenate(pieces)
        return field[:, 0] if at == "cells" else field

    def _averaged(self, what: Tensor, u: np.ndarray, material: int | None) -> np.ndarray:
        """Return the means over the adjacent cells of each node, shape (n, 6, columns)."""
        count = len(self.nodes)
        total, meeting = np.zeros((count, 6 * u.shape[2])), np.zeros(count)
        for kind, numbers, cells in self._pieces(u.shape[2], self.chosen_cells(material)):
            samples = gauss_samples(kind)
            values = self._at_points(what, kind, numbers, cells, u, samples.points)
            at_nodes = np.tensordot(values, samples.to_nodes, axes=(1, 1))  # (m, 6, columns, nodes)
            rows = np.moveaxis(at_nodes, -1, 1).reshape(cells.size, -1)
            gather = sp.csr_matrix((np.ones(cells.size), (cells.ravel(), np.arange(cells.size))), (count, cells.size))
            total += gather @ rows
            meeting += np.bincount(cells.ravel(), minlength=count)
        with np.errstate(invalid="ignore"):  # 0 / 0 = NaN is intended where no cell has the material
            return (total / meeting[:, None]).reshape(count, 6, -1)

    def _at_points(
        self, what: Tensor, kind: str, numbers: np.ndarray, cells: np.ndarray, u: np.ndarray, points: np.ndarray
    ) -> np.ndarray:
        values = strains(kind, self.nodes[cells], u[cells], points)
        if what == "stress":
            values = self.elasticity.table[self.elasticity.of_cell[numbers]][:, None] @ values
        return values

    def _pieces(self, columns: int, wanted: np.ndarray) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
        """Yield shape, numbers and nodes of the wanted cells, in pieces that need little memory."""
        start = 0
        for block in self.cells:
            own = np.flatnonzero(wanted[start : start + len(block.nodes)])
            size = max(1, CHUNK // (block.nodes.shape[1] * 6 * columns))
            for first in range(0, len(own), size):
                rows = own[first : first + size]
                yield block.kind, start + rows, block.nodes[rows]
            start += len(block.nodes)


def checked_elasticity(name: str, body: BodyShape) -> Elasticity:
    """Return the moduli of a solid or plane body; raise a ModelError for a body without them, and for beams."""
    elasticity = body.elasticity
    if elasticity is None or not body.cells:
        raise ModelError(
            f"body {name!r} has no moduli of its cells, so it has no stresses. Remedy: make it with "
            "kanefe_fem.solid_body; matrices from elsewhere carry no material"
        )
    if elasticity.axes is not None:
        raise ModelError(
            f"body {name!r} is made of beams, which have section forces instead of a stress field. Remedy: "
            "kanefe_fem.recover(...).section_forces()"
        )
    for block in body.cells:
        if not is_supported(block.kind) or shape(block.kind).dimension < 2:
            raise ModelError(
                f"body {name!r} has cells of the shape {block.kind}, for which there is no stress recovery"
            )
    return elasticity
