"""The states of a run with the motion of frames from compiled sweeps, without partial velocities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kanefe.integrate.trajectory import Trajectory
from kanefe.tree.model_data import ModelData
from kanefe.tree.placed import Placed
from kanefe.tree.run_sweeps import RunSweeps
from kanefe.tree.scene_state import SceneState


def placed_states(
    model: ModelData, run: Trajectory, swept: RunSweeps, rows: Sequence[int] | np.ndarray
) -> Iterator[SceneState]:
    """Yield the states at some output times, given by number."""
    frames = [swept.frame(number, None) for number in range(len(model.bodies))]
    for row in rows:
        placed = []
        for frame in frames:
            A = frame.axes[row]
            placed.append(Placed(A, frame.position[row], frame.velocity[row] @ A, frame.angular_velocity[row] @ A))
        yield SceneState(model, float(run.times[row]), run.coordinates[row], run.speeds[row], run.internal[row], placed)
