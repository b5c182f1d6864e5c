"""Poses given by a table: piecewise polynomials of time of the position and of Euler parameters of any length."""

from typing import Any

from kanefe.kernels.language import called_by_address, cross, dot, rotation
from kanefe.kernels.links.places import SIGNATURE, WrittenMotion
from kanefe.kernels.links.polynomials import POWERS, piece_at, polynomial, vector_polynomial


@called_by_address(*SIGNATURE)
def pose_table(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a frame at a time, with its velocities and accelerations for partial ones (Eq. 13-16).

    `numbers` are those of `kanefe.joints.pose_table.PoseTable.kernel`: how many pieces, the time at which each starts
    and the last ends, and of each piece the coefficients of position (3) and Euler parameters (4). The only coordinate
    is the time in s. Euler parameters e that are not of unit length turn as e / |e| does: with the parts of the product
    of e's conjugate and its derivatives, the angular velocity in M is ``w = 2 vec(e* e') / e.e`` (Nikravesh 1988), and
    its rate follows by the quotient rule.
    """
    count, motion = int(numbers[0]), WrittenMotion(out)
    low = piece_at(numbers, 1, count, q[0].real)
    x, at = q[0] - numbers[1 + low], count + 2 + low * 7 * POWERS
    motion.p, motion.V, motion.dV, _ = vector_polynomial(numbers, at, x)
    e0, d0, c0, _ = polynomial(numbers, at + 3 * POWERS, x)
    e, d, c, _ = vector_polynomial(numbers, at + 4 * POWERS, x)
    s = 2.0 / (e0 * e0 + dot(e, e))
    w = s * (e0 * d - d0 * e - cross(e, d))
    shrink = s * (e0 * d0 + dot(e, d))
    motion.A = rotation(e0, e.x, e.y, e.z)
    motion.W = motion.A @ w
    motion.dW = motion.A @ (s * (e0 * c - c0 * e - cross(e, c)) - shrink * w)
