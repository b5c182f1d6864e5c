"""The distance of the straight sides of a mesh from the curved geometry that was meshed."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.fe_model.shapes import MIDS, shape

_SIDES = {8: "line3", 9: "triangle6", 10: "quad9", 16: "quad8"}
"""gmsh's curved elements of lines and surfaces."""

_FLAT = ("Line", "Plane")
"""First words of gmsh's type names of straight curves and flat surfaces."""


FLAT = 1e-10
"""Distance relative to the model below which sides are straight: extruded sides have gmsh's general type."""


def sagitta(gmsh: Any) -> float:
    """Return the largest distance of the sides of the meshed model from its curves and surfaces, m.

    If the geometry is curved, the mesh of the model is changed to order 2.

    Parameters
    ----------
    gmsh : module
        gmsh, whose current model has a mesh of order 1.
    """
    entities = [(d, tag) for d in (1, 2) for _, tag in gmsh.model.getEntities(d)]
    curved = [entity for entity in entities if not gmsh.model.getType(*entity).startswith(_FLAT)]
    if not curved:
        return 0.0
    try:
        gmsh.model.mesh.setOrder(2)
    except Exception:  # noqa: BLE001 - gmsh raises bare Exception if it cannot curve this mesh
        return 0.0
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.zeros((int(max(tags)) + 1, 3))
    points[np.asarray(tags, dtype=np.int64)] = np.reshape(coordinates, (-1, 3))
    largest = 0.0
    for entity in curved:
        kinds, _, nodes = gmsh.model.mesh.getElements(*entity)
        for kind, numbers in zip(kinds, nodes, strict=True):
            if kind in _SIDES:
                largest = max(largest, _bow(points, numbers, _SIDES[kind]))
    return largest if largest > FLAT * np.ptp(points) else 0.0


def _bow(points: np.ndarray, numbers: np.ndarray, kind: str) -> float:
    """Return the largest distance of the middles of edges from the straight lines between their ends."""
    edges = [mid for mid in MIDS[kind] if len(mid) == 2]
    corners = shape(kind).corners
    places = points[np.asarray(numbers, dtype=np.int64).reshape(-1, corners + len(MIDS[kind]))]
    start = places[:, [a for a, _ in edges]]
    along, out = places[:, [b for _, b in edges]] - start, places[:, corners : corners + len(edges)] - start
    share = np.einsum("mes,mes->me", along, out) / np.einsum("mes,mes->me", along, along)
    return float(np.linalg.norm(out - share[:, :, None] * along, axis=2).max(initial=0.0))
