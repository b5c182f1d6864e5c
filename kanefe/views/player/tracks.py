"""Positions and rotations of the frames of a run at the times shown."""

from __future__ import annotations

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import rotation_matrix
from kanefe.results.reader import Reader

GROUND = -1
"""Number of the fixed frame."""


class Tracks:
    """The motion of frames, each read on first use.

    Parameters
    ----------
    result : Reader
    frames : ndarray of int, shape (S,)
        The output times shown, by number.

    Attributes
    ----------
    poses : list of (ndarray (S, 3), ndarray (S, 4))
        Position (m) and Euler parameters of each frame, from N.
    """

    def __init__(self, result: Reader, frames: np.ndarray) -> None:
        self.result, self.frames = result, frames
        self.poses: list[tuple[np.ndarray, np.ndarray]] = []
        self._numbers: dict[tuple[str, str], int] = {}

    def number(self, body: str, interface: str = "") -> int:
        """Return the number of a frame; body "" is the ground.

        Raises
        ------
        ModelError
            If its position or rotation is not finite at some time.
        """
        if not body:
            return GROUND
        key = (body, interface)
        if key not in self._numbers:
            place = self.result.position(body, interface or None)[self.frames]
            turn = self.result.rotation(body, interface or None)[self.frames]
            bad = ~(np.isfinite(place).all(axis=1) & np.isfinite(turn).all(axis=1))
            if bad.any():
                t = self.result.times[self.frames][bad][0]
                raise ModelError(
                    f"the position of body {body!r} is not finite at t = {t:.6g} s, so that it cannot be shown. "
                    "Remedy: print(result.status)"
                )
            self._numbers[key] = len(self.poses)
            self.poses.append((place, turn))
        return self._numbers[key]

    def placed(self, frame: int, points: np.ndarray, row: int = 0) -> np.ndarray:
        """Return points (p, 3) of a frame in N, at one of the times shown."""
        if frame == GROUND:
            return points
        place, turn = self.poses[frame]
        return np.asarray(place[row] + points @ rotation_matrix(turn[row]).T)

    def tracked(self, frame: int, point: np.ndarray) -> np.ndarray:
        """Return a point (3,) of a frame in N at all times shown, (S, 3)."""
        if frame == GROUND:
            return np.tile(point, (len(self.frames), 1))
        place, turn = self.poses[frame]
        if not point.any():
            return place
        return place + np.array([rotation_matrix(e) @ point for e in turn])


def up_axis(result: Reader) -> list[float]:
    """Return the axis that points up, (3,): opposite to gravity if that is along an axis, else z."""
    gravity = np.zeros(3) if result.run is None else np.asarray(result.run.model.gravity)
    axis = int(np.argmax(np.abs(gravity)))
    if abs(gravity[axis]) > 0.99 * np.linalg.norm(gravity) > 0.0:
        return [float(x) for x in -np.sign(gravity[axis]) * np.eye(3)[axis]]
    return [0.0, 0.0, 1.0]
