"""Outputs of each point of a contact in a run."""

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
    """Outputs of the P points of a contact at the output times, in the order of the contact.

    Vectors are along the axes of the shape of the touched surface, as given to ``add_surface``.

    Attributes
    ----------
    normal : ndarray, shape (T, P)
        Normal force, N.
    friction : ndarray, shape (T, P, 3)
        Friction force on the touching point, N.
    penetration : ndarray, shape (T, P)
        Depth below the surface, m; negative: the gap.
    stretch : ndarray, shape (T, P, 3)
        Displacement of the point along the surface from its anchor, m: while it sticks, friction is ``-k stretch - c``
        times the rate of the stretch. For `LuGre`, the deflection of the bristles; for rigid contacts 0.
    slip_velocity : ndarray, shape (T, P, 3)
        Velocity of the anchor on the surface, m/s: 0 while the point sticks. Its magnitude is the rate of
        ``ContactHistory.slip``; friction opposes it.
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
    """Return the columns of `count` points, with units in brackets; those of one unit are adjacent."""
    return tuple(f"point {i} {name} [{unit}]" for unit, names in COLUMNS for i in range(count) for name in names)


def in_columns(outputs: np.ndarray) -> np.ndarray:
    """Reorder outputs of points (T, P, 12) from the order of `COLUMNS` to that of `point_columns`, (T, 12 P)."""
    ends = np.cumsum([len(names) for _, names in COLUMNS])
    return np.concatenate([part.reshape(len(part), -1) for part in np.split(outputs, ends[:-1], axis=2)], axis=1)


def contact_points(outputs: np.ndarray) -> ContactPoints:
    """Return the outputs of points of a contact, (..., 12 P)."""
    widths = [len(names) for _, names in COLUMNS]
    count = outputs.shape[-1] // sum(widths)
    ends = count * np.cumsum(widths)
    forces, places, slips, status = (
        part.reshape(*outputs.shape[:-1], count, -1) for part in np.split(outputs, ends[:-1], axis=-1)
    )
    return ContactPoints(
        normal=forces[..., 0],
        friction=forces[..., 1:],
        penetration=places[..., 0],
        stretch=places[..., 1:],
        slip_velocity=slips,
        status=np.array(STATUS)[status[..., 0].astype(int)],
    )
