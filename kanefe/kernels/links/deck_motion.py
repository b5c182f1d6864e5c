"""The motion of a deck: polynomials of time of a ship's six motions, the turn they are, and a point away from them."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.language import Behind, Matrix, Record, Vector, called_by_address, cross, inlined
from kanefe.kernels.links.places import SIGNATURE, WrittenMotion

POWERS = 12
MOTIONS = 6


class DeckNumbers(Record):
    """Numbers of a deck, of `kanefe.environment.deck_motion.DeckMotion.kernel`.

    How many pieces, where the first begins and how long each is, s; the point, m; start and duration of the ramp, s;
    whether the point moves by linear theory; and of each piece the powers of six motions, their rates and their
    accelerations.
    """

    count: float
    first: float
    length: float
    point: Vector
    start: float
    duration: float
    is_small: float
    pieces: Annotated[Any, Behind()]


@called_by_address(*SIGNATURE)
def deck_motion(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a deck's frame at a time, with its velocities and accelerations for partial ones (Eq. 13-16).

    The only coordinate is the time in s. The turn is ``Rz Ry Rx`` of yaw, pitch and roll.
    """
    own, motion = DeckNumbers(numbers), WrittenMotion(out)
    piece = min(max(int((q[0].real - own.first) / own.length), 0), int(own.count) - 1)
    x, ramp = 2.0 * ((q[0] - own.first) - piece * own.length) / own.length - 1.0, ramp_at(own, q[0] - own.start)
    p, v, dv = ramped(own.pieces, 3 * piece * MOTIONS * POWERS, x, ramp)
    angles, rates, changes = ramped(own.pieces, (3 * piece * MOTIONS + 3) * POWERS, x, ramp)
    motion.A = A = turned(angles)
    # turns about the axes of yaw, pitch and roll, one upon the other
    of_pitch, of_roll, yawing = Vector(-np.sin(angles.z), np.cos(angles.z), 0.0), A.x, Vector(0.0, 0.0, rates.z)
    pitching = yawing + rates.y * of_pitch
    motion.W = w = pitching + rates.x * of_roll
    dw = Vector(0.0, 0.0, changes.z) + changes.y * of_pitch + changes.x * of_roll
    motion.dW = dw = dw + rates.y * cross(yawing, of_pitch) + rates.x * cross(pitching, of_roll)
    if own.is_small > 0.0:
        p += own.point
        arm, rate, change = cross(angles, own.point), cross(rates, own.point), cross(changes, own.point)
    else:
        arm = A @ own.point
        rate = cross(w, arm)
        change = cross(dw, arm) + cross(w, rate)
    motion.p, motion.V, motion.dV = p + arm, v + rate, dv + change


@inlined
def ramp_at(own: DeckNumbers, since: Any) -> tuple[Any, Any, Any]:
    """Return the factor of the ramp and its rates."""
    none = 0.0 * since
    if since.real >= own.duration:
        return none + 1.0, none, none
    if since.real <= 0.0:
        return none, none, none
    per = 1.0 / own.duration
    y = since * per
    rate = 30.0 * y * y * (1.0 - y) * (1.0 - y) * per
    return y * y * y * (10.0 + y * (-15.0 + 6.0 * y)), rate, 60.0 * y * (1.0 - y) * (1.0 - 2.0 * y) * per * per


@inlined
def ramped(pieces: Any, at: int, x: Any, ramp: tuple[Any, Any, Any]) -> tuple[Vector, Vector, Vector]:
    """Return three motions, their rates and their accelerations, with the ramp."""
    r, dr, ddr = ramp
    s = three_polynomials(pieces, at, x)
    ds = three_polynomials(pieces, at + MOTIONS * POWERS, x)
    dds = three_polynomials(pieces, at + 2 * MOTIONS * POWERS, x)
    return r * s, r * ds + dr * s, r * dds + 2.0 * dr * ds + ddr * s


@inlined
def three_polynomials(pieces: Any, at: int, x: Any) -> Vector:
    """Return three polynomials, one behind the other."""
    a = b = c = 0.0 * x
    for i in range(at + POWERS - 1, at - 1, -1):
        a, b, c = a * x + pieces[i], b * x + pieces[i + POWERS], c * x + pieces[i + 2 * POWERS]
    return Vector(a, b, c)


@inlined
def turned(angles: Vector) -> Matrix:
    """Return the turn of roll, pitch and yaw."""
    sr, sp, sy = np.sin(angles.x), np.sin(angles.y), np.sin(angles.z)
    cr, cp, cy = np.cos(angles.x), np.cos(angles.y), np.cos(angles.z)
    return Matrix(
        cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
        -sp, cp * sr, cp * cr,
    )  # fmt: skip
