"""One evaluation of several planar scenes at once: see `kanefe.kernels.evaluation.rigid_lanes`."""

from typing import NamedTuple

import numpy as np

from kanefe.kernels.compiler.arrays import RealBlocks, RealRows
from kanefe.kernels.language import entry, lanes_of
from kanefe.kernels.planar.evaluation import accelerate_in_plane, apply_forces
from kanefe.kernels.planar.layout import PlanarTables, PlanarWork
from kanefe.kernels.scene import rates_in, state_in
from kanefe.kernels.steppers.step_commands import VECTOR


class PlanarLanes(NamedTuple):
    """Planar scenes that are alike; the last axis of arrays is that of the lanes.

    Attributes
    ----------
    tables : PlanarTables
        Of one of them, for its whole numbers.
    geometry, gravity, points, laws : ndarray, shape (..., lanes)
    """

    tables: PlanarTables
    geometry: RealBlocks
    gravity: RealRows
    points: RealBlocks
    laws: RealBlocks


class LanesInPlane(NamedTuple):
    """The same in the place of `PlanarTables`, its numbers as lanes."""

    rows: np.ndarray
    geometry: np.ndarray
    gravity: np.ndarray
    loads: np.ndarray
    points: np.ndarray
    joint_forces: np.ndarray
    laws: np.ndarray
    sizes: np.ndarray


@entry()
def evaluate_planar_lanes(
    scene: PlanarLanes, drives: RealBlocks, inputs: RealRows, vectors: RealBlocks, memory: RealRows
) -> bool:
    """Evaluate dy/dt of each lane; return whether every joint of all has inertia along it.

    Arguments are as those of `kanefe.kernels.evaluation.rigid_lanes.evaluate_lanes`.
    """
    given, of_lanes = scene.tables, lanes_of(vectors)
    tables = LanesInPlane(
        given.rows,
        lanes_of(scene.geometry),
        lanes_of(scene.gravity),
        given.loads,
        lanes_of(scene.points),
        given.joint_forces,
        lanes_of(scene.laws),
        given.sizes,
    )
    state = state_in(tables, 0.0, of_lanes[VECTOR.at], lanes_of(drives), lanes_of(inputs))
    rates, own = rates_in(tables, of_lanes[VECTOR.slope]), PlanarWork(given.work, lanes_of(memory))
    apply_forces(tables, state, own, rates)
    return accelerate_in_plane(tables, state, own, rates, False)
