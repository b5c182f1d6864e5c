"""Bounds of the Jacobian inside cells: a polynomial that is positive at nodes may be negative between them.

The determinant is a polynomial, whose Bernstein coefficients bound it (convex hull), and whose coefficients at corners
are its values there. That of a pyramid is one on the cube that collapses to it, x = a (1 - z), y = b (1 - z): each of
its functions x^i y^j z^k / (1 - z)^m has m < i + j, so that no gradient has (1 - z) below. Where the coefficients leave
open whether it is positive, the cell is cut into halves, along one edge after the other, until they or a value at a
corner decide (Johnen, Remacle and Geuzaine 2013, "Geometrical validity of curvilinear finite elements").
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cache
from math import factorial, prod
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shapes import shape

CUTS = 40
"""Number of times a cell is cut into halves at most: after as many the determinant is zero somewhere, by its bounds."""

AFFINE = 1e-9
"""Distance of a node from its place in an affine cell, relative to the size of the cell, below which it is there."""


class _Basis(NamedTuple):
    """Bernstein polynomials of a determinant on one kind of cell.

    Attributes
    ----------
    places : ndarray, shape (m, d)
        Points that determine it.
    coefficients : ndarray, shape (m, m)
        From its values there to its coefficients.
    corners : ndarray of int
        Coefficients that are values at corners.
    halves : tuple of pairs of ndarray, (m, m)
        From coefficients to those on both halves, for each edge that is cut.
    """

    places: np.ndarray
    coefficients: np.ndarray
    corners: np.ndarray
    halves: tuple[tuple[np.ndarray, np.ndarray], ...]


def folded_inside(kind: str, coordinates: np.ndarray, least: float) -> np.ndarray:
    """Return which cells, positive at their nodes, have a determinant that is not positive somewhere inside.

    Parameters
    ----------
    kind : str
    coordinates : ndarray, shape (cells, nodes, d)
        Relative to the size of each cell.
    least : float
        Determinant that counts as zero.

    Returns
    -------
    ndarray of bool, shape (cells,)
    """
    element = shape(kind)
    places = np.column_stack((np.ones(len(element.nodes)), element.nodes))
    off_affine = np.eye(len(places)) - places @ np.linalg.pinv(places)
    found = np.zeros(len(coordinates), dtype=bool)
    curved = np.flatnonzero(np.abs(off_affine @ coordinates).max(axis=(1, 2)) > AFFINE)
    if not len(curved):
        return found
    basis = _basis(kind)
    across = np.swapaxes(coordinates[curved], 1, 2)
    values = np.array([np.linalg.det(across @ gradient) for gradient in element.gradients(basis.places)])
    open_ones, cells = values.T @ basis.coefficients.T, curved
    for cut in range(CUTS):
        is_open = open_ones.min(axis=1) <= least
        open_ones, cells = open_ones[is_open], cells[is_open]
        found[cells[open_ones[:, basis.corners].min(axis=1, initial=np.inf) <= least]] = True
        is_open = ~found[cells]
        open_ones, cells = open_ones[is_open], cells[is_open]
        if not len(cells):
            return found
        first, second = basis.halves[cut % len(basis.halves)]
        open_ones, cells = np.vstack((open_ones @ first.T, open_ones @ second.T)), np.tile(cells, 2)
    found[cells] = True
    return found


def _factors(kind: str) -> list[tuple[int, int]]:
    """Return (dimension, degree) of the simplices whose product is the cell, and of the determinant on each."""
    element = shape(kind)
    p, d = element.order, element.dimension
    if element.is_simplex:
        return [(d, d * (p - 1))]
    if element.corner_kind == "wedge":
        return [(2, 3 * p - 2), (1, 3 * p - 1)]
    if element.corner_kind == "pyramid":
        return [(1, degree) for degree in _degrees_on_cube(element.exponents)]
    return [(1, d * p - 1)] * d


def _degrees_on_cube(exponents: np.ndarray) -> list[int]:
    """Return the degrees in a, b and z of the determinant of a pyramid: the sums of those of its three gradients."""
    i, j, k, m = exponents.T
    in_z = k + i + j - m - 1  # of each gradient
    found = np.zeros(3, dtype=int)
    for lowered, is_there in (((1, 0), i > 0), ((0, 1), j > 0), ((0, 0), (k > 0) | (m > 0))):
        of_gradient = np.stack((i - lowered[0], j - lowered[1], in_z))[:, is_there]
        found += of_gradient.max(axis=1)
    return found.tolist()


@cache
def _basis(kind: str) -> _Basis:
    factors = _factors(kind)
    indices = [_exponents(dimension, degree) for dimension, degree in factors]
    lattices = [index / max(degree, 1) for index, (_, degree) in zip(indices, factors, strict=True)]
    if any(degree == 0 for _, degree in factors):
        lattices = [
            lattice if degree else np.full_like(lattice, 1.0 / lattice.shape[1])
            for lattice, (_, degree) in zip(lattices, factors, strict=True)
        ]
    is_pyramid = shape(kind).corner_kind == "pyramid"
    if is_pyramid:
        lattices[2] = _below_apex(lattices[2])
    inverses = [np.linalg.inv(_bernstein(index, lattice)) for index, lattice in zip(indices, lattices, strict=True)]
    halves = []
    for number, (index, lattice, inverse) in enumerate(zip(indices, lattices, inverses, strict=True)):
        if len(index) == 1:  # constant along this factor
            continue
        for i, j in itertools.combinations(range(lattice.shape[1]), 2):
            pair = []
            for keep, move in ((i, j), (j, i)):
                cut = np.eye(lattice.shape[1])  # rows are the corners of the half
                cut[move] = 0.5 * (cut[keep] + cut[move])
                own = inverse @ _bernstein(index, lattice @ cut)
                whole = [own if n == number else np.eye(len(x)) for n, x in enumerate(indices)]
                pair.append(_product(whole))
            halves.append((pair[0], pair[1]))
    corners = [index.max(axis=1) == degree for index, (_, degree) in zip(indices, factors, strict=True)]
    is_corner = np.array([all(at) for at in itertools.product(*corners)])
    places = np.array([np.concatenate([b[1:] for b in at]) for at in itertools.product(*lattices)])
    if is_pyramid:
        places[:, :2] = (2.0 * places[:, :2] - 1.0) * (1.0 - places[:, 2:])
    return _Basis(places, _product(inverses), np.flatnonzero(is_corner), tuple(halves))


def _below_apex(lattice: np.ndarray) -> np.ndarray:
    """Return heights that determine a polynomial like those given, without the apex, where gradients have no limit."""
    height = lattice[:, 1] * len(lattice) / (len(lattice) + 1)
    return np.column_stack((1.0 - height, height))


def _product(matrices: Sequence[np.ndarray]) -> np.ndarray:
    whole = np.ones((1, 1))
    for matrix in matrices:
        whole = np.kron(whole, matrix)
    return whole


def _exponents(dimension: int, degree: int) -> np.ndarray:
    """Return the exponents of barycentric coordinates, (m, dimension + 1), that add up to a degree."""
    found = [e for e in itertools.product(range(degree + 1), repeat=dimension + 1) if sum(e) == degree]
    return np.array(found)


def _bernstein(exponents: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """Return the Bernstein polynomials at points of a simplex, (points, m)."""
    degree = int(exponents[0].sum())
    counts = np.array([factorial(degree) / prod(map(factorial, e)) for e in exponents.tolist()])
    return np.asarray(counts * np.prod(barycentric[:, None, :] ** exponents, axis=2))
