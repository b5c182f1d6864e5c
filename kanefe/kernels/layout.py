"""Where everything is in the arrays of a frozen scene: the names of columns, and the tables the kernels read.

Rows are those of `kanefe.kernels.tree`, whose records follow the same columns.
"""

from __future__ import annotations

from collections.abc import Iterator

from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import BorderedBody
from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.tables import Tables
from kanefe.kernels.tree import FRAME_NUMBERS, AxisFrame, Frame, GivenLink, InterfaceFrame, InterfaceLink, Kind, Link
from kanefe.kernels.values.records import Record, column

# Kinds of rows
FIXED, REVOLUTE, AXIS, GIVEN, SPHERICAL, FREE, INTERFACE = map(int, Kind)
# between FIXED and GIVEN: of one coordinate


def _columns(record: type[Record], names: str) -> Iterator[int]:
    return (column(record, name) for name in names.split())


# Columns of `Tables.rows`, integers of a row, and of `Tables.geometry`, its numbers: those of `Link`
PARENT, KIND, COORDINATE, SPEED, DRIVE, FLEXIBLE = _columns(Link, "parent kind coordinate speed drive flexible")
HAS_GRAVITY, CARRIES = _columns(Link, "has_gravity carries")
BASIS, BENDING, BENT = _columns(InterfaceLink, "basis bending bent")
FUNCTION, COMPLEX_FUNCTION, FIRST_NUMBER = _columns(GivenLink, "function complex_function first_number")
PLACE, AXES, MASS, FIRST, SECOND = _columns(Link, "place axes mass first second")
ROTOR, ALONG, ABOUT = _columns(Link, "rotor along about")
ROW_NUMBERS = Link.number_count

# Columns of the work array: those of `Frame`
R, OFFSET, POSITION, VELOCITY, OMEGA, Z, Y = _columns(Frame, "R r p v w Z Y")
M, H, J, FORCE, MOMENT, ACCELERATION, ALPHA = _columns(Frame, "M H J f n a alpha")
PIVOT, DRIVING = _columns(AxisFrame, "pivot rest")
(TANGENT,) = _columns(InterfaceFrame, "tangent")
WORK = FRAME_NUMBERS

# Columns of `FlexibleTables.bodies`, integers of a flexible body: those of `BorderedBody`
COUNT, ETA, DETA, ROW, POOL, MODAL = _columns(BorderedBody, "k first_eta first_deta link constants work")
TRANSFORM, DAMPING, CARRIED, CARRIED_COUNT = _columns(BorderedBody, "transform damped carried carried_count")
BORDER, QUADRATIC, QUADRATIC_WORK = _columns(BorderedBody, "border bends_twice bending")
BODY_INTEGERS = ExactBeam.integer_count

# Constants of a flexible body, from POOL on
POOL_STIFFNESS = 10  # diagonal, k

# Modal work of a flexible body, in units of k from MODAL on
WORK_ETA = 0
WORK_DETA = 1
WORK_PRODUCTS = 2  # 6 symmetric and 3 antisymmetric products with eta
WORK_COUPLING = 14  # 6 x k: inertia between the motion of G and the modes, in G
WORK_FORCE = 20
WORK_SCALE = 22  # of a linearly implicit sweep: what the modes are scaled by


@inlined
def work_size(tables: Tables) -> int:
    """Return how many numbers the work array has: a row for each of the scene, and a last one for the ground."""
    return WORK * (len(tables.rows) + 1)


COORDINATES, SPEEDS, DRIVES, STATES = range(4)
MODAL_SIZE, BORDER_SIZE, SLOPES = range(3)
ROTATION_VECTOR, TAIT_BRYAN = range(2)
