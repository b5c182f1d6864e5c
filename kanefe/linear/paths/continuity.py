"""Whether a step stays on its path: points between its ends are foreseen from what is known, and found.

Newton's method may lead a step to another path whose tangent and stiffness are alike. The polynomial through both ends
and their tangents, and then through a point found between them, foresees points of one smooth path better and better.
No polynomial foresees a jump.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import KroghInterpolator

from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.linear.paths.arc_length import SETTLED, PathLost, Stop, found_beside
from kanefe.linear.paths.loaded_scene import LoadedScene

FORESEEN = 0.1
"""Largest error of the points at the quarters relative to that in the middle.

On a smooth path it is 0.03 times the step over the length on which the path changes; a pole in the plane of complex
lengths, one step beyond an end, makes 0.11. A jump makes 0.56 and more, however small it is. Where both add up, jumps
below a fifth of the error of the smooth path are not seen.
"""

MIDDLE, QUARTERS = 0.5, (0.25, 0.75)
"""Places of the points that are foreseen, relative to the step."""


def check_continuity(scene: LoadedScene, a: Stop, b: Stop) -> None:
    """Raise a PathLost if the step from a to b may have changed to another path, or if it is too long to tell.

    Jumps across which the paths are nearer to each other than the accuracy of a step, `SETTLED`, are not seen.
    """
    to_tangent = np.linalg.pinv(a.balance.small.coordinate_map)

    def part(z: Vector, factor: float) -> Vector:
        return np.append(scene.weights * z, factor / scene.span)

    def place(q: Vector, factor: float) -> Vector:
        return part(to_tangent @ (q - a.q), factor - a.factor)

    row = part(a.ahead.z, a.ahead.factor)
    end = place(b.q, b.factor)
    slope = part(to_tangent @ b.balance.small.coordinate_map @ b.ahead.z, b.ahead.factor)
    slope /= row @ slope
    length = float(row @ end)
    known = [(0.0, np.zeros_like(end)), (0.0, row), (length, end), (length, slope)]

    def missed(share: float) -> tuple[float, tuple[float, Vector]]:
        """Return by how much a point at a share of the step is foreseen wrongly, and this point as found."""
        foreseen = KroghInterpolator([x for x, _ in known], [y for _, y in known])  # a place again: its derivative
        *z, factor = foreseen(share * length)
        try:
            q = scene.moved(a.q, np.array(z) / scene.weights)
        except KanefeError as error:
            raise PathLost(str(error)) from error
        found = found_beside(scene, a if share <= MIDDLE else b, q, a.factor + scene.span * factor, b.step)
        there = place(found.q, found.factor)
        along = float(row @ there)
        return float(np.abs(there - foreseen(along)).max()), (along, there)

    middle, point = missed(MIDDLE)
    if middle <= SETTLED:
        return
    known.insert(2, point)
    if max(missed(share)[0] for share in QUARTERS) > max(FORESEEN * middle, SETTLED):
        raise PathLost("another path, or a sharp bend, is so near that a step may leave the path")
