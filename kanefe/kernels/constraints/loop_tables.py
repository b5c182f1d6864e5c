"""Rows of loop joints, couplers and contact points: their tables, and the memory of what is found of them."""

from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.algebra.envelope import Envelope
from kanefe.kernels.constraints.constraint_rows import (
    Action,
    Actions,
    ConstraintRow,
    ConstraintRows,
    RowKind,
    Term,
    Terms,
)
from kanefe.kernels.constraints.row_paths import no_paths
from kanefe.kernels.constraints.tolerances import HALF_ON
from kanefe.kernels.contact.rigid_points import SLIPPING, Meeting, Meetings, given_points, is_rubbing, no_rigid_points
from kanefe.kernels.joints.handing import Carried, CarriedRows
from kanefe.kernels.language import Array, One, Record, Start, Table, inlined
from kanefe.kernels.tables import Loops

LEAST_SHARE = 1e-29
"""Square of the fraction of its reach, below which a row moves nothing: below the square of round-off, 1e-31, for all
rows."""


class RowWork(Record, is_frozen=True):
    """What rows exert at one configuration; its integers, `Loops.sizes`, are those of all memory of loops.

    Attributes
    ----------
    m, points : int
        Rows of constraints, points of rigid contacts.
    free, speeds, coordinates : int
        Free speeds, free and driven ones, and coordinates.
    frames : int
        Rows of the scene, and the ground.
    modal, border : int
        Numbers of the modal and of the border work.
    entries, visit_numbers : int
        Of the envelope, and of all visits.
    exerted, held, closing : int
        How many numbers there are of what rows exert, of what holds them in an evaluation, and of what closes loops.
    begins : int
        Where it begins in its memory.
    actions : Actions
    met : Meetings
        Of the points of rigid contacts.
    """

    m: int
    points: int
    free: int
    speeds: int
    coordinates: int
    frames: int
    modal: int
    border: int
    entries: int
    visit_numbers: int
    exerted: int
    held: int
    closing: int
    begins: Annotated[int, Start("memory")]
    actions: Annotated[Actions, Table(Actions, "m", Action.number_count)]
    met: Annotated[Meetings, Table(Meetings, "points", Meeting.number_count)]


class LoopFactors(RowWork):
    """How loops hold the tree at one configuration, without rubbing contacts.

    Attributes
    ----------
    visited : ndarray, shape (visit_numbers,)
        See `kanefe.kernels.constraints.row_paths.Visit`.
    A, L, inverses, whole, taken, column : ndarray
        Of the system ``J M^-1 J^T``, see `kanefe.kernels.algebra.envelope.Envelope`.
    scale : ndarray, shape (m,)
        A scaled row is of unit length if its wrench points along all motions on its way; 0: it moves nothing, or does
        not hold.
    rest, right : ndarray, shapes (m,), (m, 1)
        Acceleration that each row needs; workspace.
    felt, asked : ndarray, shape (m, 6)
        What the row of the scene that carries the loops feels of a unit multiplier, and the multipliers that its unit
        accelerations ask for.
    carried : CarriedRows
        Wrenches on their way.
    """

    visited: Annotated[np.ndarray, Array("visit_numbers")]
    A: Annotated[np.ndarray, Array("entries")]
    L: Annotated[np.ndarray, Array("entries")]
    scale: Annotated[np.ndarray, Array("m")]
    inverses: Annotated[np.ndarray, Array("m")]
    whole: Annotated[np.ndarray, Array("m")]
    taken: Annotated[np.ndarray, Array("m")]
    column: Annotated[np.ndarray, Array("m")]
    rest: Annotated[np.ndarray, Array("m")]
    right: Annotated[np.ndarray, Array("m", 1)]
    felt: Annotated[np.ndarray, Array("m", 6)]
    asked: Annotated[np.ndarray, Array("m", 6)]
    carried: Annotated[CarriedRows, Table(CarriedRows, "frames", Carried.number_count)]


class UnitResponses(RowWork):
    """What the constraints do to the speeds at one configuration, row by row, where there are rigid contacts.

    Attributes
    ----------
    unit_responses : ndarray, shape (m, speeds)
        Accelerations that they cause, and driving forces.
    A : ndarray, shape (m, m)
        Lower triangle of ``J M^-1 J^T``; where contacts rub, all of ``J M^-1 P^T``.
    L, inverses, order : ndarray, shapes (m, m), (m,), (m,)
        Its factors, see `kanefe.kernels.algebra.pivoted` and `kanefe.kernels.algebra.least_norm`.
    scale : ndarray, shape (m,)
        With which a row is of unit length if it points along the motion of its ends; 0: it moves nothing, or does not
        hold.
    rest, column : ndarray, shape (m,)
    J : ndarray, shape (m, speeds)
        The rows themselves.
    reach : ndarray, shape (speeds,)
        Workspace.
    plain : ndarray, shape (m,)
        Of rows of contacts: what the normal force alone would do along the row.
    live, spare : ndarray, shape (m,)
        Rows that hold where points touch; workspace.
    search : ndarray, shape (3, m)
        Workspace.
    live_count, rank : float
        Of the rows that `share_forces` had in the last evaluation: how many hold (-1: it had none), and their rank.
    """

    unit_responses: Annotated[np.ndarray, Array("m", "speeds")]
    A: Annotated[np.ndarray, Array("m", "m")]
    L: Annotated[np.ndarray, Array("m", "m")]
    inverses: Annotated[np.ndarray, Array("m")]
    order: Annotated[np.ndarray, Array("m")]
    scale: Annotated[np.ndarray, Array("m")]
    rest: Annotated[np.ndarray, Array("m")]
    column: Annotated[np.ndarray, Array("m")]
    J: Annotated[np.ndarray, Array("m", "speeds")]
    reach: Annotated[np.ndarray, Array("speeds")]
    plain: Annotated[np.ndarray, Array("m")]
    live: Annotated[np.ndarray, Array("m")]
    spare: Annotated[np.ndarray, Array("m")]
    search: Annotated[np.ndarray, Array(3, "m")]
    live_count: Annotated[float, One(float)]
    rank: Annotated[float, One(float)]


class Limits(Record):
    """Limits of a scene.

    Attributes
    ----------
    rank_tolerance : float
        Pivot, of a row of unit length, below which it depends on others.
    length : float
        A length of the scene, m.
    """

    rank_tolerance: float
    length: float


def no_loops() -> Loops:
    """Return the tables of a scene without constraints."""
    none, sizes = np.zeros(0), np.zeros(RowWork.integer_count, dtype=np.int64)
    rows, terms = (np.zeros((0, record.integer_count), dtype=np.int64) for record in (ConstraintRow, Term))
    numbers, coefficients = (np.zeros((0, record.number_count)) for record in (ConstraintRow, Term))
    return Loops(rows, numbers, terms, coefficients, none, none, none, no_rigid_points(), no_paths(), sizes)


class Held(NamedTuple):
    """What sweeps hold of the loops.

    Attributes
    ----------
    kept : LoopFactors
        With what rows exert, and the acceleration that each needs.
    z : ndarray, shape (states,)
        Internal states, of which the switches say which rows hold.
    places_only : bool
        Whether rows that hold speeds alone are left out.
    tolerance : float
        Pivot, of a row of unit length, below which it depends on others; that of the scene at least.
    """

    kept: LoopFactors
    z: np.ndarray
    places_only: bool
    tolerance: float


@inlined
def rows_of(loops: Loops) -> ConstraintRows:
    """Return the rows of all constraints."""
    return ConstraintRows(loops.rows, loops.numbers)


@inlined
def terms_of(loops: Loops) -> Terms:
    """Return the coordinates of all couplers."""
    return Terms(loops.terms, loops.coefficients)


def hold_size(loops: Loops) -> int:
    """Return how many numbers what holds the rows in an evaluation has.

    `LoopFactors`, or `UnitResponses` where there are rigid contacts.
    """
    return RowWork(loops.sizes, loops.extents).held


def exerted_size(loops: Loops) -> int:
    """Return how many numbers what rows exert has."""
    return RowWork(loops.sizes, loops.extents).exerted


@inlined
def factors_in(memory: np.ndarray, loops: Loops) -> LoopFactors:
    """Return the memory of the sweeps with loops."""
    return LoopFactors(loops.sizes, memory)


@inlined
def unit_responses_in(memory: np.ndarray, loops: Loops) -> UnitResponses:
    """Return the memory of `hold`."""
    return UnitResponses(loops.sizes, memory)


@inlined
def row_work_in(memory: np.ndarray, loops: Loops) -> RowWork:
    """Return the memory of what rows exert, with which both of these begin."""
    return RowWork(loops.sizes, memory)


@inlined
def system_of(loops: Loops, kept: LoopFactors) -> Envelope:
    """Return the system of the multipliers."""
    paths = loops.paths
    return Envelope(
        paths.ends, paths.blocks, paths.order, paths.place, kept.A, kept.L, kept.scale, kept.inverses, kept.whole,
        kept.taken, kept.column,
    )  # fmt: skip


@inlined
def holds(row: ConstraintRow, z: np.ndarray) -> bool:
    """Return whether a row holds with internal states z."""
    is_on = row.switch < 0
    if not is_on:
        state = z[row.switch].real
        is_slip = row.kind == RowKind.CONTACT and row.direction > 0 and state > SLIPPING.slips_from
        is_on = state > HALF_ON and not is_slip
    return is_on


@inlined
def is_normal(row: ConstraintRow) -> bool:
    """Return whether a row is along the normal of a point of a rigid contact."""
    return row.kind == RowKind.CONTACT and row.direction == 0


@inlined
def head_of(loops: Loops, p: int) -> int:
    """Return the number of the normal row of a point of a rigid contact: two along the surface follow."""
    return len(loops.rows) - 3 * (len(loops.points.places) - p)


@inlined
def has_loops(loops: Loops, kept: UnitResponses) -> bool:
    """Return whether rows of constraints hold, and not those of contacts alone."""
    rows, found = rows_of(loops), False
    for j in range(len(rows)):
        found = found or (kept.scale[j] != 0.0 and rows[j].kind != RowKind.CONTACT)
    return found


@inlined
def rubs_at(loops: Loops, row: ConstraintRow, z: np.ndarray) -> bool:
    """Return whether a row is the normal row of a point that slips with friction."""
    return is_normal(row) and is_rubbing(given_points(loops.points)[row.point], z)
