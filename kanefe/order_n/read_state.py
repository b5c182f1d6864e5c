"""What functions of the user read of a state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.tree.scene_state import SceneState


class ReadState:
    """A state as functions of the user see it, which notes the entries of y that they read.

    Joint and modal coordinates and speeds are noted one by one; what asks for anything else may depend on all of y.

    Parameters
    ----------
    state : SceneState
    """

    def __init__(self, state: SceneState) -> None:
        self._state, self._is_all = state, False
        self._entries: set[int] = set()

    @property
    def time(self) -> float:
        """Time, s."""
        return self._state.time

    def joint_coordinates(self, name: str) -> Vector:
        """Return those of a body's joint: see `SceneState`."""
        model = self._state.model
        self._entries.update(at for at in model.bodies[model.index(name)].coordinates.tolist() if at >= 0)
        return self._state.joint_coordinates(name)

    def joint_speeds(self, name: str) -> Vector:
        """Return those of a body's joint: see `SceneState`."""
        model = self._state.model
        self._note_speeds(model.bodies[model.index(name)].speeds.tolist())
        return self._state.joint_speeds(name)

    def modal_coordinates(self, name: str) -> Vector:
        """Return those of a flexible body: see `SceneState`."""
        found = self._state.modal_coordinates(name)
        model = self._state.model
        self._entries.update(range(model.coordinate_count)[model.flexible_terms(name).eta])
        return found

    def modal_speeds(self, name: str) -> Vector:
        """Return those of a flexible body: see `SceneState`."""
        found = self._state.modal_speeds(name)
        model = self._state.model
        self._note_speeds(range(model.free_count)[model.flexible_terms(name).speeds])
        return found

    def __getattr__(self, name: str) -> Any:
        """Return anything else of the state, and note that all may be read."""
        self._is_all = True
        return getattr(self._state, name)

    def _note_speeds(self, speeds: Sequence[int]) -> None:
        model = self._state.model
        self._entries.update(model.coordinate_count + at for at in speeds if at < model.free_count)

    def moved_by(self, directions: Matrix) -> np.ndarray:
        """Return the numbers of the directions, rows of a matrix (k, y), that move something that was read."""
        if self._is_all:
            return np.arange(len(directions))
        return np.flatnonzero(directions[:, sorted(self._entries)].any(axis=1))
