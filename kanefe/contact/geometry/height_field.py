"""Fields of heights: ground that is not flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.loads.reach import Bounds

OVERSHOOT = 9.0 / 32.0
"""Overshoot of cubic convolution relative to the differences of heights, at most: the sum of the negative weights
halfway between grid points."""

STEEPER = 2.0
"""Largest slope relative to that between two grid points: 3/2 along the grid times 5/4 from the weights across."""

CLOSE, MOST_STEPS = 1e-9, 20
"""Last step of the search for the nearest point, relative to the finer grid step, and largest number of steps."""

NARROW = 1e-3
"""Fraction of the radius of curvature, for a point above a valley, below which the search does not follow it."""


@dataclass(frozen=True, eq=False)
class HeightField(SurfaceShape):
    """Heights z over a grid of x and y, with slopes that are continuous, and all that is below.

    Parameters
    ----------
    x, y : array_like, shapes (m,), (n,)
        Places of the grid, evenly spaced, m; three or more. Beyond it the surface goes on level.
    heights : array_like, shape (m, n)
        m.
    """

    x: Any
    y: Any
    heights: Any
    kind = 7

    def __post_init__(self) -> None:
        x, y, heights = numbers(self.x), numbers(self.y), numbers(self.heights)
        for name, places in (("x", x), ("y", y)):
            steps = np.diff(places) if places.ndim == 1 else np.zeros(0)
            if len(steps) < 2 or not np.all(steps > 0.0) or not np.allclose(steps, steps[0], rtol=1e-6, atol=0.0):
                raise ModelError(
                    f"{name} of a height field must be three or more numbers, evenly spaced and increasing"
                )
        if heights.shape != (len(x), len(y)) or not np.all(np.isfinite(heights)):
            raise ModelError(
                f"heights of a height field must be finite, shape {(len(x), len(y))} as x and y, not {heights.shape}"
            )
        for name, value in (("x", x), ("y", y), ("heights", heights)):
            object.__setattr__(self, name, value)

    def distance(self, x: Vector) -> tuple[float, Vector]:
        """Return the signed distance of a point from it, m, and its normal: see `_foot`."""
        place = np.asarray(x, dtype=float)
        foot, gradient, _ = self._foot(place)
        normal = np.append(-gradient, 1.0) / math.sqrt(1.0 + gradient @ gradient)
        return float(normal @ (place - foot)), normal

    def _foot(self, x: Vector) -> tuple[Vector, Vector, Matrix]:
        """Return the place of it that is nearest to a point, and the first and second derivatives of the height there.

        Newton's method finds where ``x - foot`` is along the normal, from the place below. Where that is not a smallest
        distance, as over a valley that is narrower than the point is high, it is the place below itself.
        """
        p = x[:2]
        finest = min(self.x[1] - self.x[0], self.y[1] - self.y[0])
        is_found = False
        for left in range(MOST_STEPS, -1, -1):
            height, gradient, bends = self._local(p)
            if is_found or not left:
                break
            rise = x[2] - height
            jacobian = np.eye(2) + np.outer(gradient, gradient) - rise * bends
            least = jacobian[0, 0] * jacobian[1, 1] - jacobian[0, 1] * jacobian[1, 0]
            if least <= 0.0 or jacobian[0, 0] <= 0.0:
                height, gradient, bends = self._local(x[:2])
                p = x[:2]
                break
            a, b = p - x[:2] - rise * gradient
            step = np.array((jacobian[1, 1] * a - jacobian[0, 1] * b, jacobian[0, 0] * b - jacobian[1, 0] * a)) / least
            p = p - step
            is_found = bool(step @ step <= (CLOSE * finest) ** 2)  # what is left is its square
        return np.append(p, height), gradient, bends

    def _local(self, p: Vector) -> tuple[float, Vector, Matrix]:
        """Return the height at a place, and its first and second derivatives."""
        (i, a, da), (j, b, db) = _weights(self.x, p[0]), _weights(self.y, p[1])
        near = self.heights[np.ix_(i, j)]
        across = da @ near @ db
        bends = np.array(((_bends(self.x, p[0]) @ near @ b, across), (across, a @ near @ _bends(self.y, p[1]))))
        return float(a @ near @ b), np.array((da @ near @ b, a @ near @ db)), bends

    @property
    def bounds(self) -> Bounds:
        """All below its highest place; balls are measured along the normal, which leans by the steepest slope."""
        steps = self.x[1] - self.x[0], self.y[1] - self.y[0]
        rises = [np.abs(np.diff(self.heights, axis=axis)).max() for axis in (0, 1)]
        slopes = [STEEPER * rise / step for rise, step in zip(rises, steps, strict=True)]
        over = OVERSHOOT * float(np.ptp(self.heights))
        top = np.array((np.inf, np.inf, float(self.heights.max()) + over))
        return Bounds(upper=top, stretch=math.sqrt(1.0 + slopes[0] ** 2 + slopes[1] ** 2))

    @property
    def narrowest(self) -> float:
        """Radius of its narrowest valley, m, along x or y by the heights of the grid; infinite if it has none."""
        steps = self.x[1] - self.x[0], self.y[1] - self.y[0]
        bend = max(float(np.diff(self.heights, 2, axis).max() / step**2) for axis, step in enumerate(steps))
        return 1.0 / bend if bend > 0.0 else math.inf

    @property
    def is_smooth(self) -> bool:
        """Its slopes are continuous, and their derivatives are where points are between two places of the grid."""
        return True

    def curvature(self, x: Vector) -> Matrix:
        """Return the derivatives of the normal, 1/m: of the surface ``P B P / |(-h', 1)|``, farther out less."""
        place = np.asarray(x, dtype=float)
        foot, gradient, bends = self._foot(place)
        length = math.sqrt(1.0 + gradient @ gradient)
        normal = np.append(-gradient, 1.0) / length
        across = np.eye(3) - np.outer(normal, normal)
        bent = np.zeros((3, 3))
        bent[:2, :2] = -bends / length
        S = across @ bent @ across
        outwards = np.eye(3) + float(normal @ (place - foot)) * S
        if np.linalg.det(outwards) < NARROW:  # over a valley in which no ball lies from here
            return np.asarray(S)
        return np.asarray(S @ np.linalg.inv(outwards))

    @property
    def numbers(self) -> Vector:
        """First place and step of both directions, how many places, and heights."""
        dx, dy = self.x[1] - self.x[0], self.y[1] - self.y[0]
        return np.concatenate(((self.x[0], dx, len(self.x), self.y[0], dy, len(self.y)), self.heights.ravel()))


def heights_at(field: HeightField, x: Vector, y: Vector) -> Matrix:
    """Return the heights of a field at all pairs of places x (a,) and y (b,), shape (a, b), m."""
    along, across = (_weight_rows(places, at) for places, at in ((field.x, x), (field.y, y)))
    return np.asarray(along @ field.heights @ across.T)


def _weights(places: Vector, x: float) -> tuple[list[int], Vector, Vector]:
    """Return four places about x and the weights of values and slopes there, of cubic convolution (Keys 1981)."""
    n, step = len(places), places[1] - places[0]
    s = (x - places[0]) / step
    held = min(max(s, 0.0), n - 1.0)
    at = min(int(held), n - 2)
    f = held - at
    rate = (1.0 if held == s else 0.0) / step
    weights = 0.5 * np.array((-f + 2 * f**2 - f**3, 2 - 5 * f**2 + 3 * f**3, f + 4 * f**2 - 3 * f**3, -(f**2) + f**3))
    slopes = 0.5 * rate * np.array((-1 + 4 * f - 3 * f**2, -10 * f + 9 * f**2, 1 + 8 * f - 9 * f**2, -2 * f + 3 * f**2))
    return [min(max(at + k, 0), n - 1) for k in (-1, 0, 1, 2)], weights, slopes


def _weight_rows(places: Vector, at: Vector) -> Matrix:
    """Return the weights of the heights at all places of the grid, (len(at), len(places))."""
    rows = np.zeros((len(at), len(places)))
    for row, x in zip(rows, at, strict=True):
        near, weights, _ = _weights(places, x)
        np.add.at(row, near, weights)
    return rows


def _bends(places: Vector, x: float) -> Vector:
    """Return the weights of second derivatives at the four places that `_weights` names."""
    n, step = len(places), places[1] - places[0]
    s = (x - places[0]) / step
    if not 0.0 <= s <= n - 1.0:
        return np.zeros(4)
    f = s - min(int(s), n - 2)
    return 0.5 / step**2 * np.array((4 - 6 * f, -10 + 18 * f, 8 - 18 * f, -2 + 6 * f))
