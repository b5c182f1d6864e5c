"""Strain gauges and rosettes: the strain at a point of the mesh along given directions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import Shape, shape
from kanefe.frames import numbers
from kanefe_fem.recovery.scalars import along
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.strain_fields import StrainFields

REACH = 0.1
"""Largest distance of a point from the mesh, relative to the size of the nearest cell: straight sides are chords of
curved surfaces."""


CANDIDATES = 64
"""Number of cells that are searched: those with the nearest centres."""


@dataclass(frozen=True, eq=False)
class MeshPoint:
    """A point of a mesh.

    Attributes
    ----------
    nodes : ndarray of int, shape (nodes per cell,)
        Nodes of the cell that contains the point.
    weights : ndarray, shape (nodes per cell,)
        Values of its shape functions at the point, the weights of nodal values in the value at the point.
    position : ndarray, shape (3,)
        Position on the mesh, in G, m.
    """

    nodes: np.ndarray
    weights: np.ndarray
    position: np.ndarray


def find_point(
    nodes: np.ndarray, cells: tuple[Cells, ...], wanted: np.ndarray, point: np.ndarray, slack: float = 0.0
) -> MeshPoint:
    """Return a point in the chosen cells of a mesh, the nearest one if the given point lies just outside.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        Coordinates in m.
    cells : tuple of Cells
    wanted : ndarray of bool, shape (cells,)
        Which cells are searched.
    point : ndarray, shape (3,)
        Position in G, m.
    slack : float
        Distance from the mesh that is allowed anyway, m.

    Raises
    ------
    ModelError
        If the point lies outside by more than a tenth of a cell; the message names the nearest point.
    """
    best: tuple[float, float, MeshPoint] | None = None
    start = 0
    for block in cells:
        element = shape(block.kind)
        table = block.nodes[wanted[start : start + len(block.nodes)]]
        start += len(block.nodes)
        if not len(table) or element.dimension == 1:
            continue
        corners = nodes[table[:, : element.corners]]
        near = np.argsort(np.linalg.norm(corners.mean(axis=1) - point, axis=1), kind="stable")[:CANDIDATES]
        for number in near:
            x = nodes[table[number]]
            size = float(np.linalg.norm(np.ptp(x, axis=0)))
            s = _clamped(element, _reference_coordinates(element, x, point))
            weights = element.values(s[None])[0]
            place = weights @ x
            distance = float(np.linalg.norm(place - point))
            if best is None or distance < best[0]:
                best = (distance, size, MeshPoint(table[number], weights, place))
            if distance <= 1e-9 * size:
                return best[2]
    if best is None:
        raise ModelError(
            "no cell with a surface has this material: beams have none. Remedy: choose one of those it has"
        )
    distance, size, found = best
    if distance > REACH * size + slack:
        raise ModelError(
            f"the point {point.tolist()} lies {distance:.3g} m outside of the mesh; the nearest point of it is "
            f"{found.position.round(9).tolist()}. Remedy: give a point of the body in its mesh frame G, in m"
        )
    return found


def _reference_coordinates(element: Shape, x: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return s with x(s) = point, by Newton's method; for a cell in a plane, the nearest s."""
    s = element.nodes[: element.corners].mean(axis=0)
    for _ in range(20):
        miss = element.values(s[None])[0] @ x - point
        step = np.linalg.lstsq(x.T @ element.gradients(s[None])[0], miss, rcond=None)[0]
        s = s - np.clip(step, -0.5, 0.5)  # far outside of a curved cell, its mapping is not invertible
        if np.abs(step).max() < 1e-13:
            break
    return s


def _clamped(element: Shape, s: np.ndarray) -> np.ndarray:
    """Return the reference coordinates moved into the cell."""
    if not element.is_simplex:
        return np.clip(s, 0.0, 1.0)
    barycentric = np.maximum(np.append(s, 1.0 - s.sum()), 0.0)
    return barycentric[:-1] / barycentric.sum()


Vector = Sequence[float] | np.ndarray


def gauge_strains(
    fields: StrainFields, eta: np.ndarray, position: Vector, directions: Sequence[Vector], material: int | None
) -> np.ndarray:
    """Return the strains along directions (d, 3) of G at a point (3,) of G in m, at coordinates (T, k), shape (T, d).

    The strain at the nodes (means over the adjacent cells) is interpolated in the cell that contains the point.

    Raises
    ------
    ModelError
        If the position is not on the mesh, or a direction is not a finite vector other than zero.
    """
    place = np.asarray(position, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ModelError(f"position={position!r} of a gauge. Remedy: give three coordinates in G, in m")
    rows = np.array([along(unit("direction", direction)) for direction in directions])
    if isinstance(fields, ShellStrainFields):
        thickness = float(fields.stack.thickness.max())
        found = find_point(fields.nodes, fields.cells, fields.chosen_cells(material), place, thickness)
        return np.asarray(fields.strain_at(found.nodes, found.weights, place - found.position, eta) @ rows.T)
    found = find_point(fields.nodes, fields.cells, fields.chosen_cells(material), place)
    part, numbers = fields.around(found.nodes)
    modes = part.modes("strain", "nodes", material)[numbers]
    return eta @ np.einsum("n,nsk,ds->kd", found.weights, modes, rows)


def rosette_directions(direction: Vector, normal: Vector, angles: Sequence[float]) -> list[np.ndarray]:
    """Return unit directions of gauges at angles (rad) about a normal, from the projection of a direction."""
    n = unit("normal", normal)
    along = np.asarray(direction, dtype=float)
    first = unit("direction, its part across the normal,", along - (along @ n) * n)
    second = np.cross(n, first)
    return [np.cos(angle) * first + np.sin(angle) * second for angle in angles]


@checked
def rosette_principal(strains: np.ndarray, angles: Sequence[float] = (0.0, np.pi / 4, np.pi / 2)) -> np.ndarray:
    """Return greatest and least strain in the surface and the angle of the greatest, from a rosette of three gauges.

    Parameters
    ----------
    strains : ndarray, shape (T, 3)
        Strains from `Recovery.rosette`.
    angles : sequence of three floats
        Angles of the gauges in rad.

    Returns
    -------
    ndarray, shape (T, 3)
        Greatest, least, and the angle in rad from the rosette's direction, in (-pi/2, pi/2].

    Raises
    ------
    ModelError
        If there are not three gauges in different directions.

    Examples
    --------
    >>> rosette_principal(np.array([[1e-3, 0.35e-3, -0.3e-3]])).round(6).tolist()
    [[0.001, -0.0003, 0.0]]
    """
    a, measured = numbers(angles), np.atleast_1d(numbers(strains))
    rows = np.column_stack([np.cos(a) ** 2, np.sin(a) ** 2, np.sin(a) * np.cos(a)])
    if a.shape != (3,) or measured.shape[-1] != 3 or abs(np.linalg.det(rows)) < 1e-9:
        raise ModelError(
            "principal strains need three gauges in three different directions: strains (..., 3), three angles; given "
            f"are {measured.shape} and {angles!r}"
        )
    xx, yy, xy = np.moveaxis(measured @ np.linalg.inv(rows).T, -1, 0)
    centre, radius = 0.5 * (xx + yy), 0.5 * np.hypot(xx - yy, xy)
    return np.stack([centre + radius, centre - radius, 0.5 * np.arctan2(xy, xx - yy)], axis=-1)


def unit(label: str, vector: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the unit vector along a vector; raise a ModelError if it is not a finite vector other than zero."""
    v = np.asarray(vector, dtype=float)
    length = np.linalg.norm(v) if v.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise ModelError(f"{label} {vector!r} of a gauge has no direction. Remedy: three numbers, not all zero")
    return np.asarray(v / length)
