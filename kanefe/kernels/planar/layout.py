"""Where everything is in the arrays of a planar scene.

A plane has two axes, and a normal about which everything turns. A row is the moving frame of a link, parents before
children; row 0 is N, so that no row needs to be asked whether it has a parent. All rows have the axes of the plane when
all coordinates are zero: an angle is then a sum of coordinates, and the axes of a row are its cosine and sine.
"""

from enum import IntEnum
from typing import Annotated, NamedTuple

import numpy as np

from kanefe.kernels.language import Array, IntegerRows, Integers, RealRows, Reals, Record, Start, in_place


class RowKind(IntEnum):
    """Kinds of rows: about the normal, along an axis of the plane, all three motions of the plane."""

    TURN = 0
    SLIDE = 1
    FLOAT = 2


class RowPlaces(NamedTuple):
    """Columns of `PlanarTables.rows`."""

    parent: int = 0
    kind: int = 1
    coordinate: int = 2
    speed: int = 3
    drive: int = 4
    is_lifted: int = 5


ROW, ROW_INTEGERS = RowPlaces(), 6


class Shape(NamedTuple):
    """Columns of `PlanarTables.geometry`, in axes of the row (the place: of its parent)."""

    place: int = 0  # origin from the parent row's origin, all coordinates zero
    axis: int = 2  # of a slide; of a float: that of its first coordinate
    sign: int = 4  # 1 or -1: the normal against the axis about which the joint turns
    mass: int = 5
    first: int = 6  # mass times centre of mass
    second: int = 8  # inertia about the origin and the normal
    lifted: int = 9  # mass, and mass times centre of mass, that gravity spares
    armature: int = 12  # inertia along the coordinate alone


SHAPE, ROW_NUMBERS = Shape(), 13


class WorkPlaces(NamedTuple):
    """Columns of the work array."""

    c: int = 0  # cosine and sine of the angle
    s: int = 1
    w: int = 2  # angular velocity
    offset: int = 3  # from the parent row's origin
    velocity: int = 5
    bias: int = 7  # acceleration of the origin beyond that of the same point of the parent and the joint's own du
    m: int = 9  # articulated inertia: force = M a + H alpha, moment = H . a + J alpha; xx, xy, yy
    h: int = 12
    j: int = 14
    force: int = 15  # what must act on the row from its parent at no acceleration
    moment: int = 17
    u: int = 18  # over the inertia along the joint: inertia times its axis; of a turn about the parent's origin
    rest: int = 21  # over the inertia along the joint: generalised force that the acceleration is to balance
    acceleration: int = 22  # gravity taken off
    alpha: int = 24


AT, WORK = WorkPlaces(), 25


@in_place
class PlanarTables(NamedTuple):
    """A planar scene as arrays.

    Attributes
    ----------
    rows : ndarray of int, shape (rows, ROW_INTEGERS)
    geometry : ndarray, shape (rows, ROW_NUMBERS)
    gravity : ndarray, shape (2,)
    loads : ndarray of int, shape (loads, 4)
        Row, first of three inputs, is a torque, follows.
    points : ndarray, shape (loads, 8)
        Where a force acts in axes of its row, and the 2 x 3 matrix that takes its inputs into the plane: into axes of
        the row if it follows. Of a torque, after two zeros: the normal.
    joint_forces : ndarray of int, shape (forces, 4)
        Coordinate (-1 - drive if driven), speed, law, input.
    laws : ndarray, shape (forces, 7)
        Stiffness, damping, rest, friction, friction speed, lower, upper, stiffness and damping of the stops.
    sizes : ndarray of int
        Coordinates, free speeds, driven coordinates, internal states.
    work : ndarray of int
        The whole numbers of `PlanarWork`.
    """

    rows: IntegerRows
    geometry: RealRows
    gravity: Reals
    loads: IntegerRows
    points: RealRows
    joint_forces: IntegerRows
    laws: RealRows
    sizes: Integers
    work: Integers


class PlanarWork(Record, is_frozen=True):
    """What an evaluation writes on its way.

    Attributes
    ----------
    size, row_count, speed_count : int
    work : ndarray, shape (rows, WORK)
    angles, cosines, sines : ndarray, shape (rows,)
    applied, added : ndarray, shape (free + driven,)
        Generalised forces at the joints, and inertia that a linearly implicit evaluation adds along them.
    """

    size: int
    row_count: int
    speed_count: int
    begins: Annotated[int, Start("memory")]
    work: Annotated[np.ndarray, Array("row_count", WORK)]
    angles: Annotated[np.ndarray, Array("row_count")]
    cosines: Annotated[np.ndarray, Array("row_count")]
    sines: Annotated[np.ndarray, Array("row_count")]
    applied: Annotated[np.ndarray, Array("speed_count")]
    added: Annotated[np.ndarray, Array("speed_count")]
