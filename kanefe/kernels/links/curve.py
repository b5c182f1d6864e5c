"""Points on curves: a piecewise polynomial in its arc length, and a frame along it."""

from typing import Annotated, Any

import numpy as np

from kanefe.kernels.language import IDENTITY, Behind, Matrix, Record, Vector, called_by_address, cross, dot, inlined
from kanefe.kernels.links.places import SIGNATURE, WrittenMotion
from kanefe.kernels.links.polynomials import POWERS, piece_at, vector_polynomial


class CurveNumbers(Record):
    """Numbers of a curve: how many pieces, whether it is closed, and whether M turns with it.

    The table has the arc lengths at which pieces start and the last ends, and then of each piece the coefficients of
    the powers 0 to 5 of position and, if M turns, of what is up.
    """

    pieces: float
    is_closed: float
    turns: float
    table: Annotated[Any, Behind()]


@called_by_address(*SIGNATURE)
def curve(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a point on a curve (Eq. 13-16)."""
    own, motion = CurveNumbers(numbers), WrittenMotion(out)
    count, table, turns = int(own.pieces), own.table, own.turns > 0.0
    end, s = table[count], q[0]
    beyond = 0.0 * s
    if own.is_closed > 0.0:
        s -= end * np.floor(s.real / end)
    elif s.real < 0.0:
        beyond = s
    elif s.real > end:
        beyond = s - end
    s -= beyond
    low = piece_at(table, 0, count, s.real)
    x, at = s - table[low], count + 1 + low * (6 if turns else 3) * POWERS
    p, t, bend, twist = vector_polynomial(table, at, x)
    if beyond.real != 0.0:  # straight on
        p, bend, twist = p + beyond * t, 0.0 * t, 0.0 * t
    motion.p, motion.V, motion.dV = p, t, bend
    if not turns:
        motion.A = IDENTITY
        return
    n, dn, ddn, _ = vector_polynomial(table, at + 3 * POWERS, x)
    if beyond.real != 0.0:
        dn, ddn = 0.0 * n, 0.0 * n
    put_frame(t, (bend, twist), (n, dn, ddn), motion)


@inlined
def put_frame(t: Vector, bends: tuple[Vector, ...], up: tuple[Vector, ...], motion: WrittenMotion) -> None:
    """Write axes along a tangent and towards what is up, and how they turn; of both with their derivatives."""
    (bend, twist), (n, dn, ddn) = bends, up
    # axes of a frame are of unit length to round-off, tangents to what the arc length is right to
    t = (1.0 / np.sqrt(dot(t, t))) * t
    across = n - dot(n, t) * t
    length = np.sqrt(dot(across, across))
    z = (1.0 / length) * across
    y = cross(z, t)
    motion.A = Matrix(t.x, y.x, z.x, t.y, y.y, z.y, t.z, y.z, z.z)
    lean, bend_y = dot(n, t), dot(y, bend)
    roll = (lean * bend_y - dot(y, dn)) / length
    motion.W = cross(t, bend) + roll * t
    dy = cross(motion.W, y)
    dlean = dot(dn, t) + dot(n, bend)
    change = dlean * bend_y + lean * (dot(dy, bend) + dot(y, twist)) - dot(dy, dn) - dot(y, ddn)
    droll = (change - roll * (dot(z, dn) - lean * dot(z, bend))) / length
    motion.dW = cross(t, twist) + droll * t + roll * bend
