"""The motion of a deck: polynomials of time of a ship's six motions, the turn they are, and a point away from them."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.links.places import DV, DW, SIGNATURE, A, P, V, W

# Numbers: pieces, where the first begins, how long each is, the point (3), start and duration of the ramp, whether the
# point moves by linear theory, and then of each piece the powers of six motions, their rates and their accelerations
COUNT, FIRST, LENGTH, POINT, START, DURATION, IS_SMALL, PIECES = 0, 1, 2, 3, 6, 7, 8, 9
POWERS = 12
MOTIONS = 6
PIECE_NUMBERS = 3 * MOTIONS * POWERS


@called_by_address(*SIGNATURE)
def deck_motion(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a deck's frame at a time, with its velocities and accelerations for partial ones (Eq. 13-16).

    `numbers` are those of `kanefe.environment.deck_motion.DeckMotion.kernel`; the only coordinate is the time in s. The
    turn is ``Rz Ry Rx`` of yaw, pitch and roll.
    """
    length = numbers[LENGTH]
    piece = int((q[0].real - numbers[FIRST]) / length)
    piece = min(max(piece, 0), int(numbers[COUNT]) - 1)
    x = 2.0 * ((q[0] - numbers[FIRST]) - piece * length) / length - 1.0
    at = PIECES + piece * PIECE_NUMBERS
    # the factor of the ramp and its rates
    r, dr, ddr = 1.0 + 0.0 * x, 0.0 * x, 0.0 * x
    since = q[0] - numbers[START]
    if since.real < numbers[DURATION]:
        if since.real <= 0.0:
            r = 0.0 * x
        else:
            per = 1.0 / numbers[DURATION]
            y = since * per
            r = y * y * y * (10.0 + y * (-15.0 + 6.0 * y))
            dr = 30.0 * y * y * (1.0 - y) * (1.0 - y) * per
            ddr = 60.0 * y * (1.0 - y) * (1.0 - 2.0 * y) * per * per
    for k in range(MOTIONS):
        s = numbers[at + POWERS - 1] + 0.0 * x
        ds = numbers[at + (MOTIONS + 1) * POWERS - 1] + 0.0 * x
        dds = numbers[at + (2 * MOTIONS + 1) * POWERS - 1] + 0.0 * x
        for i in range(POWERS - 2, -1, -1):
            s = s * x + numbers[at + i]
            ds = ds * x + numbers[at + MOTIONS * POWERS + i]
            dds = dds * x + numbers[at + 2 * MOTIONS * POWERS + i]
        at += POWERS
        dds = r * dds + 2.0 * dr * ds + ddr * s
        ds = r * ds + dr * s
        s = r * s
        # where they belong; angles for now where axes will be, with their rates where angular velocities will be
        if k < 3:
            out[P + k], out[V + k], out[DV + k] = s, ds, dds
        else:
            out[A + k - 3], out[W + k - 3], out[DW + k - 3] = s, ds, dds
    a0, a1, a2 = out[A], out[A + 1], out[A + 2]
    d0, d1, d2 = out[W], out[W + 1], out[W + 2]
    c0, c1, c2 = out[DW], out[DW + 1], out[DW + 2]
    p0, p1, p2 = numbers[POINT], numbers[POINT + 1], numbers[POINT + 2]
    sr, sp, sy = np.sin(a0), np.sin(a1), np.sin(a2)
    cr, cp, cy = np.cos(a0), np.cos(a1), np.cos(a2)
    out[A], out[A + 1], out[A + 2] = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    out[A + 3], out[A + 4], out[A + 5] = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    out[A + 6], out[A + 7], out[A + 8] = -sp, cp * sr, cp * cr
    # angular velocity in N of turns about the axes of yaw, pitch and roll, one upon the other, and its rate
    w0, w1, w2 = d0 * cp * cy - d1 * sy, d0 * cp * sy + d1 * cy, d2 - d0 * sp
    e0 = c0 * cp * cy - d0 * (d1 * sp * cy + d2 * cp * sy) - c1 * sy - d1 * d2 * cy
    e1 = c0 * cp * sy - d0 * (d1 * sp * sy - d2 * cp * cy) + c1 * cy - d1 * d2 * sy
    e2 = c2 - c0 * sp - d0 * d1 * cp
    out[W], out[W + 1], out[W + 2] = w0, w1, w2
    out[DW], out[DW + 1], out[DW + 2] = e0, e1, e2
    if numbers[IS_SMALL] > 0.0:
        out[P], out[P + 1], out[P + 2] = out[P] + p0, out[P + 1] + p1, out[P + 2] + p2
        out[P], out[P + 1], out[P + 2] = (
            out[P] + a1 * p2 - a2 * p1,
            out[P + 1] + a2 * p0 - a0 * p2,
            out[P + 2] + a0 * p1 - a1 * p0,
        )
        out[V], out[V + 1], out[V + 2] = (
            out[V] + d1 * p2 - d2 * p1,
            out[V + 1] + d2 * p0 - d0 * p2,
            out[V + 2] + d0 * p1 - d1 * p0,
        )
        out[DV], out[DV + 1], out[DV + 2] = (
            out[DV] + c1 * p2 - c2 * p1,
            out[DV + 1] + c2 * p0 - c0 * p2,
            out[DV + 2] + c0 * p1 - c1 * p0,
        )
    else:
        r0 = out[A] * p0 + out[A + 1] * p1 + out[A + 2] * p2
        r1 = out[A + 3] * p0 + out[A + 4] * p1 + out[A + 5] * p2
        r2 = out[A + 6] * p0 + out[A + 7] * p1 + out[A + 8] * p2
        v0, v1, v2 = w1 * r2 - w2 * r1, w2 * r0 - w0 * r2, w0 * r1 - w1 * r0
        out[P], out[P + 1], out[P + 2] = out[P] + r0, out[P + 1] + r1, out[P + 2] + r2
        out[V], out[V + 1], out[V + 2] = out[V] + v0, out[V + 1] + v1, out[V + 2] + v2
        out[DV], out[DV + 1], out[DV + 2] = (
            out[DV] + e1 * r2 - e2 * r1 + w1 * v2 - w2 * v1,
            out[DV + 1] + e2 * r0 - e0 * r2 + w2 * v0 - w0 * v2,
            out[DV + 2] + e0 * r1 - e1 * r0 + w0 * v1 - w1 * v0,
        )
