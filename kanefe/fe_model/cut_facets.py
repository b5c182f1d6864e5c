"""Facets that the border of a place cuts: a selection of whole facets leaves them out, which is measured and told."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.places import PlaceLike, contained
from kanefe.fe_model.shapes import shape, stretches

TOLD = 0.01
"""Share of the area in a place from which it is told that it is left out: curved borders leave slivers."""

SMOOTH = np.cos(np.radians(20.0))
"""Cosine of the angle between normals up to which a facet continues the selected ones, and is not another side."""

_DEGREE = 6
"""Degree of the quadrature whose points say how much of a facet is in a place: sixteen points of a quadrangle."""


def tell_cut(nodes: np.ndarray, blocks: Sequence[Cells], inside: np.ndarray, place: PlaceLike, label: str) -> None:
    """Warn if the border of a place cuts facets that continue those whose corners are all inside.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        In m.
    blocks : sequence of Cells
        The facets from which was selected.
    inside : ndarray, bool, shape (n,)
        Which nodes are in the place.
    place : Place or function of points
    label : str
        What is selected, such as "surface 'patch'".
    """
    faces = [block for block in blocks if shape(block.kind).dimension == 2]
    whole = [inside[block.nodes[:, : shape(block.kind).corners]].all(axis=1) for block in faces]
    taken, left, side = 0.0, 0.0, np.zeros((len(nodes), 3))
    for block, chosen in zip(faces, whole, strict=True):
        area, normal = _areas(nodes, block, chosen)
        taken += float(area.sum())
        np.add.at(side, block.nodes[chosen], normal[:, None])
    for block, chosen in zip(faces, whole, strict=True):
        beside = ~chosen & side[block.nodes].any(axis=(1, 2))
        area, normal = _areas(nodes, block, beside, place, label)
        near = side[block.nodes[beside]].sum(axis=1)
        along = np.abs(np.einsum("mi,mi->m", near, normal))
        lengths = np.linalg.norm(near, axis=1) * np.linalg.norm(normal, axis=1)
        left += float(area[along > SMOOTH * lengths].sum())
    if left > TOLD * (taken + left):
        warnings.warn(
            f"{label}: the border of {place!r} cuts facets; {taken + left:.4g} m2 lie in it, of which the whole facets "
            f"are taken, {taken:.4g} m2, {100.0 * left / (taken + left):.2g} % less. Remedy: a mesh with sides along "
            "the border (the outline embedded where the mesh is made), or smaller cells",
            AccuracyWarning,
            stacklevel=outside(),
        )


def _areas(
    nodes: np.ndarray, block: Cells, chosen: np.ndarray, place: PlaceLike | None = None, label: str = ""
) -> tuple[np.ndarray, np.ndarray]:
    """Return the areas of some facets, or of their parts in a place, m2, and their normals, of any length."""
    x = nodes[block.nodes[chosen]]
    area = np.zeros(len(x))
    for weight, value, stretch in stretches(block.kind, x, _DEGREE):
        share = weight * stretch
        if place is not None and len(x):
            share = share * contained(np.einsum("n,mni->mi", value, x), place, label)
        area += share
    corners = x[:, : shape(block.kind).corners]
    return area, np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
