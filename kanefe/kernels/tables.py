"""The tables of a frozen scene, as kernels read them: named tuples of arrays.

What the columns of an array are says a record, or the file that the kernels of the array are in.
"""

from __future__ import annotations

from typing import NamedTuple

from kanefe.kernels.compiler.arrays import IntegerRows, Integers, RealRows, Reals
from kanefe.kernels.compiler.signatures import in_place


@in_place
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


@in_place
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


@in_place
class Reach(NamedTuple):
    """Data that determine which loads between frames can act. All but swept loads are in teams of adjacent loads.

    Attributes
    ----------
    teams : ndarray of int, shape (teams, TEAM_INTEGERS)
        First load and number of loads; a ball about all their ends, where they have one and the same bounds, or -1;
        their first internal state and how many there are, or -1 where these are not beside each other; the flexible
        body of their points or -1, how many points these are, where their numbers begin, whether they turn, and whether
        all ends are the points themselves.
    loads : ndarray of int, shape (loads, 3)
        Row of the first end, first of its balls among `members`, and number of balls; 0: it may always act.
    balls : ndarray of int, shape (balls, BALL_INTEGERS)
        Row (-1: N), and the swell that it grows by or -1. Those that are swept come first.
    centres : ndarray, shape (balls, BALL)
        Centre in the row and radius.
    swells : ndarray of int, shape (swells, 2)
        Flexible body, and the first of its weights.
    weights : ndarray
        Of the modes, of all swells.
    members : ndarray of int
        Balls of loads, one load after the other.
    bounds : ndarray, shape (loads, BOUNDS_NUMBERS)
        Origin and axes of a box in the row of the first end, its lower and upper corner, how far it is rounded, by how
        much a ball counts as larger, and whether it is a room, that what is in it does not reach.
    pairs : ndarray of int, shape (swept loads, 2)
        ``a * balls + b`` of the two balls, a < b, in rising order, and the load.
    points : ndarray
        Of each team with points: undeformed places in G, (n, 3), and motion from the modes, (k, 3 n), or (k, 6 n) of
        those that turn.
    sizes : ndarray of int, shape (3,)
        First of the loads that are found by a sweep over balls, how many balls it has, and whether one of these loads
        has internal states.
    """

    teams: IntegerRows
    loads: IntegerRows
    balls: IntegerRows
    centres: RealRows
    swells: IntegerRows
    weights: Reals
    members: Integers
    bounds: RealRows
    pairs: IntegerRows
    points: Reals
    sizes: Integers


@in_place
class LoadsBetween(NamedTuple):
    """Loads between frames of a scene.

    Attributes
    ----------
    loads : ndarray of int, shape (n, LOAD_INTEGERS)
        First end and number of ends, first of its numbers, first input, first internal state and number of states,
        team (-1: none), first point in it, number of points and the end that is the first of them.
    addresses : ndarray of int, shape (n, 2)
        Of its function for real and for complex numbers.
    rows : ndarray of int, shape (ends,)
        Row of each end (-1: N, COORDINATE, A_POINT).
    markers : ndarray, shape (ends, MARKER_NUMBERS)
    numbers : ndarray
        Constants of all loads.
    decay_rates, decay_energies : ndarray, shape (states,)
        Of states of loads that cannot act: l of ``dz/dt = -l z``, and e of an energy ``e z^2``.
    reach : Reach
        Where loads can act.
    workspace_size : ndarray of int, shape (3,)
        How many numbers the workspace of loads has, that of `find_near` at its beginning, and that of points after it.
    bearings : ndarray of int, shape (k, 3)
        Of loads that follow the reaction of a joint: number of the load, row of the joint's body, and whether moments
        count.
    bearing_places : ndarray, shape (k, 6)
        Origin of that body's frame, and the axis of the joint, in axes of the row.
    """

    loads: IntegerRows
    addresses: IntegerRows
    rows: Integers
    markers: RealRows
    numbers: Reals
    decay_rates: Reals
    decay_energies: Reals
    reach: Reach
    workspace_size: Integers
    bearings: IntegerRows
    bearing_places: RealRows


@in_place
class RigidPoints(NamedTuple):
    """The points of all rigid contacts of a scene.

    Attributes
    ----------
    places : ndarray of int, shape (n, POINT_INTEGERS)
    markers : ndarray, shape (2 n, MARKER_NUMBERS)
        Of the surface and of the probe of each.
    numbers : ndarray, shape (n, POINT_CONSTANTS)
    shapes : ndarray
        Kind and numbers of each surface.
    """

    places: IntegerRows
    markers: RealRows
    numbers: RealRows
    shapes: Reals


@in_place
class RowPaths(NamedTuple):
    """What the rows of constraints visit on their way from both ends to the row that holds them together.

    Rows of constraints that have a joint or modes in common are eliminated together, at the row of the scene that
    carries all that they visit; at -1, in N, those that reach it.

    Attributes
    ----------
    visits, meetings, guests : ndarray of int
        Records of `kanefe.kernels.constraints.row_paths`; the visits of each row of constraints go from children to
        parents.
    order, place : ndarray of int, shape (m,)
        The row of constraints that is eliminated at each place, and the place of each.
    places, meetings_at : ndarray of int, shape (rows of the scene + 2,)
        First place, and first meeting, of what is eliminated at each row of the scene, from N on.
    ends, blocks : ndarray of int, shapes (m + 1,), (m,)
        The envelope: see `kanefe.kernels.algebra.envelope`.
    """

    visits: IntegerRows
    meetings: IntegerRows
    guests: IntegerRows
    order: Integers
    place: Integers
    places: Integers
    meetings_at: Integers
    ends: Integers
    blocks: Integers


@in_place
class Loops(NamedTuple):
    """Constraints of a scene.

    Attributes
    ----------
    rows, numbers : ndarray
        Of `kanefe.kernels.constraints.constraint_rows.ConstraintRow`, m of them.
    terms, coefficients : ndarray
        Of `Term` there, coordinates of couplers.
    extents : ndarray, shape (free,)
        A large displacement along each free speed: rad, m, or modal units.
    moves : ndarray, shape (free,)
        Largest step of an iteration that closes the loops, along each free speed.
    limits : ndarray, shape (2,)
        `kanefe.kernels.constraints.loop_tables.Limits`.
    points : RigidPoints
        Of rigid contacts, three rows each behind those of constraints: along the normal, and in both directions along
        the surface.
    paths : RowPaths
    sizes : ndarray of int
        Of the memory of loops: `kanefe.kernels.constraints.loop_tables.RowWork`.
    """

    rows: IntegerRows
    numbers: RealRows
    terms: IntegerRows
    coefficients: RealRows
    extents: Reals
    moves: Reals
    limits: Reals
    points: RigidPoints
    paths: RowPaths
    sizes: Integers
