"""Loads on a surface that vary by place and time in a way that is no product of both: a gust that travels.

A field ``f(X, t)`` is asked in Python for its values at the points of a quadrature, X undeformed in the mesh frame G.
From these come the generalised forces of the load, three of the force, three of the moment about G's origin and one of
each coordinate, which are values of as many loads with unit constants. It is right for any function, and slow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.load_pattern import LoadPattern
from kanefe.fe_model.loaded_face import DEGREE, LoadedFace, at_points, measure_of, normals
from kanefe.fe_model.place_field import asked
from kanefe.fe_model.shapes import quadrature
from kanefe.frames import Matrix, Vector
from kanefe.loads.functions import SceneView

REMEMBERED = 4096
"""Largest number of times for which the forces of a field are kept."""


@dataclass(frozen=True, eq=False)
class MovingField:
    """A field of places and time on a surface of a body with k free coordinates.

    Attributes
    ----------
    function : callable
        Places (P, 3) in m and the time in s -> (P,), or (P, 3) of a traction.
    label : str
        Of the load, for messages.
    body : str
        Name of the body, whose coordinates and rotation a traction reads.
    scale : ndarray, shape () or (3,)
        Factor of the values, and of one value a place its direction, if it is a traction.
    is_pressure : bool
    follows : bool
        Whether a traction has components of G, or of N.
    points : ndarray, shape (P, 3)
        Of the quadrature, m.
    pushes : ndarray, shape (P, 3)
        Force of a unit pressure at each point, N/Pa.
    measure : ndarray, shape (P,)
        Area of each point, m2.
    motion : ndarray, shape (3 P, k)
        Displacements of the points from the free coordinates.
    """

    function: Callable[..., Any]
    label: str
    body: str
    scale: np.ndarray
    is_pressure: bool
    follows: bool
    points: Matrix
    pushes: Matrix
    measure: Vector
    motion: Matrix

    def forces(self, t: float, state: SceneView | None) -> Vector:
        """Return force (N) and moment (N m) about G's origin in G, and forces on the coordinates, (6 + k,)."""
        known = _KNOWN.setdefault(self, {})
        last = known.get(t)
        if last is None or not (last[0] is state or self.is_pressure):
            if len(known) >= REMEMBERED:
                known.clear()
            last = known[t] = state, self._forces(t, state)
        return last[1]

    def _forces(self, t: float, state: Any) -> Vector:
        values = asked(self.function, self.points, self.label, t)
        if (values.ndim == 1) != (self.is_pressure or self.scale.ndim == 1):
            raise ModelError(f"over= of {self.label} gave values of shape {values.shape} at t = {t:.6g} s")
        if self.is_pressure:
            return np.asarray(self._of_pressures @ values)
        vectors = self.scale * (values if values.ndim == 2 else values[:, None])
        vectors = vectors if self.follows else vectors @ state.rotation(self.body)
        acting = self.measure[:, None] * vectors
        places = self.points + (self.motion @ state.modal_coordinates(self.body)).reshape(-1, 3)
        moment = np.cross(places, acting).sum(axis=0)
        return np.concatenate((acting.sum(axis=0), moment, self.motion.T @ acting.ravel()))

    @cached_property
    def _of_pressures(self) -> Matrix:
        """Forces of a unit pressure at each point, (6 + k, P)."""
        pushes = float(self.scale) * self.pushes
        elastic = np.einsum("pi,pik->kp", pushes, self.motion.reshape(*pushes.shape, -1))
        return np.vstack((pushes.T, np.cross(self.points, pushes).T, elastic))

    def rows(self) -> list[tuple[LoadPattern, FieldRow]]:
        """Return unit constants, as those of pressures, and the function that gives each its value."""
        k = self.motion.shape[1]
        made = []
        for row, unit in enumerate(np.eye(6 + k)):
            none = np.zeros(3), np.zeros((3, k))
            own = LoadPattern(f"row {row}", "surface", True, 0.0, *none, unit[:3], unit[3:6], unit[6:])
            made.append((own, FieldRow(self, row)))
        return made


_KNOWN: WeakKeyDictionary[MovingField, dict[float, tuple[Any, Vector]]] = WeakKeyDictionary()
"""State and forces of each field by time, since all its rows ask for the same ones."""


@dataclass(frozen=True, eq=False)
class FieldRow:
    """A function of time, or of time and state, that gives one of the generalised forces of a field."""

    field: MovingField
    row: int

    def __call__(self, t: float, state: SceneView | None = None) -> float:
        """Return N, N m, or the force on a coordinate."""
        return float(self.field.forces(t, state)[self.row])


def quadrature_of(face: LoadedFace, basis: Matrix) -> dict[str, np.ndarray]:
    """Return points, pushes, measure and motion of `MovingField`, for coordinates with a basis (N, k)."""
    moved = np.asarray(face.motion @ basis).reshape(-1, 3, basis.shape[1])
    parts, begun = [], 0
    for block in face.blocks:
        points, weights = quadrature(block.kind, DEGREE)
        values, _, places, tangents = at_points(block, points)
        m, n = block.nodes.shape
        own = np.einsum("pn,mnik->mpik", values, moved[begun : begun + m * n].reshape(m, n, 3, -1))
        begun += m * n
        scaled = weights[:, None] * block.signs[:, None, None]
        area = weights * measure_of(tangents) * abs(block.signs[:, None])
        parts.append((places, scaled * normals(tangents), area, own))
    shapes = {"points": (-1, 3), "pushes": (-1, 3), "measure": (-1,), "motion": (-1, basis.shape[1])}
    return {
        name: np.concatenate([one.reshape(shape) for one in own])
        for (name, shape), own in zip(shapes.items(), zip(*parts, strict=True), strict=True)
    }
