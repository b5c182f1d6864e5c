"""Signed distances of shapes that things touch, and their normals: see `kanefe.contact.shapes`."""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.algebra.vectors import Numbers, cross, dot, minus, norm, plus, product, rotated, three, times
from kanefe.kernels.compiler._numba import inlined, kernel
from kanefe.kernels.contact.contact_mesh import mesh_distance

CLOSE, MOST_STEPS = 1e-9, 20
"""Smallest step of the search for the nearest point of a height field, relative to its grid, and most steps."""

NARROW = 1e-3
"""Fraction of the radius of curvature, for a point above a valley, below which the search does not follow it."""

PLANE, SPHERE, CAPSULE, CYLINDER, BOX, TORUS, _, HEIGHT_FIELD, MESH = range(9)


@inlined
def unit(x: Numbers, length: Any) -> Numbers:
    """Return the direction of a vector of known length; z where it has none."""
    zero = 0.0 * length
    if length.real > 0.0:
        return times(1.0 / length, x)
    return (zero, zero, zero + 1.0)


@kernel
def distance(numbers: Any, at: int, x: Numbers) -> Any:
    """Return the signed distance of a point and the three components of the normal; a shape is its kind and numbers."""
    kind, own = int(numbers[at]), at + 1
    zero = 0.0 * x[0]
    if kind == PLANE:
        n = three(numbers, own)
        return dot(n, x), n[0] + zero, n[1] + zero, n[2] + zero
    if kind == SPHERE:
        r = norm(x)
        n = unit(x, r)
        return (
            numbers[own + 1] * (r - numbers[own]),
            numbers[own + 1] * n[0],
            numbers[own + 1] * n[1],
            numbers[own + 1] * n[2],
        )
    if kind == CAPSULE:
        axis = three(numbers, own + 2)
        along = dot(axis, x)
        if along.real > 0.5 * numbers[own + 1]:
            along = zero + 0.5 * numbers[own + 1]
        elif along.real < -0.5 * numbers[own + 1]:
            along = zero - 0.5 * numbers[own + 1]
        offset = minus(x, times(along, axis))
        r = norm(offset)
        n = unit(offset, r)
        return r - numbers[own], n[0], n[1], n[2]
    if kind == CYLINDER:
        return _cylinder(numbers, own, x)
    if kind == BOX:
        return _box(numbers, own, x)
    if kind == TORUS:
        axis = three(numbers, own + 2)
        outward = minus(x, times(dot(axis, x), axis))
        offset = minus(x, times(numbers[own], unit(outward, norm(outward))))
        r = norm(offset)
        n = unit(offset, r)
        return r - numbers[own + 1], n[0], n[1], n[2]
    if kind == MESH:
        return mesh_distance(numbers, own, x)
    return _height_field(numbers, own, x)


@inlined
def _cylinder(numbers: Any, own: int, x: Numbers) -> Any:
    zero = 0.0 * x[0]
    axis, side = three(numbers, own + 2), numbers[own + 5]
    height = dot(axis, x)
    outward = minus(x, times(height, axis))
    rho = norm(outward)
    outward = unit(outward, rho)
    sign = -1.0 if height.real < 0.0 else 1.0
    over, beyond = rho - numbers[own], sign * height - 0.5 * numbers[own + 1]
    a, b = zero, zero
    if over.real > 0.0 and beyond.real > 0.0:
        far = np.sqrt(over * over + beyond * beyond)
        a, b = over / far, beyond / far
    elif over.real > beyond.real:
        far, a = over, zero + 1.0
    else:
        far, b = beyond, zero + 1.0
    n = plus(times(side * a, outward), times(side * sign * b, axis))
    return side * far, n[0], n[1], n[2]


@inlined
def _box(numbers: Any, own: int, x: Numbers) -> Any:
    zero = 0.0 * x[0]
    side = numbers[own + 3]
    s0 = -1.0 if x[0].real < 0.0 else 1.0
    s1 = -1.0 if x[1].real < 0.0 else 1.0
    s2 = -1.0 if x[2].real < 0.0 else 1.0
    o0, o1, o2 = s0 * x[0] - 0.5 * numbers[own], s1 * x[1] - 0.5 * numbers[own + 1], s2 * x[2] - 0.5 * numbers[own + 2]
    if o0.real > 0.0 or o1.real > 0.0 or o2.real > 0.0:
        p0 = o0 if o0.real > 0.0 else zero
        p1 = o1 if o1.real > 0.0 else zero
        p2 = o2 if o2.real > 0.0 else zero
        far = norm((p0, p1, p2))
        return side * far, side * s0 * p0 / far, side * s1 * p1 / far, side * s2 * p2 / far
    if o0.real >= o1.real and o0.real >= o2.real:
        return side * o0, zero + side * s0, zero, zero
    if o1.real >= o2.real:
        return side * o1, zero, zero + side * s1, zero
    return side * o2, zero, zero, zero + side * s2


@inlined
def _height_field(numbers: Any, own: int, x: Numbers) -> Any:
    """Return distance and normal from the nearest place."""
    a, b, height, slope_x, slope_y, _, _, _ = foot_on_heights(numbers, own, x)
    stretch = np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    n = (-slope_x / stretch, -slope_y / stretch, 1.0 / stretch)
    return dot(n, minus(x, (a, b, height))), n[0], n[1], n[2]


@inlined
def foot_on_heights(numbers: Any, own: int, x: Numbers) -> Any:
    """Return where a field of heights is nearest to a place: along x and y, its height, slopes, and xx, xy, yy.

    Newton's method finds where ``x - foot`` is along the normal, from the place below. Where that is not a smallest
    distance, as over a valley that is narrower than the point is high, it is the place below itself.
    """
    finest = min(numbers[own + 1], numbers[own + 4])
    a, b = x[0], x[1]
    is_found = False
    for left in range(MOST_STEPS, -1, -1):
        height, slope_x, slope_y, xx, xy, yy = _heights(numbers, own, a, b)
        if is_found or left == 0:
            break
        rise = x[2] - height
        j_xx, j_yy = 1.0 + slope_x * slope_x - rise * xx, 1.0 + slope_y * slope_y - rise * yy
        j_xy = slope_x * slope_y - rise * xy
        least = j_xx * j_yy - j_xy * j_xy
        if least.real <= 0.0 or j_xx.real <= 0.0:
            a, b = x[0], x[1]
            height, slope_x, slope_y, xx, xy, yy = _heights(numbers, own, a, b)
            break
        off_x, off_y = a - x[0] - rise * slope_x, b - x[1] - rise * slope_y
        step_x, step_y = (j_yy * off_x - j_xy * off_y) / least, (j_xx * off_y - j_xy * off_x) / least
        a, b = a - step_x, b - step_y
        far = step_x.real * step_x.real + step_y.real * step_y.real
        is_found = far <= CLOSE * CLOSE * finest * finest
    return a, b, height, slope_x, slope_y, xx, xy, yy


@kernel
def _heights(numbers: Any, own: int, x: Any, y: Any) -> Any:
    """Return the height at a place, and its first and second derivatives: along x, y; xx, xy, yy."""
    rows, columns = int(numbers[own + 2]), int(numbers[own + 5])
    i, f, f_rate = cell_of(x, numbers[own], numbers[own + 1], rows)
    j, g, g_rate = cell_of(y, numbers[own + 3], numbers[own + 4], columns)
    height = slope_x = slope_y = xx = xy = yy = 0.0 * x
    for a in range(4):
        row = min(max(i + a - 1, 0), rows - 1)
        value = along = bent = 0.0 * x
        for b in range(4):
            h = numbers[own + 6 + columns * row + min(max(j + b - 1, 0), columns - 1)]
            value += weight_of(b, g) * h
            along += g_rate * _slope(b, g) * h
            bent += g_rate * g_rate * _bend(b, g) * h
        height += weight_of(a, f) * value
        slope_x += f_rate * _slope(a, f) * value
        slope_y += weight_of(a, f) * along
        xx += f_rate * f_rate * _bend(a, f) * value
        xy += f_rate * _slope(a, f) * along
        yy += weight_of(a, f) * bent
    return height, slope_x, slope_y, xx, xy, yy


@inlined
def cell_of(x: Any, first: float, step: float, count: int) -> Any:
    """Return the interval of a grid, the place in it, of 1, and the rate of that; beyond the grid it stands still."""
    s, rate = (x - first) / step, 1.0 / step
    if s.real < 0.0 or s.real > count - 1.0:
        s, rate = 0.0 * s + min(max(s.real, 0.0), count - 1.0), 0.0
    at = min(int(s.real), count - 2)
    return at, s - at, rate


@inlined
def weight_of(k: int, f: Any) -> Any:
    """Return the weight of one of four places in cubic convolution (Keys 1981)."""
    if k == 0:
        return 0.5 * f * (f * (2.0 - f) - 1.0)
    if k == 1:
        return 1.0 + 0.5 * f * f * (3.0 * f - 5.0)
    if k == 2:
        return 0.5 * f * (f * (4.0 - 3.0 * f) + 1.0)
    return 0.5 * f * f * (f - 1.0)


@inlined
def _slope(k: int, f: Any) -> Any:
    """Return the derivative of `weight_of`."""
    if k == 0:
        return 0.5 * (f * (4.0 - 3.0 * f) - 1.0)
    if k == 1:
        return 0.5 * f * (9.0 * f - 10.0)
    if k == 2:
        return 0.5 * (f * (8.0 - 9.0 * f) + 1.0)
    return 0.5 * f * (3.0 * f - 2.0)


@inlined
def _bend(k: int, f: Any) -> Any:
    """Return the derivative of `_slope`."""
    if k == 0:
        return 2.0 - 3.0 * f
    if k == 1:
        return 9.0 * f - 5.0
    if k == 2:
        return 4.0 - 9.0 * f
    return 3.0 * f - 1.0


@kernel
def normal_rate(numbers: Any, at: int, x: Numbers, v: Numbers) -> Numbers:
    """Return the rate of the normal at a point that moves past a plane, sphere or height field: ``H v``."""
    kind, own = int(numbers[at]), at + 1
    zero = 0.0 * x[0]
    if kind == SPHERE:
        r = norm(x)
        n = unit(x, r)
        return times(numbers[own + 1] / r, minus(v, times(dot(n, v), n)))
    if kind == HEIGHT_FIELD:
        return _rate_over_heights(numbers, own, x, v)
    return zero, zero, zero


@inlined
def _rate_over_heights(numbers: Any, own: int, x: Numbers, v: Numbers) -> Numbers:
    """Return the rate of the normal over a field of heights: of its surface ``S v``, farther out less."""
    a, b, height, slope_x, slope_y, xx, xy, yy = foot_on_heights(numbers, own, x)
    length = np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    n = (-slope_x / length, -slope_y / length, 1.0 / length)
    zero = 0.0 * length
    bent = (-xx / length, -xy / length, zero, -xy / length, -yy / length, zero, zero, zero, zero)
    one = zero + 1.0
    flat = minus_outer((one, zero, zero, zero, one, zero, zero, zero, one), n)
    S = product(product(flat, bent), flat)
    rise = dot(n, minus(x, (a, b, height)))
    out = (
        1.0 + rise * S[0],
        rise * S[1],
        rise * S[2],
        rise * S[3],
        1.0 + rise * S[4],
        rise * S[5],
        rise * S[6],
        rise * S[7],
        1.0 + rise * S[8],
    )
    first, second, third = (out[0], out[3], out[6]), (out[1], out[4], out[7]), (out[2], out[5], out[8])
    size = dot(first, cross(second, third))
    if size.real < NARROW:  # over a valley in which no ball lies from here
        return rotated(S, v)
    # S commutes with what it is divided by
    right = rotated(S, v)
    return times(
        1.0 / size,
        (
            dot(right, cross(second, third)),
            dot(first, cross(right, third)),
            dot(first, cross(second, right)),
        ),
    )


@inlined
def minus_outer(A: Numbers, n: Numbers) -> Numbers:
    """Return ``A - n n^T``."""
    return (
        A[0] - n[0] * n[0],
        A[1] - n[0] * n[1],
        A[2] - n[0] * n[2],
        A[3] - n[1] * n[0],
        A[4] - n[1] * n[1],
        A[5] - n[1] * n[2],
        A[6] - n[2] * n[0],
        A[7] - n[2] * n[1],
        A[8] - n[2] * n[2],
    )
