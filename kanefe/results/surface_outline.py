"""What the surfaces of a scene look like, and on what they sit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.contact.surface import Surface


@dataclass(frozen=True, eq=False)
class SurfaceOutline:
    """The triangles of a surface in the axes of what carries it.

    Attributes
    ----------
    name : str
    body, interface : str
        What carries it: a body ("" for the ground), or an interface of it.
    vertices : ndarray, shape (n, 3)
        In the frame of the body or interface, m.
    triangles : ndarray of int, shape (m, 3)
    is_endless : bool
        Whether it is a square of 1 m cut out of a plane.
    lines : ndarray of int, shape (e, 2)
        Of vertices, drawn upon it: the grid of a field of heights.
    """

    name: str
    body: str
    interface: str
    vertices: np.ndarray
    triangles: np.ndarray
    is_endless: bool
    lines: np.ndarray


def outlines(model: ModelData) -> tuple[SurfaceOutline, ...]:
    """Return the surfaces of a model whose looks are known, but for those on single nodes of a mesh."""
    found = [_on_frame(model, surface) for surface in model.surfaces]
    return tuple(one for one in found if one is not None)


def _on_frame(model: ModelData, surface: Surface) -> SurfaceOutline | None:
    from kanefe.contact.outlines import outline

    marker, drawn = surface.frame, outline(surface.shape)
    body = model.bodies[marker.body] if marker.body >= 0 else None
    carrier = marker.interface
    if drawn is None or (carrier is not None and body is not None and carrier not in body.interfaces):
        return None
    vertices = marker.point + drawn.vertices @ marker.axes.T
    if carrier is not None:
        vertices = vertices @ carrier.axes
    name, interface = body.name if body is not None else "", carrier.name if carrier is not None else ""
    return SurfaceOutline(surface.name, name, interface, vertices, drawn.triangles, drawn.is_endless, drawn.lines)
