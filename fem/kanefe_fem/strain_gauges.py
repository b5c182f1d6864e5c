"""Strain gauges: histories of the strain at a point of the surface along given directions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.errors import ModelError
from kanefe_fem import stress_measures
from kanefe_fem.cell_search import find_point
from kanefe_fem.strain_fields import StrainFields

Vector = Sequence[float] | np.ndarray


def gauge_strains(
    fields: StrainFields, eta: np.ndarray, position: Vector, directions: Sequence[Vector], material: int | None
) -> np.ndarray:
    """Return the strains along directions (d, 3) of G at a point (3,) of G in m, at coordinates (T, k), shape (T, d).

    The strain at the nodes (means over the cells that meet there) is interpolated by the cell that holds the point.

    Raises
    ------
    ModelError
        If the position is not on the mesh, or a direction is none.
    """
    place = np.asarray(position, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ModelError(f"position={position!r} of a gauge. Remedy: give three coordinates in G, in m")
    rows = np.array([stress_measures.along(unit("direction", direction)) for direction in directions])
    found = find_point(fields.nodes, fields.cells, fields.chosen_cells(material), place)
    part, numbers = fields.around(found.nodes)
    modes = part.modes("strain", "nodes", material)[numbers]
    return eta @ np.einsum("n,nsk,ds->kd", found.weights, modes, rows)


def rosette_directions(direction: Vector, normal: Vector, angles: Sequence[float]) -> list[np.ndarray]:
    """Return the unit directions of gauges at angles (rad) about a normal from a direction's part in the surface."""
    n = unit("normal", normal)
    along = np.asarray(direction, dtype=float)
    first = unit("direction, its part across the normal,", along - (along @ n) * n)
    second = np.cross(n, first)
    return [np.cos(angle) * first + np.sin(angle) * second for angle in angles]


def rosette_principal(strains: np.ndarray, angles: Sequence[float] = (0.0, np.pi / 4, np.pi / 2)) -> np.ndarray:
    """Return greatest and least strain in the surface and the angle of the greatest, from a rosette of three gauges.

    Parameters
    ----------
    strains : ndarray, shape (T, 3)
        From `Recovery.rosette`.
    angles : sequence of three floats
        Of the gauges in rad.

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
    a = np.asarray(angles, dtype=float)
    strains = np.asarray(strains, dtype=float)
    rows = np.column_stack([np.cos(a) ** 2, np.sin(a) ** 2, np.sin(a) * np.cos(a)])
    if a.shape != (3,) or strains.shape[-1] != 3 or abs(np.linalg.det(rows)) < 1e-9:
        raise ModelError("principal strains need three gauges in three different directions")
    xx, yy, xy = np.moveaxis(strains @ np.linalg.inv(rows).T, -1, 0)
    centre, radius = 0.5 * (xx + yy), 0.5 * np.hypot(xx - yy, xy)
    return np.stack([centre + radius, centre - radius, 0.5 * np.arctan2(xy, xx - yy)], axis=-1)


def unit(label: str, vector: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the unit vector along a vector; a ModelError says which is none."""
    v = np.asarray(vector, dtype=float)
    length = np.linalg.norm(v) if v.shape == (3,) else 0.0
    if not (np.isfinite(length) and length > 0.0):
        raise ModelError(f"{label} {vector!r} of a gauge has no direction. Remedy: three numbers, not all zero")
    return np.asarray(v / length)
