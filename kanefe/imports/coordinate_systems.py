"""Rectangular, cylindrical and spherical systems in which decks give points and the axes of displacements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PARALLEL = 1e-10
"""Sine of the angle between the two directions of a system below which they are one."""

ON_AXIS = 1e-12
"""Distance from the axis of a system, relative to the largest coordinate, below which a point is on it."""


class CoordinateSystem(NamedTuple):
    """A system placed in basic coordinates.

    Attributes
    ----------
    kind : str
        R, C or S.
    origin : ndarray, shape (3,)
    axes : ndarray, shape (3, 3)
        Columns are its axes.
    """

    kind: str
    origin: np.ndarray
    axes: np.ndarray


BASIC = CoordinateSystem("R", np.zeros(3), np.eye(3))


def right_handed(along: np.ndarray, beside: np.ndarray) -> np.ndarray | None:
    """Return axes, the first along a vector, the second towards another one; None if these are parallel.

    Returns
    -------
    ndarray, shape (3, 3)
        Columns are the axes.
    """
    across = np.cross(along, beside)
    if not np.linalg.norm(across) > PARALLEL * np.linalg.norm(along) * np.linalg.norm(beside):
        return None
    x, z = along / np.linalg.norm(along), across / np.linalg.norm(across)
    return np.column_stack((x, np.cross(z, x), z))


def in_basic(system: CoordinateSystem, given: np.ndarray) -> np.ndarray:
    """Return points (n, 3) in basic coordinates; angles are given in degrees: theta of C, theta from z and phi of S."""
    local = given
    if system.kind == "C":
        angle = np.radians(given[:, 1])
        local = np.column_stack((given[:, 0] * np.cos(angle), given[:, 0] * np.sin(angle), given[:, 2]))
    elif system.kind == "S":
        polar, azimuth = np.radians(given[:, 1]), np.radians(given[:, 2])
        across = given[:, 0] * np.sin(polar)
        local = np.column_stack((across * np.cos(azimuth), across * np.sin(azimuth), given[:, 0] * np.cos(polar)))
    return np.asarray(system.origin + local @ system.axes.T)


def axes_at(system: CoordinateSystem, points: np.ndarray) -> np.ndarray:
    """Return the axes (n, 3, 3), as columns in basic, of a system at points: of C and S along r, theta, z or phi.

    On the axis of a system theta and phi are taken as 0.
    """
    if system.kind == "R":
        return np.broadcast_to(system.axes, (len(points), 3, 3))
    x, y, z = ((points - system.origin) @ system.axes).T
    across = np.hypot(x, y)
    on_axis = across <= ON_AXIS * np.max(np.abs(points), initial=0.0)
    cos, sin = (np.where(on_axis, on, part / np.where(on_axis, 1.0, across)) for part, on in ((x, 1.0), (y, 0.0)))
    zero, one = np.zeros_like(z), np.ones_like(z)
    radial, around = np.stack((cos, sin, zero), axis=-1), np.stack((-sin, cos, zero), axis=-1)
    if system.kind == "C":
        local = np.stack((radial, around, np.stack((zero, zero, one), axis=-1)), axis=-1)
    else:
        far = np.hypot(across, z)
        polar_sin, polar_cos = (
            np.where(far > 0.0, part / np.where(far > 0.0, far, 1.0), on) for part, on in ((across, 0.0), (z, 1.0))
        )
        outward = np.stack((polar_sin * cos, polar_sin * sin, polar_cos), axis=-1)
        down = np.stack((polar_cos * cos, polar_cos * sin, -polar_sin), axis=-1)
        local = np.stack((outward, down, around), axis=-1)
    return np.asarray(system.axes @ local)
