"""Strains of the cells of a shell at points of their surface, from the displacements and rotations of their nodes.

At the height z above the surface, ``e(z) = S^-T (X0 + z X1 + z^2 X2) S^-1`` with ``S = I + z n,i . a_j`` (see
`kanefe_fem.shells.forms.Surface.at`): X0 are the strains of the membrane, X1 and X2 those of bending. Strains of the
membrane are those of the stiffness: in the share that is not integrated in full, the assumed ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.fe_model.shapes import quadrature, shape
from kanefe_fem.recovery.cell_strains import centroid, gauss_samples
from kanefe_fem.shells.assumed import DEGREE, FIELDS
from kanefe_fem.shells.problem import SAGITTA, cell_sizes


class ShellCellData(NamedTuple):
    """Cells of one shape.

    Attributes
    ----------
    x, directors : ndarray, shape (m, n, 3)
        Nodes in m, and their directors.
    along : ndarray, shape (m, 3)
    thickness : ndarray, shape (m, n)
        m.
    """

    x: np.ndarray
    directors: np.ndarray
    along: np.ndarray
    thickness: np.ndarray


class SurfaceStrains(NamedTuple):
    """Strains at p points of m cells for c columns of displacements, in the axes of each point.

    Attributes
    ----------
    in_plane : ndarray, shape (3, m, p, 3, c)
        X0, X1 and X2: 11, 22 and twice 12; 1, rad/m and rad/m2.
    shear : ndarray, shape (m, p, 2, c)
        13 and 23.
    curvature : ndarray, shape (m, p, 2, 2)
        ``n,i . a_j``, 1/m.
    """

    in_plane: np.ndarray
    shear: np.ndarray
    curvature: np.ndarray


def surface_strains(kind: str, cells: ShellCellData, u: np.ndarray, points: np.ndarray) -> SurfaceStrains:
    """Return the strains at reference points (p, 2).

    Parameters
    ----------
    kind : {"quad9", "triangle6"}
    cells : ShellCellData
    u : ndarray, shape (m, n, 6, c)
        Displacements and rotations of the nodes, m and rad.
    points : ndarray, shape (p, 2)
    """
    element = shape(kind)
    gradients, values = element.gradients(points), element.values(points)
    J = np.einsum("pna,mni->mpia", gradients, cells.x)
    axes = axes_on(J, cells.along)
    back = np.linalg.inv(axes[..., :2, :] @ J)  # derivatives along a_1, a_2 from those along the edges
    tips = np.cross(np.swapaxes(u[:, :, 3:], 2, 3), cells.directors[:, :, None]).swapaxes(2, 3)
    slope, turned = (_along(gradients, back, field) for field in (u[:, :, :3], tips))  # (m, p, i, a, c)
    director = np.einsum("pn,mni->mpi", values, cells.directors)
    bent = np.einsum("pna,mni,mpab->mpib", gradients, cells.directors, back, optimize=True)
    a = axes[..., :2, :]
    first = _voigt(np.einsum("mpai,mpibc->mpabc", a, slope))
    second = _voigt(
        np.einsum("mpai,mpibc->mpabc", a, turned, optimize=True)
        + np.einsum("mpia,mpibc->mpabc", bent, slope, optimize=True)
    )
    third = _voigt(np.einsum("mpia,mpibc->mpabc", bent, turned, optimize=True))
    tip = np.einsum("pn,mnic->mpic", values, tips)
    shear = np.einsum("mpai,mpic->mpac", a, tip) + np.einsum("mpi,mpiac->mpac", director, slope)
    curvature = np.einsum("mpia,mpbi->mpab", bent, a)
    if not element.is_simplex:
        _, rise = cell_sizes(element, cells.x, cells.directors)
        share = 1.0 / (1.0 + (rise / cells.thickness.mean(axis=1)) ** 2 / SAGITTA)
        assumed = _assumed(kind, cells.x, u[:, :, :3], points, back)
        first += (1.0 - share)[:, None, None, None] * (assumed - first)
    return SurfaceStrains(np.stack((first, second, third)), shear, curvature)


def at_nodes(kind: str, cells: ShellCellData, u: np.ndarray) -> SurfaceStrains:
    """Return the strains at the nodes of cells, extrapolated from where they are best."""
    samples = gauss_samples(kind)
    found = surface_strains(kind, cells, u, samples.points)
    in_plane = np.einsum("np,kmpsc->kmnsc", samples.to_nodes, found.in_plane)
    curvature = np.einsum("np,mpab->mnab", samples.to_nodes, found.curvature)
    if shape(kind).is_simplex:  # whose shear is integrated at one point
        middle = surface_strains(kind, cells, u, centroid(kind)).shear
        return SurfaceStrains(in_plane, np.repeat(middle, len(samples.to_nodes), axis=1), curvature)
    return SurfaceStrains(in_plane, np.einsum("np,mpsc->mnsc", samples.to_nodes, found.shear), curvature)


def axes_on(J: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return a_1, a_2 and the normal as rows, (m, p, 3, 3), from tangents (m, p, 3, 2) and directions (m, 3)."""
    normal = np.cross(J[..., 0], J[..., 1])
    return axes_about(normal / np.linalg.norm(normal, axis=-1, keepdims=True), along[:, None])


def axes_about(normal: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return the part of a direction across a unit normal, the third axis and the normal as rows, (..., 3, 3)."""
    first = along - (along * normal).sum(axis=-1, keepdims=True) * normal
    first = first / np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack(np.broadcast_arrays(first, np.cross(normal, first), normal), axis=-2)


def _along(gradients: np.ndarray, back: np.ndarray, field: np.ndarray) -> np.ndarray:
    return np.einsum("pna,mnic,mpab->mpibc", gradients, field, back, optimize=True)


def _voigt(X: np.ndarray) -> np.ndarray:
    return np.stack((X[:, :, 0, 0], X[:, :, 1, 1], X[:, :, 0, 1] + X[:, :, 1, 0]), axis=2)


def _assumed(kind: str, x: np.ndarray, u: np.ndarray, points: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Return the assumed strains of the membrane (m, p, 3, c), as in `kanefe_fem.shells.assumed`."""
    element = shape(kind)
    at, weights = quadrature(kind, DEGREE)
    gradients = element.gradients(at)
    J = np.einsum("pna,mni->mpia", gradients, x)
    own = _voigt(np.einsum("mpia,pnb,mnic->mpabc", J, gradients, u, optimize=True))
    projected = np.zeros((len(x), len(points), *own.shape[2:]))
    for component, (first, last) in enumerate(((0, 4), (4, 8), (8, 11))):
        to, of = (_functions(s)[:, : last - first] for s in (points, at))
        rule = (to / FIELDS[first:last]) @ (weights[:, None] * of).T
        projected[:, :, component] = np.einsum("qp,mpc->mqc", rule, own[:, :, component])
    return pulled_back(projected, back)


def pulled_back(strains: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Return ``B^T e B`` of strains 11, 22 and twice 12, shape (..., 3, c), with B of shape (..., 2, 2)."""
    a, b, c, d = (back[..., i, j][..., None] for i in range(2) for j in range(2))
    e11, e22, e12 = np.moveaxis(strains, -2, 0)
    return np.stack(
        (
            a * a * e11 + c * c * e22 + a * c * e12,
            b * b * e11 + d * d * e22 + b * d * e12,
            2.0 * a * b * e11 + 2.0 * c * d * e22 + (a * d + b * c) * e12,
        ),
        axis=-2,
    )


def _functions(points: np.ndarray) -> np.ndarray:
    x, y = 2.0 * points.T - 1.0
    return np.stack((np.ones_like(x), x, y, x * y), axis=1)
