"""Fields of heights: ground that is not flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.contact.shape import SurfaceShape
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.loads.reach import Bounds

OVERSHOOT = 9.0 / 32.0
"""Of the differences of heights: by how much cubic convolution goes beyond them, at most: the sum of the weights below
zero halfway between places of a grid."""

STEEPER = 2.0
"""Times the slope between two places of the grid: the most there is, 3/2 along it times 5/4 of the weights across."""


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
        """Return the distance of a point from the tangent plane below it, m, and its normal."""
        place = np.asarray(x, dtype=float)
        (i, a, da), (j, b, db) = _weights(self.x, place[0]), _weights(self.y, place[1])
        near = self.heights[np.ix_(i, j)]
        gradient = np.array((da @ near @ b, a @ near @ db))
        stretch = math.sqrt(1.0 + gradient @ gradient)
        return float(place[2] - a @ near @ b) / stretch, np.append(-gradient, 1.0) / stretch

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
    def is_smooth(self) -> bool:
        """Its slopes are continuous, and their derivatives are where points are between two places of the grid."""
        return True

    def curvature(self, x: Vector) -> Matrix:
        """Return the derivatives of the normal, 1/m: those of a point on the surface."""
        place = np.asarray(x, dtype=float)
        (i, a, da), (j, b, db) = _weights(self.x, place[0]), _weights(self.y, place[1])
        near = self.heights[np.ix_(i, j)]
        bent = np.zeros((3, 3))
        bent[:2, 0] = -_bends(self.x, place[0]) @ near @ b, -da @ near @ db
        bent[:2, 1] = bent[1, 0], -a @ near @ _bends(self.y, place[1])
        upward = np.array((-da @ near @ b, -a @ near @ db, 1.0))
        length = float(np.linalg.norm(upward))
        normal = upward / length
        return np.asarray((np.eye(3) - np.outer(normal, normal)) @ bent / length)

    @property
    def numbers(self) -> Vector:
        """First place and step of both directions, how many places, and heights."""
        dx, dy = self.x[1] - self.x[0], self.y[1] - self.y[0]
        return np.concatenate(((self.x[0], dx, len(self.x), self.y[0], dy, len(self.y)), self.heights.ravel()))


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


def _bends(places: Vector, x: float) -> Vector:
    """Return the weights of second derivatives at the four places that `_weights` names."""
    n, step = len(places), places[1] - places[0]
    s = (x - places[0]) / step
    if not 0.0 <= s <= n - 1.0:
        return np.zeros(4)
    f = s - min(int(s), n - 2)
    return 0.5 / step**2 * np.array((4 - 6 * f, -10 + 18 * f, 8 - 18 * f, -2 + 6 * f))
