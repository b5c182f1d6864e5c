"""Strains of the surface of a shell at its places and at the centres of its cells, by coordinates.

At a node they are means over the cells that meet on one side of it and have one section.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import shape
from kanefe.fe_model.shell_stack import ShellStack
from kanefe.results.body_shape import BodyShape
from kanefe_fem.recovery.cell_strains import centroid, gauss_samples
from kanefe_fem.recovery.shell_strains import (
    ShellCellData,
    SurfaceStrains,
    at_nodes,
    axes_about,
    axes_on,
    pulled_back,
    surface_strains,
)
from kanefe_fem.recovery.strain_fields import MOST_MODES, Place

_KEPT: WeakKeyDictionary[FlexibleBody | BodyShape, ShellStrains] = WeakKeyDictionary()


class Points(NamedTuple):
    """Points of a shell: its places (`kanefe.fe_model.shell_stack.FacePlaces`) or the centres of its cells.

    Attributes
    ----------
    section : ndarray of int, shape (p,)
    thickness : ndarray, shape (p,)
        m.
    axes : ndarray, shape (p, 3, 3)
        Axes 1 and 2 of the section and the director as rows, in G.
    curvature : ndarray, shape (p, 2, 2)
        Derivatives of the director along the axes, 1/m.
    """

    section: np.ndarray
    thickness: np.ndarray
    axes: np.ndarray
    curvature: np.ndarray


class ShellStrains:
    """Strains of the surface of a shell by coordinates, from which all fields follow; kept for a body."""

    def __init__(self, nodes: np.ndarray, basis: np.ndarray, cells: tuple[Cells, ...], stack: ShellStack) -> None:
        self.nodes, self.cells, self.stack = nodes, cells, stack
        self.basis = basis
        self._modes: dict[str, tuple[np.ndarray, np.ndarray]] = {}

    @classmethod
    def of_body(cls, body: BodyShape) -> ShellStrains:
        """Return those of a body, made once for it."""
        key: FlexibleBody | BodyShape = body if body.flexible is None else body.flexible
        if key not in _KEPT:
            stack = body.elasticity.shell if body.elasticity is not None else None
            if stack is None:
                raise ModelError(f"body {body.name!r} is no shell")
            cells = tuple(block for block in body.cells if shape(block.kind).dimension == 2)
            _KEPT[key] = cls(body.nodes, body.basis, cells, stack)
        return _KEPT[key]

    @cached_property
    def data(self) -> list[ShellCellData]:
        """The cells of each block."""
        made, corner, cell = [], 0, 0
        for block in self.cells:
            own = slice(corner, corner + block.nodes.size)
            made.append(
                ShellCellData(
                    self.nodes[block.nodes],
                    self.stack.directors[self.stack.sides[own]].reshape(*block.nodes.shape, 3),
                    self.stack.along[cell : cell + len(block.nodes)],
                    self.stack.thickness[own].reshape(block.nodes.shape),
                )
            )
            corner, cell = corner + block.nodes.size, cell + len(block.nodes)
        return made

    @cached_property
    def axes(self) -> np.ndarray:
        """Axes of the places as rows (P, 3, 3): of one material without axes, those along x or, across it, y."""
        places, stack = self.stack.places, self.stack
        along = self._mean(stack.along[stack.cells])
        any_axis = stack.is_isotropic[places.section]
        along[any_axis] = default_axis(places.director[any_axis])
        return axes_about(places.director, along)

    @cached_property
    def at_places(self) -> Points:
        """The places."""
        places, turn = self.stack.places, self._to_places
        own = np.concatenate([found.curvature.reshape(-1, 2, 2) for found in self._at_corners(None)])
        curvature = self._mean(np.swapaxes(turn, 1, 2) @ own @ turn)
        return Points(places.section, places.thickness, self.axes, curvature)

    @cached_property
    def at_centres(self) -> Points:
        """The centres of the cells."""
        axes, thickness, curvature = [], [], []
        for block, data in zip(self.cells, self.data, strict=True):
            element, middle = shape(block.kind), centroid(block.kind)
            J = np.einsum("pna,mni->mpia", element.gradients(middle), data.x)
            axes.append(axes_on(J, data.along)[:, 0])
            thickness.append(data.thickness @ element.values(middle)[0])
            still = np.zeros((*block.nodes.shape, 6, 1))
            curvature.append(surface_strains(block.kind, data, still, middle).curvature[:, 0])
        return Points(*(np.concatenate(x) for x in ([self.stack.of_cell], thickness, axes, curvature)))

    def places_of(self, nodes: np.ndarray) -> np.ndarray:
        """Return the places at the nodes of a cell, which is given by these, shape (nodes per cell,)."""
        start = 0
        for block in self.cells:
            if block.nodes.shape[1] == len(nodes):
                for row in np.flatnonzero((block.nodes == nodes).all(axis=1)):
                    first = start + row * len(nodes)
                    return self.stack.places.of_corners[first : first + len(nodes)]
            start += block.nodes.size
        raise ModelError(f"there is no cell with the nodes {nodes.tolist()}")

    def points(self, at: Place) -> Points:
        """Return the places for "nodes", or the centres for "cells"."""
        if at == "gauss":
            raise ModelError("fields of a shell are at nodes and at the centres of cells, not at 'gauss' points")
        return self.at_places if at == "nodes" else self.at_centres

    def strains(self, at: Place, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return X0, X1, X2 (3, p, 3, T) and the shear strains (p, 2, T) in the axes of the points, of eta (T, k)."""
        count = self.basis.shape[1]
        if count > MOST_MODES:
            return self._evaluated(at, np.asarray(self.basis @ eta.T))
        if at not in self._modes:
            basis = self.basis if isinstance(self.basis, np.ndarray) else self.basis.toarray()
            self._modes[at] = self._evaluated(at, basis)
        in_plane, shear = self._modes[at]
        return np.tensordot(in_plane, eta, axes=(-1, -1)), np.tensordot(shear, eta, axes=(-1, -1))

    def _evaluated(self, at: Place, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u = motion.reshape(len(self.nodes), 6, -1)
        if at == "cells":
            found = [
                surface_strains(block.kind, data, u[block.nodes], centroid(block.kind))
                for block, data in zip(self.cells, self.data, strict=True)
            ]
            in_plane = np.concatenate([one.in_plane[:, :, 0] for one in found], axis=1)
            return in_plane, np.concatenate([one.shear[:, 0] for one in found])
        corners = self._at_corners(u)
        flat = [one.in_plane.reshape(3, -1, 3, u.shape[2]) for one in corners]
        back = self._to_places[:, None]
        in_plane = pulled_back(np.moveaxis(np.concatenate(flat, axis=1), 1, 0), back)
        shear = np.concatenate([one.shear.reshape(-1, 2, u.shape[2]) for one in corners])
        shear = np.einsum("qba,qbc->qac", self._to_places, shear)
        return np.moveaxis(self._mean(in_plane), 0, 1), self._mean(shear)

    def samples(self, cells: np.ndarray, eta: np.ndarray) -> tuple[np.ndarray, Points, tuple[np.ndarray, np.ndarray]]:
        """Return places (p, 3) in m, points and strains (see `strains`) of cells, by number, where strains are best."""
        u, start, found = np.asarray(self.basis @ eta.T).reshape(len(self.nodes), 6, -1), 0, []
        for block, data in zip(self.cells, self.data, strict=True):
            own = cells[(cells >= start) & (cells < start + len(block.nodes))]
            cell, start = own - start, start + len(block.nodes)
            if not len(cell):
                continue
            part, points = ShellCellData(*(values[cell] for values in data)), gauss_samples(block.kind).points
            element, count = shape(block.kind), len(points)
            N = element.values(points)
            one = surface_strains(block.kind, part, u[block.nodes[cell]], points)
            axes = axes_on(np.einsum("pna,mni->mpia", element.gradients(points), part.x), part.along)
            found.append(
                (
                    np.einsum("pn,mni->mpi", N, part.x).reshape(-1, 3),
                    np.repeat(self.stack.of_cell[own], count),
                    (part.thickness @ N.T).ravel(),
                    axes.reshape(-1, 3, 3),
                    one.curvature.reshape(-1, 2, 2),
                    one.in_plane.reshape(3, -1, 3, len(eta)),
                    one.shear.reshape(-1, 2, len(eta)),
                )
            )
        places, *rest, in_plane, shear = (
            np.concatenate(values, axis=int(number == 5)) for number, values in enumerate(zip(*found, strict=True))
        )
        return places, Points(*rest), (in_plane, shear)

    def _at_corners(self, u: np.ndarray | None) -> list[SurfaceStrains]:
        """Return the strains at the nodes of the cells of each block; without displacements their curvature."""
        still = np.zeros((len(self.nodes), 6, 1)) if u is None else u
        return [
            at_nodes(block.kind, data, still[block.nodes]) for block, data in zip(self.cells, self.data, strict=True)
        ]

    @cached_property
    def _to_places(self) -> np.ndarray:
        """Axes of the places in those of the cells at their nodes, as columns, shape (q, 2, 2)."""
        places, stack = self.stack.places, self.stack
        own = axes_about(places.director[places.of_corners], stack.along[stack.cells])
        to = self.axes[places.of_corners]
        return np.asarray(own[:, :2] @ np.swapaxes(to[:, :2], 1, 2))

    def _mean(self, values: np.ndarray) -> np.ndarray:
        """Return the means at the places of values at the nodes of the cells (q, ...)."""
        mean = self._means @ values.reshape(len(values), -1)
        return np.asarray(mean.reshape(-1, *values.shape[1:]))

    @cached_property
    def _means(self) -> sp.csr_matrix:
        of = self.stack.places.of_corners
        counts = np.bincount(of)
        return sp.csr_matrix((1.0 / counts[of], (of, np.arange(len(of)))), shape=(len(counts), len(of)))


def default_axis(normal: np.ndarray) -> np.ndarray:
    """Return x for each normal (n, 3), or y where the surface is nearly across x."""
    return np.where(np.abs(normal[:, :1]) < 0.9, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
