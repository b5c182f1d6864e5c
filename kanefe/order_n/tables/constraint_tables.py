"""Tables of loop joints and couplers for the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.kernels.constraints.constraint_rows import (
    COUPLER_ROW,
    DIRECTION_ROW,
    DISTANCE_ROW,
    POINT_ROW,
    ROLLING_ROW,
    SCREW_ROW,
)
from kanefe.kernels.constraints.multipliers import CONSTRAINT_INTEGERS, Loops, no_loops
from kanefe.kernels.constraints.tolerances import LARGEST_STEP
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import displacement_scales, joint_scales, scene_length

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint, MarkerRow, Row


def loop_tables(builder: FrameOffsets) -> Loops:
    """Return the tables of the rows of all constraints."""
    model = builder.model
    if not model.constraints:
        return no_loops()
    from kanefe.constraints.rows import CouplerRow, RollingRow
    from kanefe.kane.constraints import RANK_TOLERANCE

    integers, markers, numbers = [], [], []
    length = scene_length(model)
    speeds: list[int] = []
    coefficients: list[float] = []
    coordinates: list[int] = []
    for constraint, row in ((c, row) for c in model.constraints for row in c.rows):
        if isinstance(row, CouplerRow):
            integers.append((COUPLER_ROW, -1, -1, 0, len(speeds), len(row.terms), *_nature(constraint, row)))
            speeds += [int(model.bodies[body].speeds[coordinate]) for body, coordinate, _ in row.terms]
            coefficients += [coefficient for _, _, coefficient in row.terms]
            coordinates += [_coordinate(model, body, coordinate) for body, coordinate, _ in row.terms]
            markers += [np.zeros(MARKER_NUMBERS)] * 2
            numbers.append(np.array([*np.zeros(6), row.constant]))
            continue
        ends = [builder.marker_numbers(marker) for marker in (row.a, row.b)]
        markers += [place for _, place in ends]
        kind, values = _row_numbers(row)
        is_ball = isinstance(row, RollingRow) and row.is_ball
        integers.append((kind, ends[0][0], ends[1][0], int(is_ball), 0, 0, *_nature(constraint, row)))
        numbers.append(values)
    return Loops(
        rows=np.array(integers, dtype=np.int64).reshape(-1, CONSTRAINT_INTEGERS),
        markers=np.array(markers).reshape(-1, MARKER_NUMBERS),
        numbers=np.array(numbers).reshape(-1, 7),
        speeds=np.array(speeds, dtype=np.int64),
        coefficients=np.array(coefficients, dtype=float),
        coordinates=np.array(coordinates, dtype=np.int64),
        extents=displacement_scales(model),
        moves=LARGEST_STEP * joint_scales(model, length),
        limits=np.array([RANK_TOLERANCE, length]),
    )


def _nature(constraint: Constraint, row: Row) -> tuple[int, int, int]:
    """Return whether a row holds coordinates, whether its residual is an angle, and its switch."""
    from kanefe.constraints.rows import RADIAN

    return int(row.holds_place), int(row.unit == RADIAN), constraint.switch


def _coordinate(model: ModelData, body: int, coordinate: int) -> int:
    """Return where a coordinate of a joint is in q; -1 - drive if it is driven."""
    at, speed = int(model.bodies[body].coordinates[coordinate]), int(model.bodies[body].speeds[coordinate])
    return at if at >= 0 else model.free_count - 1 - speed


def _row_numbers(row: MarkerRow) -> tuple[int, np.ndarray]:
    """Return the kind of a row and its numbers: e, f or a screw's side, and a length, lead, radius or cosine."""
    from kanefe.constraints.rows import DIRECTIONS, DirectionRow, DistanceRow, PointRow, ScrewRow

    none = np.zeros(3)
    if isinstance(row, PointRow):
        return POINT_ROW, np.array([*row.e, *none, 0.0])
    if isinstance(row, DirectionRow):
        return DIRECTION_ROW, np.array([*row.e, *row.f, row.cosine])
    if isinstance(row, DistanceRow):
        return DISTANCE_ROW, np.array([*none, *none, row.length])
    if isinstance(row, ScrewRow):
        return SCREW_ROW, np.array([*row.e, *row.side, row.lead])
    return ROLLING_ROW, np.array([*np.eye(3)[DIRECTIONS[row.direction]], *none, row.radius])
