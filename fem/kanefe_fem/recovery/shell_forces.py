"""Section forces of shells: membrane forces, moments and shear forces per length, from the stresses in the layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.recovery.scalars import PLANE
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_strains import axes_about

NAMES = ("N11", "N22", "N12", "M11", "M22", "M12", "Q1", "Q2")

GAUSS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class ShellForces:
    """Section forces of a shell at P places, one for each side of a fold and each group at a node; T times.

    Of a smooth shell of one group the places are its nodes. Forces are per length of the meshed surface; moments are
    about the middle of the thickness, and positive if they stretch the top.

    Attributes
    ----------
    times : ndarray, shape (T,)
        s.
    nodes : ndarray of int, shape (P,)
        Node of each place.
    positions : ndarray, shape (P, 3)
        m, in G.
    axes : ndarray, shape (P, 3, 3)
        Axes 1 and 2 of the forces and the normal as rows, in G.
    forces : ndarray, shape (T, P, 8)
        N11, N22, N12 and Q1, Q2 in N/m, M11, M22, M12 in N: the order is that of `NAMES`.
    """

    times: np.ndarray
    nodes: np.ndarray
    positions: np.ndarray
    axes: np.ndarray
    forces: np.ndarray

    def __getitem__(self, name: str) -> np.ndarray:
        """Return one of N11, N22, N12, M11, M22, M12, Q1, Q2, shape (T, P)."""
        if name not in NAMES:
            raise ModelError(f"there is no section force {name!r} of a shell. There are: {', '.join(NAMES)}")
        return self.forces[..., NAMES.index(name)]


def shell_forces(
    fields: ShellStrainFields, times: np.ndarray, eta: np.ndarray, along: Sequence[float] | np.ndarray | None = None
) -> ShellForces:
    """Return the section forces at coordinates (T, k).

    Parameters
    ----------
    fields : ShellStrainFields
    times : ndarray, shape (T,)
    eta : ndarray, shape (T, k)
    along : array_like, shape (3,), optional
        Direction in G whose part in the surface is axis 1. Default: axis 1 of the material; of one material without
        axes, x, or y where the surface is across x.

    Raises
    ------
    ModelError
        If the direction is not valid, or is across the surface somewhere.
    """
    points, stack = fields.shell.at_places, fields.stack
    parts = fields.shell.strains("nodes", eta)
    turn, axes = _turned_axes(points.axes, along, fields.name)
    middle = stack.heights_of(points.section).mean(axis=-1)
    t = points.thickness
    N, M = np.zeros((2, len(eta), len(t), 2, 2))
    for ply in range(stack.most_layers):
        for place, weight in zip(*GAUSS, strict=True):
            level = fields.in_ply(points, ply, 0.5 * (1.0 + place))
            height, part = level.height, np.diff(stack.heights[level.layer], axis=1)[:, 0]
            stress = np.nan_to_num(fields.stress(points, parts, level)[..., PLANE])
            s = np.stack((stress[..., 0], stress[..., 2], stress[..., 2], stress[..., 1]), axis=-1)
            cut = _cofactor(np.eye(2) + (height * t)[:, None, None] * np.swapaxes(points.curvature, 1, 2))
            force = 0.5 * (weight * t * part)[:, None, None] * (s.reshape(*N.shape) @ cut)
            N += force
            M += ((height - middle) * t)[:, None, None] * force
    Q = np.einsum("p,pij,pjt->tpi", t, stack.forces[points.section], parts[1], optimize=True)
    N, M = (turn @ X @ np.swapaxes(turn, 1, 2) for X in (N, M))
    Q = np.einsum("pij,tpj->tpi", turn, Q)
    columns = [(X[..., 0, 0], X[..., 1, 1], 0.5 * (X[..., 0, 1] + X[..., 1, 0])) for X in (N, M)]
    forces = np.stack((*columns[0], *columns[1], Q[..., 0], Q[..., 1]), axis=-1)
    nodes = stack.places.node
    return ShellForces(times, nodes, fields.nodes[nodes], axes, forces)


def _turned_axes(
    own: np.ndarray, along: Sequence[float] | np.ndarray | None, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return axes along a direction in those of the places (P, 2, 2), and in G (P, 3, 3)."""
    if along is None:
        return np.broadcast_to(np.eye(2), (len(own), 2, 2)), own
    given = numbers(along)
    if given.shape != (3,) or not np.isfinite(given).all() or not given.any():
        raise ModelError(f"along={along!r} of section forces of {name!r}. Remedy: a direction in G")
    direction = given / np.linalg.norm(given)
    if np.abs(own[:, 2] @ direction).max() > 0.995:
        raise ModelError(
            f"along={along!r} is across the surface of {name!r} somewhere. Remedy: another direction, or None"
        )
    axes = axes_about(own[:, 2], np.broadcast_to(direction, (len(own), 3)))
    return axes[:, :2] @ np.swapaxes(own[:, :2], 1, 2), axes


def _cofactor(matrix: np.ndarray) -> np.ndarray:
    """Return ``det(S) S^-T`` of matrices (..., 2, 2): cuts at a height from those of the surface."""
    a, b, c, d = (matrix[..., i, j] for i in range(2) for j in range(2))
    return np.stack((d, -c, -b, a), axis=-1).reshape(matrix.shape)
