"""Bushings that a run has turned beyond half a turn, where their rotation vector jumps: looked for at output times."""

from __future__ import annotations

import math

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector, euler_parameters_from_matrix
from kanefe.integrate.status import RunStatus
from kanefe.loads.base import Load
from kanefe.tree.route import RunSweeps

REMEDY = (
    "kf.Bearing for a shaft that keeps turning; or a joint for the direction that is free, and no stiffness about it "
    "(a law= that is periodic)"
)

FIT = 0.5
"""Largest difference, in turns, between the rotation from one output time to the next and the rotation expected from
the speeds at both."""


def of_bushings(model: Model, times: Vector, states: Matrix) -> RunStatus | None:
    """Return the status of a run in which a bushing goes through half a turn; None if none does.

    From one output time to the next a bushing is taken to turn the shorter way, where that fits its speeds. Where
    output times are too far apart for that, nothing is told.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (T,)
        s.
    states : ndarray, shape (T, state)
        (q, u, z, ...).
    """
    turning = [(i, load) for i, load in enumerate(model.loads) if load.turns_by_half_at_most]
    if not turning or len(times) < 2:
        return None  # of one time there is no way between
    swept = model.route.sweeps(times, states)
    found = []
    for number, load in turning:
        row = _first_beyond(times, *_turning(model, swept, number, load, times, states))
        if row:
            found.append((row, load.name))
    if not found:
        return None
    row, name = min(found)
    reason = (
        f"bushing {name!r} went through half a turn between t = {times[row - 1]:.6g} s and {times[row]:.6g} s: its "
        "rotation vector jumps there, and so does its moment"
    )
    return RunStatus("failed", float(times[row]), reason, REMEDY)


def _turning(
    model: Model, swept: RunSweeps | None, number: int, load: Load, times: Vector, states: Matrix
) -> tuple[np.ndarray, Matrix]:
    """Return the rotations of the second end seen from the first, (T, 3, 3), and its angular velocity in N, (T, 3)."""
    if swept is not None:
        (a, of_a), (b, of_b) = (_motion(swept, marker) for marker in load.ends)
    else:
        views = [model.route.view(t, y).load_ends(number) for t, y in zip(times.tolist(), states, strict=True)]
        (a, of_a), (b, of_b) = (
            (np.array([ends[i].A for ends in views]), np.array([ends[i].w for ends in views])) for i in (0, 1)
        )
    return np.swapaxes(a, -1, -2) @ b, np.broadcast_to(of_b - of_a, (len(times), 3))


def _motion(swept: RunSweeps, marker: Marker) -> tuple[np.ndarray, np.ndarray]:
    """Return axes and angular velocity of a marker, in N."""
    if marker.body < 0:
        return marker.axes, np.zeros(3)
    frame = swept.frame(marker.body, marker.interface)
    return frame.axes @ marker.axes, frame.angular_velocity


def _first_beyond(times: Vector, turns: np.ndarray, rates: Matrix) -> int:
    """Return the number of the first rotation that is beyond half a turn from that before it; 0: none is."""
    steps, angles = _angles(np.swapaxes(turns[:-1], -1, -2) @ turns[1:]), _angles(turns)
    expected = 0.5 * np.linalg.norm(rates[1:] + rates[:-1], axis=1) * np.diff(times)
    may_be = (angles[:-1] + steps >= math.pi) & (np.abs(expected - steps) < FIT * steps)
    for i in np.flatnonzero(may_be).tolist():
        before, after = (euler_parameters_from_matrix(turn) for turn in turns[i : i + 2])
        # both are given with a scalar part above zero: that of the shorter way changes its sign
        if before @ after < 0.0:
            return i + 1
    return 0


def _angles(turns: np.ndarray) -> Vector:
    """Return the angles of rotations (..., 3, 3), rad."""
    return np.asarray(np.arccos(np.clip(0.5 * (np.trace(turns, axis1=-2, axis2=-1) - 1.0), -1.0, 1.0)))
