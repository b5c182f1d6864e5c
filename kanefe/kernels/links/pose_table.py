"""Poses given by a table: piecewise polynomials of time of the position and of Euler parameters of any length."""

from __future__ import annotations

from typing import Any

from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.links.places import DV, DW, SIGNATURE, A, P, V, W
from kanefe.kernels.links.polynomials import POWERS, piece_at, polynomial

# Numbers: pieces, time at which each piece starts and the last ends, and then of each piece the coefficients of the
# powers 0 to 5 of position (3) and Euler parameters (4)
COUNT, STARTS = range(2)
PIECE_NUMBERS = 7 * POWERS


@called_by_address(*SIGNATURE)
def pose_table(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a frame at a time, with its velocities and accelerations for partial ones (Eq. 13-16).

    `numbers` are those of `kanefe.joints.pose_table.PoseTable.kernel`; the only coordinate is the time in s. Euler
    parameters e that are not of unit length turn as e / |e| does: with the parts of the product of e's conjugate and
    its derivatives, the angular velocity in M is ``w = 2 vec(e* e') / e.e`` (Nikravesh 1988), and its rate follows
    by the quotient rule.
    """
    count = int(numbers[COUNT])
    low = piece_at(numbers, STARTS, count, q[0].real)
    x = q[0] - numbers[STARTS + low]
    at = STARTS + count + 1 + low * PIECE_NUMBERS
    for i in range(3):
        out[P + i], out[V + i], out[DV + i], _ = polynomial(numbers, at + i * POWERS, x)
    at += 3 * POWERS
    e0, d0, c0, _ = polynomial(numbers, at, x)
    e1, d1, c1, _ = polynomial(numbers, at + POWERS, x)
    e2, d2, c2, _ = polynomial(numbers, at + 2 * POWERS, x)
    e3, d3, c3, _ = polynomial(numbers, at + 3 * POWERS, x)
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    w0 = s * (e0 * d1 - e1 * d0 - e2 * d3 + e3 * d2)
    w1 = s * (e0 * d2 - e2 * d0 - e3 * d1 + e1 * d3)
    w2 = s * (e0 * d3 - e3 * d0 - e1 * d2 + e2 * d1)
    shrink = s * (e0 * d0 + e1 * d1 + e2 * d2 + e3 * d3)
    a0 = s * (e0 * c1 - e1 * c0 - e2 * c3 + e3 * c2) - shrink * w0
    a1 = s * (e0 * c2 - e2 * c0 - e3 * c1 + e1 * c3) - shrink * w1
    a2 = s * (e0 * c3 - e3 * c0 - e1 * c2 + e2 * c1) - shrink * w2
    out[A], out[A + 4], out[A + 8] = (
        1.0 - s * (e2 * e2 + e3 * e3),
        1.0 - s * (e1 * e1 + e3 * e3),
        1.0 - s * (e1 * e1 + e2 * e2),
    )
    out[A + 1], out[A + 3] = s * (e1 * e2 - e0 * e3), s * (e1 * e2 + e0 * e3)
    out[A + 2], out[A + 6] = s * (e1 * e3 + e0 * e2), s * (e1 * e3 - e0 * e2)
    out[A + 5], out[A + 7] = s * (e2 * e3 - e0 * e1), s * (e2 * e3 + e0 * e1)
    for i in range(3):
        row = A + 3 * i
        out[W + i] = out[row] * w0 + out[row + 1] * w1 + out[row + 2] * w2
        out[DW + i] = out[row] * a0 + out[row + 1] * a1 + out[row + 2] * a2
