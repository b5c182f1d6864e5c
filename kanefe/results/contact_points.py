"""What each point of a contact did in a run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.results.contact_history import STATUS

XYZ = ("x", "y", "z")

COLUMNS = (
    ("N", ("normal", *(f"friction {c}" for c in XYZ))),
    ("m", ("penetration", *(f"stretch {c}" for c in XYZ))),
    ("m/s", tuple(f"slip velocity {c}" for c in XYZ)),
    ("1", ("status",)),
)
"""Columns of a contact point, by unit; those of all points with one unit are adjacent."""


class ContactPoints(NamedTuple):
    """What each of the P points of a contact did at the output times, in the order in which the contact has them.

    Vectors are along the axes of the surface that is touched: of its shape, as ``add_surface`` has it.

    Attributes
    ----------
    normal : ndarray, shape (T, P)
        Normal force, N.
    friction : ndarray, shape (T, P, 3)
        Force of friction on what touches, N.
    penetration : ndarray, shape (T, P)
        Depth in the surface, m; below 0: the gap.
    stretch : ndarray, shape (T, P, 3)
        By how much the point has gone along the surface from its anchor, m: while it sticks friction is ``-k stretch -
        c`` times its rate. Of `LuGre` the deflection of the bristles. What is rigid has no anchors: 0.
    slip_velocity : ndarray, shape (T, P, 3)
        With which the anchor of the point slides on the surface, m/s: 0 while it sticks. Its size is the rate at which
        the path ``ContactHistory.slip`` grows; friction is against it.
    status : ndarray of str, shape (T, P)
        "open", "sticks" or "slips".
    """

    normal: np.ndarray
    friction: np.ndarray
    penetration: np.ndarray
    stretch: np.ndarray
    slip_velocity: np.ndarray
    status: np.ndarray


def point_columns(count: int) -> tuple[str, ...]:
    """Return the columns of so many points, with units in brackets: those of one unit beside each other."""
    return tuple(f"point {i} {name} [{unit}]" for unit, names in COLUMNS for i in range(count) for name in names)


def in_columns(told: np.ndarray) -> np.ndarray:
    """Return outputs of points, (P, 12) in the order of `COLUMNS`, in that of `point_columns`, (12 P,)."""
    ends = np.cumsum([len(names) for _, names in COLUMNS])
    return np.concatenate([part.ravel() for part in np.split(told, ends[:-1], axis=1)])


def contact_points(told: np.ndarray) -> ContactPoints:
    """Return the outputs of points of a contact, (..., 12 P)."""
    widths = [len(names) for _, names in COLUMNS]
    count = told.shape[-1] // sum(widths)
    ends = count * np.cumsum(widths)
    forces, places, slips, status = (
        part.reshape(*told.shape[:-1], count, -1) for part in np.split(told, ends[:-1], axis=-1)
    )
    return ContactPoints(
        normal=forces[..., 0],
        friction=forces[..., 1:],
        penetration=places[..., 0],
        stretch=places[..., 1:],
        slip_velocity=slips,
        status=np.array(STATUS)[status[..., 0].astype(int)],
    )
