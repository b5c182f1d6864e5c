"""Many loose bodies, balls and walls that meet: what steps over their impacts are given, and what they keep.

Each named tuple of arrays is read in place; rows of records are views of them.
"""

from enum import IntEnum
from typing import Annotated, Any, NamedTuple

from kanefe.kernels.language import Behind, IntegerRows, Integers, RealRows, Reals, Record, Rows, in_place
from kanefe.kernels.values.tensors import Matrix, Vector


class LooseBody(Record):
    """A body that turns about its centre of mass: kg, and its inertia and the inverse of this, in its axes."""

    mass: float
    inertia: Matrix
    inverse: Matrix


class Ball(Record):
    """A ball: its body, its centre in the axes of that, and its radius, m."""

    body: float
    centre: Vector
    radius: float


class Wall(Record):
    """A wall: its place and axes in N, and kind and numbers of its shape."""

    p: Vector
    A: Matrix
    shape: Annotated[Any, Behind()]


class BodyState(Record):
    """Velocity in N, and angular velocity in axes of the body."""

    v: Vector
    w: Vector


class Place(Record):
    """A place in N, or an impulse along the directions of a contact."""

    x: Vector


class Contact(Record):
    """A contact of a ball with another body, or with a wall, -1, of which what would move is zero.

    In rows of matrices, along the normal and two tangential directions: the directions in N, the moments of unit forces
    about both bodies, in their axes, and the angular velocities that unit impulses add. Then the inverses of both
    masses, 1/kg; the impulse, N s; what the law adds to the rates at the end of the step, of those at its start, m/s;
    the inverses of the effective inertias, kg; what a unit impulse along the normal adds to the other rates, 1/kg; the
    rates at the start, and the largest of these and of those without impulses. `key` is a number of the pair, `group`
    the root of its group.
    """

    body: int
    other: int
    key: int
    group: int
    axes: Matrix
    arms: Matrix
    other_arms: Matrix
    spins: Matrix
    other_spins: Matrix
    lightness: float
    other_lightness: float
    impulse: Vector
    beside: Vector
    inverse_normal: float
    inverse_along: float
    by_normal: Vector
    before: Vector
    speed: float


class Stage(IntEnum):
    """What is done to a group: nothing, its impulses make no energy; the whole restitution, none, or means of rates."""

    SOLVED = 0
    TRIED = 1
    WITHOUT = 2
    IN_MEAN = 3
    HALVED = 4  # a share of it that is halved, and the lowest one
    LOWEST = 5


class Group(Record):
    """Bodies that touch each other: of each the next one towards the root, of a root its `Stage` and sums.

    Work of impulses (J), their size (N s), the largest rate (m/s), and between which shares of the restitution they
    begin to make energy.
    """

    root: int
    stage: int
    work: float
    size: float
    fastest: float
    low: float
    high: float


class Control(Record):
    """What steps are asked for, and what they tell.

    Steps that remain; contacts of the last step and of all; sweeps in total, and most in a step; groups whose
    restitution was lowered. Then s, m/s2 and fractions, of which `enough` is the change of speeds in a sweep, relative
    to the largest, that counts as none; penetration, m; the largest change at the end of sweeps; energy taken, J.
    """

    steps: int
    touching: int
    sweeps: int
    most_sweeps: int
    touched: int
    lowered: int
    step: float
    gravity: Vector
    restitution: float
    friction: float
    enough: float
    deepest: float
    residual: float
    taken: float


LooseBodies = Rows[LooseBody]
Balls = Rows[Ball]
BodyStates = Rows[BodyState]
Places = Rows[Place]
Contacts = Rows[Contact]
Groups = Rows[Group]


@in_place
class Loose(NamedTuple):
    """What is given.

    `LooseBodies` and `Balls`; where each `Wall` begins in `shapes`; numbers of pairs that pass through each other,
    ascending.
    """

    bodies: RealRows
    balls: RealRows
    walls: Integers
    shapes: Reals
    left_out: Integers


@in_place
class Steps(NamedTuple):
    """What changes.

    A `Control`; places and Euler parameters, (bodies, 7), and `BodyStates`; the balls by x, as they were last; room for
    where they are along x and for their centres, for `Contacts`, and for a table of the pairs of the step before, a
    power of two of -1; numbers of those pairs, of which the last is how many they are, and their impulses; `Groups`.
    """

    counts: Integers
    control: Reals
    q: RealRows
    u: RealRows
    order: Integers
    keys: Reals
    places: RealRows
    pairs: IntegerRows
    contacts: RealRows
    slots: Integers
    kept_keys: Integers
    kept: RealRows
    groups: IntegerRows
    sums: RealRows
