"""Rotation over one step of a line of given curvature, and how it moves: a Magnus expansion of sixth order.

The kernel of `kanefe.bodies.exact.beam_line.turn_of_step`, with its three vectors a and their rates.
"""

from kanefe.kernels.language import IDENTITY, Matrix, Vector, cross, inlined, skew


@inlined
def turn_of_step(
    a1: Vector, a2: Vector, a3: Vector, d1: Vector, d2: Vector, d3: Vector
) -> tuple[Vector, Vector, Vector, Matrix, Matrix, Matrix]:
    """Return the rotation vector of the step, its two rates, and its derivatives by a1, a2 and a3."""
    c1 = cross(a2, a1)
    e = 2.0 * a3 + c1
    c2 = (-1.0 / 60.0) * cross(e, a1)
    f, g = c1 - 20.0 * a1 - a3, a2 + c2
    omega = a1 + (1.0 / 12.0) * a3 + (1.0 / 240.0) * cross(g, f)

    dc1 = cross(d2, a1) + cross(a2, d1)
    de = 2.0 * d3 + dc1
    dc2 = (-1.0 / 60.0) * (cross(de, a1) + cross(e, d1))
    df, dg = dc1 - 20.0 * d1 - d3, d2 + dc2
    rate = d1 + (1.0 / 12.0) * d3 + (1.0 / 240.0) * (cross(dg, f) + cross(g, df))

    ddc1 = 2.0 * cross(d2, d1)
    ddc2 = (-1.0 / 60.0) * (cross(ddc1, a1) + 2.0 * cross(de, d1))
    second = (1.0 / 240.0) * (cross(ddc2, f) + 2.0 * cross(dg, df) + cross(g, ddc1))

    # by a1, a2, a3: of c1, of c2 = -e x a1 / 60, then of f and g
    by_a1, by_a2 = skew(a2).full, (-skew(a1)).full
    c2_by_a1 = (-1.0 / 60.0) * (skew(e).full - skew(a1) @ by_a1)
    c2_by_a2 = (1.0 / 60.0) * (skew(a1) @ by_a2)
    c2_by_a3 = (2.0 / 60.0) * skew(a1).full
    first = _of_product(f, g, by_a1 - 20.0 * IDENTITY, c2_by_a1)
    middle = _of_product(f, g, by_a2, c2_by_a2 + IDENTITY)
    last = (-1.0 / 240.0) * (skew(f) @ c2_by_a3 + skew(g).full)
    return omega, rate, second, first + IDENTITY, middle, last + (1.0 / 12.0) * IDENTITY


@inlined
def _of_product(f: Vector, g: Vector, of_f: Matrix, of_g: Matrix) -> Matrix:
    """Return the derivative of ``g x f / 240``."""
    return (1.0 / 240.0) * (skew(g) @ of_f - skew(f) @ of_g)
