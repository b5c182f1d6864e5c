"""Signed distances of shapes that things touch, and their normals: see `kanefe.contact.shapes`.

A shape is its kind and numbers, in a list of numbers from a place on.
"""

from collections import namedtuple
from enum import IntEnum
from typing import Annotated, Any, NamedTuple

import numpy as np

from kanefe.kernels.contact.contact_mesh import Away, Mesh, mesh_distance
from kanefe.kernels.language import Behind, Record, across, inlined, kernel, norm
from kanefe.kernels.values.tensors import Matrix, Symmetric, Vector, congruent, cross, diagonal, dot, square


class Limits(NamedTuple):
    """From where on numbers count in a search."""

    close: float = 1e-9
    most_steps: int = 20
    """Smallest step of the search for the nearest point of a height field, relative to its grid, and most steps."""
    narrow: float = 1e-3
    """Fraction of the radius of curvature, for a point above a valley, below which the search does not follow it."""


LIMITS = Limits()


class ShapeKind(IntEnum):
    """Kinds of shapes; 6 is none with a distance."""

    PLANE = 0
    SPHERE = 1
    CAPSULE = 2
    CYLINDER = 3
    BOX = 4
    TORUS = 5
    HEIGHT_FIELD = 7
    MESH = 8


class Plane(Record):
    """A plane through the origin."""

    kind: float
    normal: Vector


class Sphere(Record):
    """A ball: m, and 1, or -1 of a room."""

    kind: float
    radius: float
    side: float


class Capsule(Record):
    """A capsule, m."""

    kind: float
    radius: float
    length: float
    axis: Vector


class Cylinder(Capsule):
    """A cylinder, and 1, or -1 of a room."""

    side: float


class Box(Record):
    """A box, m, and 1, or -1 of a room."""

    kind: float
    size: Vector
    side: float


class Torus(Record):
    """A torus: radius of its circle and of its tube, m."""

    kind: float
    radius: float
    tube: float
    axis: Vector


class HeightField(Record):
    """Heights over places of a grid: first place, step and number of places along x and y, and heights, m."""

    kind: float
    x: float
    x_step: float
    rows: float
    y: float
    y_step: float
    columns: float
    heights: Annotated[Any, Behind()]


Ground = namedtuple("Ground", "place slope_x slope_y xx xy yy")
"""A place on a field of heights, and the derivatives of the height there."""


@inlined
def along(x: Vector, length: Any) -> Vector:
    """Return the direction of a vector of known length; z where it has none."""
    zero = 0.0 * length
    return (1.0 / length) * x if length.real > 0.0 else Vector(zero, zero, zero + 1.0)


@inlined
def about(offset: Vector, radius: float) -> Away:
    """Return the distance from a ball about a place that is so far away, and its normal."""
    r = norm(offset)
    return Away(r - radius, along(offset, r))


@inlined
def distance(numbers: Any, at: int, x: Vector) -> Away:
    """Return the signed distance of a point, and the normal."""
    kind = int(numbers[at])
    if kind == ShapeKind.PLANE:
        n = Plane(numbers, at).normal
        return Away(dot(n, x), n + 0.0 * x)
    if kind == ShapeKind.SPHERE:
        ball = Sphere(numbers, at)
        found = about(x, ball.radius)
        return Away(ball.side * found.gap, ball.side * found.normal)
    if kind == ShapeKind.CAPSULE:
        capsule = Capsule(numbers, at)
        half, height = 0.5 * capsule.length, dot(capsule.axis, x)
        if abs(height.real) > half:
            height = 0.0 * height + (half if height.real > 0.0 else -half)
        return about(x - height * capsule.axis, capsule.radius)
    if kind == ShapeKind.CYLINDER:
        return _cylinder(Cylinder(numbers, at), x)
    if kind == ShapeKind.BOX:
        return _box(Box(numbers, at), x)
    if kind == ShapeKind.TORUS:
        torus = Torus(numbers, at)
        outward = across(x, torus.axis)
        return about(x - torus.radius * along(outward, norm(outward)), torus.tube)
    if kind == ShapeKind.MESH:
        return mesh_distance(Mesh(numbers, at), x)
    return _height_field(HeightField(numbers, at), x)


@inlined
def distance_in(p: Vector, A: Matrix, numbers: Any, at: int, point: Vector) -> Away:
    """Return the signed distance of a place in N of a shape that is placed and turned, and the normal in N."""
    if int(numbers[at]) == ShapeKind.PLANE:  # most often
        normal = A @ Plane(numbers, at).normal
        return Away(dot(normal, point - p), normal)
    found = distance(numbers, at, A.T @ (point - p))
    return Away(found.gap, A @ found.normal)


@inlined
def _cylinder(shape: Cylinder, x: Vector) -> Away:
    axis, side = shape.axis, shape.side
    height = dot(axis, x)
    outward = x - height * axis
    rho = norm(outward)
    outward = along(outward, rho)
    sign = -1.0 if height.real < 0.0 else 1.0
    over, beyond = rho - shape.radius, sign * height - 0.5 * shape.length
    a = b = 0.0 * height
    if over.real > 0.0 and beyond.real > 0.0:
        far = np.sqrt(over * over + beyond * beyond)
        a, b = over / far, beyond / far
    elif over.real > beyond.real:
        far, a = over, a + 1.0
    else:
        far, b = beyond, b + 1.0
    return Away(side * far, (side * a) * outward + (side * sign * b) * axis)


@inlined
def _box(shape: Box, x: Vector) -> Away:
    zero, side, size = 0.0 * x.x, shape.side, shape.size
    sx = -1.0 if x.x.real < 0.0 else 1.0
    sy = -1.0 if x.y.real < 0.0 else 1.0
    sz = -1.0 if x.z.real < 0.0 else 1.0
    ox, oy, oz = sx * x.x - 0.5 * size.x, sy * x.y - 0.5 * size.y, sz * x.z - 0.5 * size.z
    if ox.real > 0.0 or oy.real > 0.0 or oz.real > 0.0:
        px = ox if ox.real > 0.0 else zero
        py = oy if oy.real > 0.0 else zero
        pz = oz if oz.real > 0.0 else zero
        far = norm(Vector(px, py, pz))
        return Away(side * far, (side / far) * Vector(sx * px, sy * py, sz * pz))
    if ox.real >= oy.real and ox.real >= oz.real:
        return Away(side * ox, Vector(zero + side * sx, zero, zero))
    if oy.real >= oz.real:
        return Away(side * oy, Vector(zero, zero + side * sy, zero))
    return Away(side * oz, Vector(zero, zero, zero + side * sz))


@inlined
def _height_field(field: HeightField, x: Vector) -> Away:
    """Return distance and normal from the nearest place."""
    ground = foot_on_heights(field, x)
    n = normal_of(ground)
    return Away(dot(n, x - ground.place), n)


@inlined
def normal_of(ground: Ground) -> Vector:
    """Return the normal of a field of heights at a place."""
    n = Vector(-ground.slope_x, -ground.slope_y, 0.0 * ground.slope_x + 1.0)
    return (1.0 / norm(n)) * n


@kernel
def foot_on_heights(field: HeightField, x: Vector) -> Ground:
    """Return where a field of heights is nearest to a place.

    Newton's method finds where ``x - foot`` is along the normal, from the place below. Where that is not a smallest
    distance, as over a valley that is narrower than the point is high, it is the place below itself.
    """
    finest = min(field.x_step, field.y_step)
    a, b = x.x, x.y
    is_found = False
    for left in range(LIMITS.most_steps, -1, -1):
        ground = heights(field, a, b)
        if is_found or left == 0:
            break
        slope_x, slope_y, rise = ground.slope_x, ground.slope_y, x.z - ground.place.z
        j_xx, j_yy = 1.0 + slope_x * slope_x - rise * ground.xx, 1.0 + slope_y * slope_y - rise * ground.yy
        j_xy = slope_x * slope_y - rise * ground.xy
        least = j_xx * j_yy - j_xy * j_xy
        if least.real <= 0.0 or j_xx.real <= 0.0:
            ground = heights(field, x.x, x.y)
            break
        off_x, off_y = a - x.x - rise * slope_x, b - x.y - rise * slope_y
        step_x, step_y = (j_yy * off_x - j_xy * off_y) / least, (j_xx * off_y - j_xy * off_x) / least
        a, b = a - step_x, b - step_y
        is_found = step_x.real**2 + step_y.real**2 <= (LIMITS.close * finest) ** 2
    return ground


@kernel
def heights(field: HeightField, x: Any, y: Any) -> Ground:
    """Return the height at a place, and its first and second derivatives."""
    rows, columns, given = int(field.rows), int(field.columns), field.heights
    i, f, f_rate = cell_of(x, field.x, field.x_step, rows)
    j, g, g_rate = cell_of(y, field.y, field.y_step, columns)
    height = slope_x = slope_y = xx = xy = yy = 0.0 * x
    for a in range(4):
        row = min(max(i + a - 1, 0), rows - 1)
        value = along = bent = 0.0 * x
        for b in range(4):
            h = given[columns * row + min(max(j + b - 1, 0), columns - 1)]
            weight, slope, bend = weight_of(b, g)
            value += weight * h
            along += g_rate * slope * h
            bent += g_rate * g_rate * bend * h
        weight, slope, bend = weight_of(a, f)
        height += weight * value
        slope_x += f_rate * slope * value
        slope_y += weight * along
        xx += f_rate * f_rate * bend * value
        xy += f_rate * slope * along
        yy += weight * bent
    return Ground(Vector(x, y, height), slope_x, slope_y, xx, xy, yy)


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
    """Return the weight of one of four places in cubic convolution (Keys 1981), and its first two derivatives."""
    if k == 0:
        return 0.5 * f * (f * (2.0 - f) - 1.0), 0.5 * (f * (4.0 - 3.0 * f) - 1.0), 2.0 - 3.0 * f
    if k == 1:
        return 1.0 + 0.5 * f * f * (3.0 * f - 5.0), 0.5 * f * (9.0 * f - 10.0), 9.0 * f - 5.0
    if k == 2:
        return 0.5 * f * (f * (4.0 - 3.0 * f) + 1.0), 0.5 * (f * (8.0 - 9.0 * f) + 1.0), 4.0 - 9.0 * f
    return 0.5 * f * f * (f - 1.0), 0.5 * f * (3.0 * f - 2.0), 3.0 * f - 1.0


@inlined
def normal_rate(numbers: Any, at: int, x: Vector, v: Vector) -> Vector:
    """Return the rate of the normal at a point that moves past a plane, sphere or height field: ``H v``."""
    kind = int(numbers[at])
    if kind == ShapeKind.SPHERE:
        r = norm(x)
        return (Sphere(numbers, at).side / r) * across(v, along(x, r))
    if kind == ShapeKind.HEIGHT_FIELD:
        return _rate_over_heights(HeightField(numbers, at), x, v)
    return 0.0 * v


@inlined
def _rate_over_heights(field: HeightField, x: Vector, v: Vector) -> Vector:
    """Return the rate of the normal over a field of heights: of its surface ``S v``, farther out less."""
    ground = foot_on_heights(field, x)
    n = normal_of(ground)
    zero = 0.0 * n.x
    bent = -n.z * Symmetric(ground.xx, ground.xy, zero, ground.yy, zero, zero)
    S = congruent((diagonal(zero + 1.0) - square(n, n)).full, bent)
    out = diagonal(zero + 1.0) + dot(n, x - ground.place) * S
    M, rate = out.full, S @ v
    if dot(M.x, cross(M.y, M.z)).real < LIMITS.narrow:  # over a valley in which no ball lies from here
        return rate
    return out.inverse @ rate  # S commutes with what it is divided by
