"""The tables of a frozen scene, as kernels read them: named tuples of arrays.

What the columns of an array are says a record, or the file that the kernels of the array are in.
"""

from typing import NamedTuple

from kanefe.kernels.language import IntegerRows, Integers, RealRows, Reals, in_place


@in_place
class Tables(NamedTuple):
    """A frozen scene as arrays.

    Attributes
    ----------
    rows : ndarray of int, shape (rows, ROW_INTEGERS)
    geometry : ndarray, shape (rows, ROW_NUMBERS)
    gravity : ndarray, shape (3,)
    loads, points : ndarray
        Forces and torques: `kanefe.kernels.loads.point_and_field_loads.PointLoad`.
    joint_forces : ndarray of int
        Along joint coordinates: `kanefe.kernels.loads.joint_forces.JointForce`.
    laws : ndarray
        `kanefe.kernels.loads.coordinate_law.CoordinateLaw`.
    sizes : ndarray of int
        `kanefe.kernels.scene.Sizes`.
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
    fields : ndarray of int
        Distributed loads: `kanefe.kernels.loads.point_and_field_loads.Traction`.
    sizes : ndarray of int
        `kanefe.kernels.scene.FlexibleSizes`.
    """

    bodies: IntegerRows
    pool: Reals
    carrying: Integers
    fields: IntegerRows
    sizes: Integers


@in_place
class Reach(NamedTuple):
    """Data that determine which loads between frames can act: the records of `kanefe.kernels.loads.reach`.

    All but swept loads are in teams of adjacent loads.

    Attributes
    ----------
    teams : ndarray of int
        `Team`.
    loads, bounds : ndarray
        `Bound`, of each load.
    balls, centres : ndarray
        `RowBall`.
    swells : ndarray of int
        `Swell`.
    weights : ndarray
        Of the modes, of all swells.
    members : ndarray of int
        Balls of loads, one load after the other.
    pairs : ndarray of int
        `Pair`, of each swept load.
    points : ndarray
        Of each team with points: undeformed places in G, and motion from the modes.
    sizes : ndarray of int
        `ReachSizes`.
    """

    teams: IntegerRows
    loads: IntegerRows
    bounds: RealRows
    balls: IntegerRows
    centres: RealRows
    swells: IntegerRows
    weights: Reals
    members: Integers
    pairs: IntegerRows
    points: Reals
    sizes: Integers


@in_place
class LoadsBetween(NamedTuple):
    """Loads between frames of a scene.

    Attributes
    ----------
    loads : ndarray of int
        `kanefe.kernels.loads.acting.BetweenLoad`.
    ends, markers : ndarray
        `kanefe.kernels.loads.acting.LoadEnd`, of one load after the other.
    numbers : ndarray
        Constants of all loads.
    decay_rates, decay_energies : ndarray, shape (states,)
        Of states of loads that cannot act: l of ``dz/dt = -l z``, and e of an energy ``e z^2``.
    reach : Reach
        Where loads can act.
    workspace : ndarray of int
        The whole numbers of `kanefe.kernels.loads.acting.Acting`.
    bearings, bearing_places : ndarray
        `kanefe.kernels.loads.joint_reactions.Bearing`.
    """

    loads: IntegerRows
    ends: IntegerRows
    markers: RealRows
    numbers: Reals
    decay_rates: Reals
    decay_energies: Reals
    reach: Reach
    workspace: Integers
    bearings: IntegerRows
    bearing_places: RealRows


@in_place
class RigidPoints(NamedTuple):
    """The points of all rigid contacts of a scene.

    Attributes
    ----------
    places, numbers : ndarray
        `kanefe.kernels.contact.rigid_points.RigidPoint`.
    shapes : ndarray
        Kind and numbers of each surface.
    """

    places: IntegerRows
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
