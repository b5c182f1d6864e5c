"""Fields of heights: ground that is not flat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from kanefe.contact.geometry.shape import SurfaceShape
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector, numbers
from kanefe.kernels.contact import contact_shapes as kernels
from kanefe.kernels.contact.contact_shapes import LIMITS, cell_of, foot_on_heights, weight_of
from kanefe.kernels.values.tensors import Vector as Numbers
from kanefe.loads.reach import Bounds

OVERSHOOT = 9.0 / 32.0
"""Overshoot of cubic convolution relative to the differences of heights, at most: the sum of the negative weights
halfway between grid points."""

STEEPER = 2.0
"""Largest slope relative to that between two grid points: 3/2 along the grid times 5/4 from the weights across."""


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
        ground = foot_on_heights(kernels.HeightField(self.listed), Numbers(*place.tolist()))
        foot, gradient = np.array(ground.place.numbers), np.array((ground.slope_x, ground.slope_y))
        length = math.sqrt(1.0 + gradient @ gradient)
        normal = np.append(-gradient, 1.0) / length
        across = np.eye(3) - np.outer(normal, normal)
        bent = np.zeros((3, 3))
        bent[:2, :2] = np.array(((ground.xx, ground.xy), (ground.xy, ground.yy))) / -length
        S = across @ bent @ across
        outwards = np.eye(3) + float(normal @ (place - foot)) * S
        if np.linalg.det(outwards) < LIMITS.narrow:  # over a valley in which no ball lies from here
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


def _weight_rows(places: Vector, at: Vector) -> Matrix:
    """Return the weights of the heights at all places of the grid, (len(at), len(places))."""
    rows, last = np.zeros((len(at), len(places))), len(places) - 1
    for row, x in zip(rows, at.tolist(), strict=True):
        i, f, _ = cell_of(x, places[0], places[1] - places[0], len(places))
        for k in range(4):
            row[min(max(i + k - 1, 0), last)] += weight_of(k, f)[0]
    return rows
