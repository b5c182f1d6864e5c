"""Mass of a shell as points on three surfaces, which only translate.

The mass of a line through the thickness is that of three points on the director, `ShellSection.points`. At a height z
the area is ``det(I + z n,i)`` times as large as on the surface, so that mass and inertia of a curved shell are those of
the volume that the directors sweep (its moments are polynomials of degree four in z).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import MassField
from kanefe.fe_model.shapes import quadrature, shape
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.problem import ShellCells

DEGREE = {"quad9": 7, "triangle6": 8}
"""Degree of quadrature of the mass: exact for flat cells with curved sides."""


class _Surface(NamedTuple):
    """Points on one of the surfaces: side of a node, height in m, and the mass matrix of the points."""

    side: np.ndarray
    height: np.ndarray
    mass: sp.csr_matrix


def mass_field(nodes: np.ndarray, directors: Directors, blocks: Sequence[ShellCells]) -> MassField:
    """Return the mass of a shell.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    directors : Directors
    blocks : sequence of ShellCells
    """
    surfaces = [_surface(nodes, directors, blocks, number) for number in range(3)]
    points, interpolation, turns, arms = [], [], [], []
    for surface in surfaces:
        node, normal = directors.node[surface.side], directors.normal[surface.side]
        arm = surface.height[:, None] * normal
        points.append(nodes[node] + arm)
        arms.append(arm)
        interpolation.append(_rows(node, np.concatenate((_identity(len(node)), _cross(arm)), axis=2), len(nodes)))
        turn = np.concatenate((np.zeros((len(node), 3, 3)), _identity(len(node))), axis=2)
        turns.append(_rows(node, turn, len(nodes)))
    return MassField(
        points=np.concatenate(points),
        mass=sp.block_diag([surface.mass for surface in surfaces], format="csr"),
        interpolation=sp.vstack(interpolation).tocsr(),
        turns=sp.vstack(turns).tocsr(),
        arms=np.concatenate(arms),
    )


def _surface(nodes: np.ndarray, directors: Directors, blocks: Sequence[ShellCells], number: int) -> _Surface:
    """Return the points at one of the heights of each section, one for each side and height of a node."""
    sides, heights, matrices = [], [], []
    for block in blocks:
        height, values, masses = _at_height(nodes, directors, block, number)
        sides.append(block.sides)
        heights.append(height)
        pairs = np.einsum("pk,pl->pkl", values, values).reshape(len(values), -1)
        matrices.append((masses @ pairs).reshape(-1, *2 * values.shape[1:]))
    side = np.concatenate([one.ravel() for one in sides])
    height = np.concatenate([one.ravel() for one in heights])
    key = np.stack((side.astype(float), np.round(height / max(np.abs(height).max(), 1e-300), 12)), axis=1)
    _, first, place = np.unique(key, axis=0, return_index=True, return_inverse=True)
    rows, columns, start = [], [], 0
    for one, matrix in zip(sides, matrices, strict=True):
        own = place.ravel()[start : start + one.size].reshape(one.shape)
        rows.append(np.broadcast_to(own[:, :, None], matrix.shape).ravel())
        columns.append(np.broadcast_to(own[:, None, :], matrix.shape).ravel())
        start += one.size
    values = np.concatenate([matrix.ravel() for matrix in matrices])
    places = (np.concatenate(rows), np.concatenate(columns))
    return _Surface(side[first], height[first], sp.csr_matrix((values, places), shape=(len(first),) * 2))


def masses_of_sections(nodes: np.ndarray, directors: Directors, blocks: Sequence[ShellCells]) -> np.ndarray:
    """Return the mass of the cells of each section, kg, from the arguments of `mass_field`."""
    total = np.zeros(max(len(block.sections) for block in blocks))
    for block in blocks:
        for number in range(3):
            np.add.at(total, block.of_cell, _at_height(nodes, directors, block, number)[2].sum(axis=1))
    return total


def _at_height(
    nodes: np.ndarray, directors: Directors, block: ShellCells, number: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return one of the heights of each section at nodes, shape functions (p, n), and masses of points (m, p), kg."""
    fraction, share = (np.array([one.points[i][number] for one in block.sections]) for i in range(2))
    height = fraction[block.of_cell][:, None] * block.thickness
    density = (share * [section.mass(0) for section in block.sections])[block.of_cell]
    element = shape(block.cells.kind)
    points, weights = quadrature(block.cells.kind, DEGREE[block.cells.kind])
    values, gradients = element.values(points), element.gradients(points)
    x, n = nodes[block.cells.nodes], directors.normal[block.sides]
    along = np.concatenate(np.moveaxis(gradients, 2, 0))  # derivatives along both edges, at all points
    tangents, bent = ((along @ field).reshape(len(x), 2, -1, 3) for field in (x, n))
    tangents += (height @ values.T)[:, None, :, None] * bent
    # the volume between a surface and one a little higher: along the director, not the normal of the cell
    stretch = np.einsum("mpi,mpi->mp", np.cross(tangents[:, 0], tangents[:, 1]), values @ n)
    return height, values, density[:, None] * (block.thickness @ values.T) * stretch * weights


def _rows(node: np.ndarray, blocks: np.ndarray, count: int) -> sp.csr_matrix:
    """Return a matrix whose rows 3 i to 3 i + 2 have a block (3, 6) at a node."""
    return sp.bsr_matrix((blocks, node, np.arange(len(node) + 1)), shape=(3 * len(node), 6 * count)).tocsr()


def _identity(count: int) -> np.ndarray:
    return np.broadcast_to(np.eye(3), (count, 3, 3))


def _cross(arm: np.ndarray) -> np.ndarray:
    """Return matrices that give ``theta x arm`` from theta, shape (k, 3, 3)."""
    matrix = np.zeros((len(arm), 3, 3))
    matrix[:, 0, 1], matrix[:, 1, 2], matrix[:, 2, 0] = arm[:, 2], arm[:, 0], arm[:, 1]
    return matrix - np.swapaxes(matrix, 1, 2)
