"""Tables of loop joints and couplers for the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.kernels.constraints.closing import Closing
from kanefe.kernels.constraints.constraint_rows import ConstraintRow, ConstraintRows, RowKind, Term, Terms
from kanefe.kernels.constraints.loop_tables import Limits, LoopFactors, RowWork, UnitResponses, no_loops
from kanefe.kernels.constraints.tolerances import CLOSING
from kanefe.kernels.contact.rigid_points import given_points
from kanefe.kernels.scene import FlexibleSizes, Sizes
from kanefe.kernels.tables import FlexibleTables, Loops, RigidPoints, Tables
from kanefe.kernels.values.filled import filled, room
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.row_path_tables import row_paths
from kanefe.tree.model_data import ModelData
from kanefe.tree.rigid_points import put_marker, rigid_points
from kanefe.tree.scales import displacement_scales, joint_scales, scene_length

if TYPE_CHECKING:
    from kanefe.constraints.rows import Constraint, Row


def loop_tables(builder: FrameOffsets, tables: Tables, flexible: FlexibleTables) -> Loops:
    """Return the tables of the rows of all constraints."""
    model = builder.model
    if not model.is_constrained:
        return no_loops()
    from kanefe.tree.row_rates import RANK_TOLERANCE

    given, points = [(c, row) for c in model.constraints for row in c.rows], rigid_points(model, builder.marker_numbers)
    m, length = len(given) + 3 * len(points.places), scene_length(model)
    rows = np.zeros((m, ConstraintRow.integer_count), dtype=np.int64)
    numbers = np.zeros((m, ConstraintRow.number_count))
    records = ConstraintRows(rows, numbers)
    terms, coefficients = _fill(records, given, builder)
    _fill_points(records, len(given), points)
    paths, visit_numbers = row_paths(records, Terms(terms, coefficients), tables, flexible)
    return Loops(
        rows=rows,
        numbers=numbers,
        terms=terms,
        coefficients=coefficients,
        extents=displacement_scales(model),
        moves=CLOSING.largest_step * joint_scales(model, length),
        limits=filled(Limits, rank_tolerance=RANK_TOLERANCE, length=length),
        points=points,
        paths=paths,
        sizes=_sizes(
            tables, flexible, m=m, points=len(points.places), entries=int(paths.ends[-1]), visit_numbers=visit_numbers
        ),
    )


def _fill(
    rows: ConstraintRows, given: list[tuple[Constraint, Row]], builder: FrameOffsets
) -> tuple[np.ndarray, np.ndarray]:
    """Write the rows of all constraints; return the tables of the terms of couplers."""
    from kanefe.constraints.rows import RADIAN, CouplerRow

    model = builder.model
    coupled = [term for _, row in given if isinstance(row, CouplerRow) for term in row.terms]
    terms = np.zeros((len(coupled), Term.integer_count), dtype=np.int64), np.zeros((len(coupled), Term.number_count))
    for (body, coordinate, coefficient), term in zip(coupled, Terms(*terms), strict=True):
        term.speed, term.coordinate = int(model.bodies[body].speeds[coordinate]), _coordinate(model, body, coordinate)
        term.coefficient = coefficient
    before, first = None, 0
    for (constraint, own), row in zip(given, rows, strict=False):
        own.fill(row)
        row.holds_place, row.is_angle, row.switch = own.holds_place, own.unit == RADIAN, constraint.switch
        if isinstance(own, CouplerRow):
            row.a.row = row.b.row = -1
            row.first_term, row.term_count = first, len(own.terms)
            first += row.term_count
            continue
        between = constraint, own.a, own.b
        row.goes_on, before = between == before, between
        put_marker(row.a, *builder.marker_numbers(own.a))
        put_marker(row.b, *builder.marker_numbers(own.b))
    return terms


def _fill_points(rows: ConstraintRows, first: int, points: RigidPoints) -> None:
    """Write the rows of the points of rigid contacts, three for each from a first one on."""
    for n in range(3 * len(points.places)):
        row, (p, direction) = rows[first + n], divmod(n, 3)
        given = given_points(points)[p]
        row.kind, row.point, row.direction, row.switch = RowKind.CONTACT, p, direction, given.status
        row.holds_place = direction == 0 or given.has_mark
        for end, marker in ((row.a, given.surface), (row.b, given.probe)):
            end.row, end.point, end.axes = marker.row, marker.point, marker.axes


def _sizes(tables: Tables, flexible: FlexibleTables, **whole: int) -> np.ndarray:
    """Return the integers of the memory of loops."""
    sizes, of_modes = Sizes(tables.sizes), FlexibleSizes(flexible.sizes)
    whole |= {"free": sizes.free_count, "speeds": sizes.free_count + sizes.driven_count}
    whole |= {"coordinates": sizes.coordinate_count, "frames": len(tables.rows) + 1, "begins": 0}
    whole |= {"modal": of_modes.modal, "border": of_modes.border}
    whole["exerted"] = room(RowWork, "begins", **whole)
    whole["held"] = room(UnitResponses if whole["points"] else LoopFactors, "begins", **whole)
    whole["closing"] = room(Closing, "begins", **whole)
    return np.array([whole[name] for name, field in RowWork.fields.items() if field.is_whole], dtype=np.int64)


def _coordinate(model: ModelData, body: int, coordinate: int) -> int:
    """Return where a coordinate of a joint is in q; -1 - drive if it is driven."""
    at, speed = int(model.bodies[body].coordinates[coordinate]), int(model.bodies[body].speeds[coordinate])
    return at if at >= 0 else model.free_count - 1 - speed
