"""Markers: frames fixed in a body, in an interface or in N, and joint coordinates, for loads and constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


@dataclass(frozen=True, eq=False)
class Marker:
    """A frame fixed in a frame of the scene.

    Attributes
    ----------
    body : int
        Number of the body in the model; -1: the inertial frame N.
    interface : InterfaceFrame or None
        Interface of a flexible body; None: the frame of the body itself.
    point : ndarray, shape (3,)
        Origin, from that frame's origin in its components, m.
    axes : ndarray, shape (3, 3)
        Rotation matrix from the marker's axes to those of that frame.
    label : str
        Name in messages, such as ``'rod' at (0.3, 0, 0)``.
    """

    body: int
    interface: InterfaceFrame | None
    point: np.ndarray
    axes: np.ndarray
    label: str


@dataclass(frozen=True, eq=False)
class CoordinateMarker(Marker):
    """A coordinate of a body's joint as an end of a load, which acts there with a force along the coordinate.

    Its motion is that of a point on the x axis: the coordinate is x of the position, its rate x of the velocity, and
    only the first component of the wrench there is used, N or N m.

    Attributes
    ----------
    coordinate : int
        Number of the coordinate in the joint.
    """

    coordinate: int

    @classmethod
    def of(cls, body: int, coordinate: int, label: str) -> Self:
        """Return the marker of a coordinate of a body's joint."""
        return cls(body, None, np.zeros(3), np.eye(3), label, coordinate)


class ModalMarker(CoordinateMarker):
    """A free coordinate of a flexible body as an end of a load, by its number among them; otherwise the same."""
