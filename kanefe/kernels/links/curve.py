"""Points on curves: a piecewise polynomial in its arc length, and a frame along it."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, plus, put_three, times
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.compiler.addresses import called_by_address
from kanefe.kernels.links.places import DV, DW, SIGNATURE, A, P, V, W
from kanefe.kernels.links.polynomials import POWERS, piece_at, polynomial

# Numbers: pieces, whether it is closed, whether M turns with it, arc length at which each piece starts and the last
# ends, and then of each piece the coefficients of the powers 0 to 5 of position and, if M turns, of what is up
COUNT, IS_CLOSED, TURNS, STARTS = range(4)


@called_by_address(*SIGNATURE)
def curve(numbers: Any, q: Any, out: Any) -> None:
    """Write the motion of a point on a curve (Eq. 13-16).

    `numbers` are those of `kanefe.joints.point_on_curve.PointOnCurve.links`.
    """
    count = int(numbers[COUNT])
    end, s = numbers[STARTS + count], q[0]
    beyond = 0.0 * s
    if numbers[IS_CLOSED] > 0.0:
        s -= end * np.floor(s.real / end)
    elif s.real < 0.0:
        beyond = s
    elif s.real > end:
        beyond = s - end
    s -= beyond
    low = piece_at(numbers, STARTS, count, s.real)
    x, at = s - numbers[STARTS + low], STARTS + count + 1
    turns = numbers[TURNS] > 0.0
    at += low * (6 if turns else 3) * POWERS
    p, t, bend, twist = _derivatives(numbers, at, x)
    if beyond.real != 0.0:  # straight on
        p = plus(p, times(beyond, t))
        bend = twist = times(0.0, t)
    put_three(out, P, p)
    put_three(out, V, t)
    put_three(out, DV, bend)
    if not turns:
        out[A] = out[A + 4] = out[A + 8] = 1.0 + 0.0 * s
        return
    n, dn, ddn, _ = _derivatives(numbers, at + 3 * POWERS, x)
    if beyond.real != 0.0:
        dn = ddn = times(0.0, n)
    # axes of a frame are of unit length to round-off, tangents to what the arc length is right to
    t = times(1.0 / np.sqrt(dot(t, t)), t)
    across = minus(n, times(dot(n, t), t))
    length = np.sqrt(dot(across, across))
    z = times(1.0 / length, across)
    y = cross(z, t)
    for c in range(3):
        out[A + 3 * c], out[A + 3 * c + 1], out[A + 3 * c + 2] = t[c], y[c], z[c]
    lean, bend_y = dot(n, t), dot(y, bend)
    roll = (lean * bend_y - dot(y, dn)) / length
    w = plus(cross(t, bend), times(roll, t))
    dy = cross(w, y)
    dlean = dot(dn, t) + dot(n, bend)
    change = dlean * bend_y + lean * (dot(dy, bend) + dot(y, twist)) - dot(dy, dn) - dot(y, ddn)
    droll = (change - roll * (dot(z, dn) - lean * dot(z, bend))) / length
    put_three(out, W, w)
    put_three(out, DW, plus(cross(t, twist), plus(times(droll, t), times(roll, bend))))


@inlined
def _derivatives(numbers: Any, at: int, x: Any) -> tuple[Numbers, Numbers, Numbers, Numbers]:
    """Return a vector of three polynomials and its first three derivatives."""
    a, b, c = (
        polynomial(numbers, at, x),
        polynomial(numbers, at + POWERS, x),
        polynomial(numbers, at + 2 * POWERS, x),
    )
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2]), (a[3], b[3], c[3])
