"""Tables of loop joints and couplers for the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.kernels.constraints.constraint_rows import CONTACT_ROW, ROW_NUMBERS
from kanefe.kernels.constraints.loop_tables import CONSTRAINT_INTEGERS, no_loops
from kanefe.kernels.constraints.tolerances import LARGEST_STEP
from kanefe.kernels.contact.rigid_points import HAS_MARK, OF_PROBE, ON_SURFACE, STATUS
from kanefe.kernels.loads.markers import MARKER_NUMBERS
from kanefe.kernels.tables import FlexibleTables, Loops, Tables
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.rigid_point_tables import rigid_points
from kanefe.order_n.tables.row_path_tables import row_paths
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import displacement_scales, joint_scales, scene_length

if TYPE_CHECKING:
    from kanefe.bodies.marker import Marker
    from kanefe.constraints.rows import Constraint, Row


def loop_tables(builder: FrameOffsets, tables: Tables, flexible: FlexibleTables) -> Loops:
    """Return the tables of the rows of all constraints."""
    model = builder.model
    if not model.is_constrained:
        return no_loops()
    from kanefe.constraints.rows import CouplerRow
    from kanefe.kane.constraints import RANK_TOLERANCE

    integers, markers, numbers = [], [], []
    length = scene_length(model)
    speeds: list[int] = []
    coefficients: list[float] = []
    coordinates: list[int] = []
    before: tuple[Constraint, Marker, Marker] | None = None
    for constraint, row in ((c, row) for c in model.constraints for row in c.rows):
        if isinstance(row, CouplerRow):
            integers.append((row.kind, -1, -1, 0, len(speeds), len(row.terms), *_nature(constraint, row), 0))
            speeds += [int(model.bodies[body].speeds[coordinate]) for body, coordinate, _ in row.terms]
            coefficients += [coefficient for _, _, coefficient in row.terms]
            coordinates += [_coordinate(model, body, coordinate) for body, coordinate, _ in row.terms]
            markers += [np.zeros(MARKER_NUMBERS)] * 2
            numbers.append(row.numbers)
            continue
        ends = [builder.marker_numbers(marker) for marker in (row.a, row.b)]
        markers += [place for _, place in ends]
        between = constraint, row.a, row.b
        nature = (*_nature(constraint, row), int(between == before))
        integers.append((row.kind, ends[0][0], ends[1][0], int(row.is_ball), 0, 0, *nature))
        before = between
        numbers.append(row.numbers)
    points = rigid_points(builder)
    for p, place in enumerate(points.places):
        for direction in range(3):
            holds_place = int(direction == 0 or place[HAS_MARK])
            a, b, status = int(place[ON_SURFACE]), int(place[OF_PROBE]), int(place[STATUS])
            integers.append((CONTACT_ROW, a, b, direction, p, 0, holds_place, 0, status, 0))
            markers += [points.markers[2 * p], points.markers[2 * p + 1]]
            numbers.append(np.zeros(ROW_NUMBERS))
    rows = np.array(integers, dtype=np.int64).reshape(-1, CONSTRAINT_INTEGERS)
    return Loops(
        rows=rows,
        markers=np.array(markers).reshape(-1, MARKER_NUMBERS),
        numbers=np.array(numbers).reshape(-1, ROW_NUMBERS),
        speeds=np.array(speeds, dtype=np.int64),
        coefficients=np.array(coefficients, dtype=float),
        coordinates=np.array(coordinates, dtype=np.int64),
        extents=displacement_scales(model),
        moves=LARGEST_STEP * joint_scales(model, length),
        limits=np.array([RANK_TOLERANCE, length]),
        points=points,
        paths=row_paths(rows, speeds, tables, flexible),
    )


def _nature(constraint: Constraint, row: Row) -> tuple[int, int, int]:
    """Return whether a row holds coordinates, whether its residual is an angle, and its switch."""
    from kanefe.constraints.rows import RADIAN

    return int(row.holds_place), int(row.unit == RADIAN), constraint.switch


def _coordinate(model: ModelData, body: int, coordinate: int) -> int:
    """Return where a coordinate of a joint is in q; -1 - drive if it is driven."""
    at, speed = int(model.bodies[body].coordinates[coordinate]), int(model.bodies[body].speeds[coordinate])
    return at if at >= 0 else model.free_count - 1 - speed
