"""Markers: frames fixed in a body, in an interface or in N, to which springs, constraints and loads attach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.bodies.flexible import InterfaceFrame


@dataclass(frozen=True, eq=False)
class Marker:
    """A frame fixed in a frame of the scene.

    Attributes
    ----------
    body : int
        Number of the body in the model; -1: the inertial frame N.
    interface : InterfaceFrame or None
        Of a flexible body; None: the frame of the body itself.
    point : ndarray, shape (3,)
        Origin, from that frame's origin in its components, m.
    axes : ndarray, shape (3, 3)
        From the marker's axes to those of that frame.
    label : str
        For messages, such as ``'rod' at (0.3, 0, 0)``.
    """

    body: int
    interface: InterfaceFrame | None
    point: np.ndarray
    axes: np.ndarray
    label: str
