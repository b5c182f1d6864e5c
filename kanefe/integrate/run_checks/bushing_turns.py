"""Bushings that a run has turned beyond half a turn, where their rotation vector jumps: looked for at output times."""

from __future__ import annotations

import math

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector, euler_parameters_from_matrix, multiply
from kanefe.integrate.status import RunStatus
from kanefe.loads.base import Load
from kanefe.tree.run_sweeps import RunSweeps

REMEDY = (
    "kf.Bearing for a shaft that keeps turning; or a joint for the direction that is free, and no stiffness about it "
    "(a law= that is periodic)"
)

FIT = 0.5
"""Largest difference, in turns, between the rotation from one output time to the next and the rotation expected from
the speeds at both: for routes that do not count turns."""

MOST_BETWEEN = 64
"""Most states looked at between two output times."""

ROUND_OFF = 1e-12
"""Change of an Euler parameter, relative to 1, that is no rotation."""


def of_bushings(model: Model, times: Vector, states: Matrix) -> RunStatus | None:
    """Return the status of a run in which a bushing goes through half a turn; None if none does.

    The coordinates of joints count turns, Euler parameters in them up to two. So the Euler parameters of one end seen
    from the other, as these coordinates give them, change the sign of their scalar part at half a turn, however far
    output times are apart. Where speeds say that a bushing may turn by more than a turn between two of them, states on
    the line between them are looked at too.
    On a route without counted turns, a bushing is taken to turn the shorter way where that fits its speeds; elsewhere
    nothing is told.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (T,)
        s.
    states : ndarray, shape (T, state)
        (q, u, z, ...).
    """
    turning = [(i, load) for i, load in enumerate(model.loads) if getattr(load, "turns_by_half_at_most", False)]
    if not turning or len(times) < 2:
        return None  # of one time there is no way between
    swept = model.route.sweeps(times, states)
    found = []
    for number, load in turning:
        if swept is not None:
            row = _first_counted(model, swept, load, times, states)
        else:
            row = _first_beyond(times, *_turning(model, number, times, states))
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


def _first_counted(model: Model, swept: RunSweeps, load: Load, times: Vector, states: Matrix) -> int:
    """Return the number of the first output time before which half a turn was passed, by counted turns; 0: none is."""
    of_a, of_b = (_angular_velocity(swept, marker) for marker in load.ends)
    rates = np.linalg.norm(np.broadcast_to(of_b - of_a, (len(times), 3)), axis=1)
    turns = np.maximum(rates[1:], rates[:-1]) * np.diff(times)
    # two turns of 2 pi look like none: parts of one turn at most, so that none of them passes half a turn twice
    parts = np.minimum(np.ceil(turns / (2.0 * math.pi)), MOST_BETWEEN).astype(int)
    parts = np.where(parts > 1, 2 * parts, 1)
    at = np.append(np.repeat(np.arange(len(parts)), parts), len(parts))
    if len(at) > len(times):
        begins = np.append(0, np.cumsum(parts))
        share = (np.arange(len(at)) - begins[at]) / np.append(parts, 1)[at]
        after = np.minimum(at + 1, len(parts))
        times = times[at] + share * (times[after] - times[at])
        states = states[at] + share[:, None] * (states[after] - states[at])
        swept = model.route.sweeps(times, states) or swept
    a, b = (_turn(swept, marker) for marker in load.ends)
    scalar = np.broadcast_to(np.sum(a * b, axis=-1), times.shape)  # that of a's conjugate times b
    passed = (scalar[1:] * scalar[:-1] < 0.0) & (np.abs(np.diff(scalar)) > ROUND_OFF)
    return int(at[:-1][passed][0]) + 1 if passed.any() else 0


def _angular_velocity(swept: RunSweeps, marker: Marker) -> Matrix:
    """Return that of a marker, in N."""
    if marker.body < 0:
        return np.zeros((1, 3))
    return swept.frame(marker.body, marker.interface).angular_velocity


def _turn(swept: RunSweeps, marker: Marker) -> Matrix:
    """Return the Euler parameters of a marker's axes, with turns counted."""
    own = euler_parameters_from_matrix(marker.axes)[None]
    return own if marker.body < 0 else multiply(swept.rotation(marker.body, marker.interface), own)


def _turning(model: Model, number: int, times: Vector, states: Matrix) -> tuple[np.ndarray, Matrix]:
    """Return the rotations of the second end seen from the first, (T, 3, 3), and its angular velocity in N, (T, 3)."""
    views = [model.route.view(t, y).load_ends(number) for t, y in zip(times.tolist(), states, strict=True)]
    (a, of_a), (b, of_b) = (
        (np.array([ends[i].A for ends in views]), np.array([ends[i].w for ends in views])) for i in (0, 1)
    )
    return np.swapaxes(a, -1, -2) @ b, of_b - of_a


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
