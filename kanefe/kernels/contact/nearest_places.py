"""The places of segments and triangles that are nearest to the origin, and which ends they lie between, by bits."""

from kanefe.kernels.language import Vector, cross, dot, inlined, kernel


@inlined
def on_segment(a: Vector, b: Vector) -> tuple[Vector, int]:
    """Return the place of a segment nearest to the origin, and the ends that it lies between, by bits."""
    side = b - a
    square, share = dot(side, side), -dot(a, side)
    if share <= 0.0 or square == 0.0:
        return a, 1
    if share >= square:
        return b, 2
    return a + (share / square) * side, 3


@kernel
def on_triangle(a: Vector, b: Vector, c: Vector) -> tuple[Vector, int]:
    """Return the same of a triangle (Ericson, Real-Time Collision Detection, 2005, 5.1.5)."""
    ab, ac = b - a, c - a
    d1, d2 = -dot(ab, a), -dot(ac, a)
    if d1 <= 0.0 and d2 <= 0.0:
        return a, 1
    d3, d4 = -dot(ab, b), -dot(ac, b)
    if d3 >= 0.0 and d4 <= d3:
        return b, 2
    if d1 * d4 - d3 * d2 <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return a + (d1 / (d1 - d3)) * ab, 3
    d5, d6 = -dot(ab, c), -dot(ac, c)
    if d6 >= 0.0 and d5 <= d6:
        return c, 4
    if d5 * d2 - d1 * d6 <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return a + (d2 / (d2 - d6)) * ac, 5
    if d3 * d6 - d5 * d4 <= 0.0 and d4 >= d3 and d5 >= d6:
        return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b), 6
    bc = c - b
    if dot(ab, ab) > dot(bc, bc) and dot(ab, ab) >= dot(ac, ac):
        return within(c, a, b), 7
    return (within(b, c, a) if dot(ac, ac) > dot(bc, bc) else within(a, b, c)), 7


@inlined
def within(a: Vector, b: Vector, c: Vector) -> Vector:
    """Return the place of a triangle nearest to the origin, which lies over it; its longest side is opposite to a.

    What is between the vertices is right to round-off, also where two of them are close together and the normal of the
    triangle is hardly known.
    """
    ab, ac = b - a, c - a
    n = cross(ab, ac)
    square = dot(n, n)
    if square == 0.0:
        return a
    s = min(max(-dot(cross(a, ac), n) / square, 0.0), 1.0)
    t = min(max(-dot(cross(ab, a), n) / square, 0.0), 1.0 - s)
    return a + (s * ab + t * ac)
