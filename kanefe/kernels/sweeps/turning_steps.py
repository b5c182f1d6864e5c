"""Rotation over one step of a line of given curvature, and how it moves: a Magnus expansion of sixth order.

The kernel of `kanefe.bodies.exact.beam_line.turn_of_step`, with its three vectors a and their rates.
"""

from __future__ import annotations

from kanefe.kernels.algebra.vectors import Numbers, cross, minus, plus, skew_product, times
from kanefe.kernels.compiler._numba import inlined


@inlined
def _skew(a: Numbers) -> Numbers:
    """Return a~."""
    zero = 0.0 * a[0]
    return zero, -a[2], a[1], a[2], zero, -a[0], -a[1], a[0], zero


@inlined
def _sum(A: Numbers, B: Numbers) -> Numbers:
    """Return A + B of matrices."""
    return (
        A[0] + B[0], A[1] + B[1], A[2] + B[2], A[3] + B[3], A[4] + B[4], A[5] + B[5], A[6] + B[6], A[7] + B[7],
        A[8] + B[8],
    )  # fmt: skip


@inlined
def _scaled(s: float, A: Numbers) -> Numbers:
    """Return s A of a matrix."""
    return s * A[0], s * A[1], s * A[2], s * A[3], s * A[4], s * A[5], s * A[6], s * A[7], s * A[8]


@inlined
def _shifted(s: float, A: Numbers) -> Numbers:
    """Return A + s 1."""
    return A[0] + s, A[1], A[2], A[3], A[4] + s, A[5], A[6], A[7], A[8] + s


@inlined
def turn_of_step(
    a1: Numbers, a2: Numbers, a3: Numbers, d1: Numbers, d2: Numbers, d3: Numbers
) -> tuple[Numbers, Numbers, Numbers, Numbers, Numbers, Numbers]:
    """Return the rotation vector of the step, its two rates, and its derivatives by a1, a2 and a3."""
    c1 = cross(a2, a1)
    e = plus(times(2.0, a3), c1)
    c2 = times(-1.0 / 60.0, cross(e, a1))
    f, g = minus(minus(c1, times(20.0, a1)), a3), plus(a2, c2)
    omega = plus(plus(a1, times(1.0 / 12.0, a3)), times(1.0 / 240.0, cross(g, f)))

    dc1 = plus(cross(d2, a1), cross(a2, d1))
    de = plus(times(2.0, d3), dc1)
    dc2 = times(-1.0 / 60.0, plus(cross(de, a1), cross(e, d1)))
    df, dg = minus(minus(dc1, times(20.0, d1)), d3), plus(d2, dc2)
    rate = plus(plus(d1, times(1.0 / 12.0, d3)), times(1.0 / 240.0, plus(cross(dg, f), cross(g, df))))

    ddc1 = times(2.0, cross(d2, d1))
    ddc2 = times(-1.0 / 60.0, plus(cross(ddc1, a1), times(2.0, cross(de, d1))))
    second = times(1.0 / 240.0, plus(plus(cross(ddc2, f), times(2.0, cross(dg, df))), cross(g, ddc1)))

    # by a1, a2, a3: of c1, of c2 = -e x a1 / 60, then of f and g
    by_a1, by_a2 = _skew(a2), _scaled(-1.0, _skew(a1))
    c2_by_a1 = _scaled(-1.0 / 60.0, _sum(_scaled(-1.0, skew_product(a1, by_a1)), _skew(e)))
    c2_by_a2 = _scaled(1.0 / 60.0, skew_product(a1, by_a2))
    c2_by_a3 = _scaled(2.0 / 60.0, _skew(a1))
    first = _of_product(f, g, _shifted(-20.0, by_a1), c2_by_a1)
    middle = _of_product(f, g, by_a2, _shifted(1.0, c2_by_a2))
    zero = 0.0 * a1[0]
    none = zero, zero, zero, zero, zero, zero, zero, zero, zero
    last = _of_product(f, g, _shifted(-1.0, none), c2_by_a3)
    return omega, rate, second, _shifted(1.0, first), middle, _shifted(1.0 / 12.0, last)


@inlined
def _of_product(f: Numbers, g: Numbers, of_f: Numbers, of_g: Numbers) -> Numbers:
    """Return the derivative of ``g x f / 240``."""
    return _scaled(1.0 / 240.0, _sum(_scaled(-1.0, skew_product(f, of_g)), skew_product(g, of_f)))
