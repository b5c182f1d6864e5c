"""Where a point of space is in a mesh: the cell that holds it, and its reference coordinates there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.finite_element_model import Cells
from kanefe_fem.shapes import Shape, shape

REACH = 0.1
"""How far outside of the mesh a point may lie, as a share of the nearest cell's size: chords of curved surfaces."""

CANDIDATES = 64
"""Cells that are looked at, those with the nearest centres first."""


@dataclass(frozen=True, eq=False)
class MeshPoint:
    """A point of a mesh.

    Attributes
    ----------
    nodes : ndarray of int, shape (nodes per cell,)
        Of the cell.
    weights : ndarray, shape (nodes per cell,)
        Values of its shape functions: a field at the point is their sum times its values at the nodes.
    position : ndarray, shape (3,)
        In G, m; on the mesh.
    """

    nodes: np.ndarray
    weights: np.ndarray
    position: np.ndarray


def find_point(nodes: np.ndarray, cells: tuple[Cells, ...], wanted: np.ndarray, point: np.ndarray) -> MeshPoint:
    """Return where a point is in the wanted cells; the nearest point of the mesh if it lies just outside.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
    cells : tuple of Cells
    wanted : ndarray of bool, shape (cells,)
    point : ndarray, shape (3,)
        In G, m.

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
        if not len(table):
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
        raise ModelError("no cell of the body has this material. Remedy: choose one of those it has")
    distance, size, found = best
    if distance > REACH * size:
        raise ModelError(
            f"the point {point.tolist()} lies {distance:.3g} m outside of the mesh; the nearest point of it is "
            f"{found.position.round(9).tolist()}. Remedy: give a point of the body in its mesh frame G, in m"
        )
    return found


def _reference_coordinates(element: Shape, x: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Return s with x(s) = point, by Newton's method; of a cell in a plane the nearest s."""
    s = element.nodes[: element.corners].mean(axis=0)
    for _ in range(20):
        miss = element.values(s[None])[0] @ x - point
        step = np.linalg.lstsq(x.T @ element.gradients(s[None])[0], miss, rcond=None)[0]
        s = s - np.clip(step, -0.5, 0.5)  # far outside the map of a curved cell folds back
        if np.abs(step).max() < 1e-13:
            break
    return s


def _clamped(element: Shape, s: np.ndarray) -> np.ndarray:
    """Return the reference coordinates moved into the cell."""
    if not element.is_simplex:
        return np.clip(s, 0.0, 1.0)
    barycentric = np.maximum(np.append(s, 1.0 - s.sum()), 0.0)
    return barycentric[:-1] / barycentric.sum()
