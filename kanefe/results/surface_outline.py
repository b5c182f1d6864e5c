"""Outlines of the surfaces of a scene, and the bodies that carry them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.contact.surface import Surface


@dataclass(frozen=True, eq=False)
class SurfaceOutline:
    """The triangles of a surface in the frame that carries it.

    Attributes
    ----------
    name : str
    body, interface : str
        The body that carries it ("" for the ground), and its interface or "".
    vertices : ndarray, shape (n, 3)
        In the frame of the body or interface, m.
    triangles : ndarray of int, shape (m, 3)
    is_endless : bool
        Whether it is an infinite plane, of which the outline is a square of 1 m.
    lines : ndarray of int, shape (e, 2)
        Pairs of vertices, drawn as lines: the grid of a height field.
    """

    name: str
    body: str
    interface: str
    vertices: np.ndarray
    triangles: np.ndarray
    is_endless: bool
    lines: np.ndarray


def outlines(model: ModelData) -> tuple[SurfaceOutline, ...]:
    """Return the outlines of the surfaces of a model that have one, except those on single nodes of a mesh."""
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
