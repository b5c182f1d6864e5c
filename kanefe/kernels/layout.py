"""Where everything is in the arrays of a frozen scene: the names of columns, and the tables the kernels read.

A scene is a list of *rows*, parents before children. A row is the moving frame of a link (a body behind its joint;
joints of several coordinates are chains of links) or an interface of a flexible body. Work arrays have a row for each
of them. Every quantity of a row is in components of N and referred to the row's own origin: inertias then travel from
child to parent by a shift alone, without a rotation.
"""

from __future__ import annotations

from typing import NamedTuple

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals

# Kinds of rows
FIXED, REVOLUTE, AXIS, GIVEN, SPHERICAL, FREE, INTERFACE = range(7)
# between FIXED and GIVEN: of one coordinate

# Columns of `Tables.rows`: integers of a row; -1: none
PARENT, KIND, COORDINATE, SPEED, DRIVE, FLEXIBLE, HAS_GRAVITY, BASIS, CARRIES, BENDING, BENT = range(11)
ROW_INTEGERS = 11
# of an interface with a second-order motion: BENDING is its place in the pool, (k, 6 k), and BENT that of its current
# basis (6, k) in the modal work, followed by as many numbers of workspace; of a section of a beam that bends far: BASIS
# is the number of the section, and BENT as before
FUNCTION, COMPLEX_FUNCTION, FIRST_NUMBER = BASIS, BENDING, BENT
# of a given link in place of them: addresses of its function for real and for complex numbers, and the first of its
# constants in `Tables.numbers`

# Columns of `Tables.geometry`: numbers of a row that do not change
PLACE = 0  # origin from the parent row's origin, in its axes; of an interface: undeformed, in G
AXES = 3  # from the axes of the joint's fixed frame to those of the parent row
MASS = 12
FIRST = 13  # mass times centre of mass
SECOND = 16  # inertia about the origin, symmetric
ROTOR = 22  # angular momentum of rotors
ALONG = 25  # travel of a unit of the coordinate along z
ABOUT = 26  # turn of a unit of the coordinate about z
ROW_NUMBERS = 27

# Columns of the work array: what changes
R = 0  # axes of the row to N
OFFSET = 9  # from the parent row's origin
POSITION = 12
VELOCITY = 15
OMEGA = 18
Z = 21  # remainder acceleration of the origin, gravity taken off
Y = 24  # remainder angular acceleration
GIVEN_MOTION = 27  # of a given link, until the inertias come: coordinate, and what its function writes
M = 27  # articulated inertia: force = M a + H alpha, moment = H^T a + J alpha
H = 33
J = 42
FORCE = 48  # what must act on the row from its parent, with du = 0
MOMENT = 51
ACCELERATION = 54  # share of du
ALPHA = 57
U = 60  # inertia times the axis of the joint; of a spherical joint: inverse of J
PIVOT = 66
DRIVING = 67  # generalised force at the joint that the acceleration needs
TANGENT = 68  # of an interface: from rates of slopes to the angular velocity, in G
PARTIAL = 68  # of a given link: partial velocity of its origin, and partial angular velocity
WORK = 78

# Columns of `FlexibleTables.bodies`: integers of a flexible body
COUNT = 0  # k
ETA = 1  # first coordinate in q
DETA = 2  # first speed
ROW = 3  # its link
POOL = 4  # its constants in `FlexibleTables.pool`
MODAL = 5  # its place in the modal work array
TRANSFORM = 6  # modes of unit mass and diagonal K from the user's coordinates, in the pool; -1: they are the same
DAMPING = 7  # full matrix in the pool; -1: none
CARRIED = 8  # first of its interfaces that carry something, in `FlexibleTables.carrying`
CARRIED_COUNT = 9
BORDER = 10  # its place in the border work array
QUADRATIC = 11  # moments of the second-order displacement, (k, 6 k) in the pool; -1: none
QUADRATIC_WORK = 12  # workspace of 9 k numbers in the modal work
EXACT = 13  # of a beam that bends far: its constants in the pool, see `exact_beam_layout`; -1: it is not one
EXACT_CELLS = 14
EXACT_POINTS = 15  # Gauss points of a cell
EXACT_WORK = 16  # its place in the modal work
EXACT_IN_PLANE = 17  # whether it bends in the x-y plane of G alone
BODY_INTEGERS = 18

# Constants of a flexible body, from POOL on
POOL_MASS = 0
POOL_FIRST = 1
POOL_SECOND = 4
POOL_STIFFNESS = 10  # diagonal, k
# then: translation coupling 3 k, symmetric moments 6 k, rotation coupling 3 k, products k * 9 k

# Modal work of a flexible body, in units of k from MODAL on
WORK_ETA = 0
WORK_DETA = 1
WORK_PRODUCTS = 2  # 6 symmetric and 3 antisymmetric products with eta
WORK_RATES = 11  # 3 antisymmetric products with deta
WORK_COUPLING = 14  # 6 x k: inertia between the motion of G and the modes, in G
WORK_FORCE = 20
WORK_DDETA = 21
WORK_SCALE = 22  # of a linearly implicit sweep: what the modes are scaled by
MODAL_WORK = 23

SECTION = 24  # numbers of the motion of a section of a beam that bends far


class Tables(NamedTuple):
    """A frozen scene as arrays.

    Attributes
    ----------
    rows : ndarray of int, shape (rows, ROW_INTEGERS)
    geometry : ndarray, shape (rows, ROW_NUMBERS)
    gravity : ndarray, shape (3,)
    loads : ndarray of int, shape (loads, 4)
        Row, first of three inputs, is a torque, follows.
    points : ndarray, shape (loads, 12)
        Where the loads act, in axes of their rows, and the axes of following loads to those of their rows.
    joint_forces : ndarray of int, shape (forces, 4)
        Coordinate (-1 - drive if driven), speed, law, input.
    laws : ndarray, shape (forces, 7)
        Stiffness, damping, rest, friction, friction speed, lower, upper, stiffness and damping of the stops.
    sizes : ndarray of int
        Coordinates, free speeds, driven coordinates, internal states of loads.
    numbers : ndarray
        Constants of all given links.
    """

    rows: IntegerRows
    geometry: RealRows
    gravity: Reals
    loads: IntegerRows
    points: RealRows
    joint_forces: IntegerRows
    laws: RealRows
    sizes: Integers
    numbers: Reals


class FlexibleTables(NamedTuple):
    """The flexible bodies of a scene: none where all bodies are rigid.

    Attributes
    ----------
    bodies : ndarray of int, shape (flexible bodies, BODY_INTEGERS)
    pool : ndarray
        Constants of the bodies and bases of interfaces.
    carrying : ndarray of int
        Rows of interfaces that carry something, body by body.
    fields : ndarray of int, shape (distributed loads, 7)
        Body, first input, is a pressure, follows, first constant in `pool`; second-order moments in the pool, (k, 3 k),
        or -1, and their workspace in the modal work.
    sizes : ndarray of int
        Modal work, border work, slope measure.
    """

    bodies: IntegerRows
    pool: Reals
    carrying: Integers
    fields: IntegerRows
    sizes: Integers


COORDINATES, SPEEDS, DRIVES, STATES = range(4)
MODAL_SIZE, BORDER_SIZE, SLOPES = range(3)
ROTATION_VECTOR, TAIT_BRYAN = range(2)
