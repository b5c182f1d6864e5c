"""Whether the loads between frames of a scene stiffen the sweeps in few directions: decided when it is frozen."""

from __future__ import annotations

from kanefe.bodies.marker import CoordinateMarker
from kanefe.loads.base import Load
from kanefe.order_n.tables.arm_tables import swept_arms
from kanefe.order_n.tables.drive_tables import drive_tables
from kanefe.order_n.tables.inputs import InputLayout
from kanefe.order_n.tables.load_points import body_of_points
from kanefe.tree.model_data import ModelData


def directions_of_loads(model: ModelData) -> int:
    """Return the largest number of directions, or 0 where a matrix over all unknowns is less work, or the only way.

    A direction takes a sweep of forces, an unknown of the matrix a column by an evaluation, and the systems to be
    factorised have one or the other number of unknowns: with fewer directions than unknowns all is less. The only way
    it is for loads that are Python functions or follow the reaction of a joint, points of flexible bodies, and loops.
    Arms that are part of the sweeps are not counted.
    """
    is_compiled = not InputLayout(model).calls_python and drive_tables(model) is not None
    loads = [load for number, load in enumerate(model.loads) if number not in swept_arms(model)]
    if not is_compiled or model.is_constrained or model.bearings or not all(map(_has_tangents, loads)):
        return 0
    directions = sum(map(_directions_of, loads))
    return directions if directions < model.free_count + model.state_count else 0


def _has_tangents(load: Load) -> bool:
    """Return whether a load has a function of complex numbers, and no points of a flexible body."""
    kernel = load.kernel
    return kernel is not None and kernel.complex_ is not None and body_of_points(load, load.reach) < 0


def _directions_of(load: Load) -> int:
    """Return in how many directions the ends of a load move relative to the first of them, or a single one at all."""
    along = sum(isinstance(marker, CoordinateMarker) for marker in load.ends)
    return along + 6 * max(len(load.ends) - along - 1, 0 if along else 1)
