"""The tree of links: what is given of each, and what changes; views of the arrays of a frozen scene and of a workspace.

A scene is a list of *rows*, parents before children. A row is the moving frame of a link (a body behind its joint;
joints of several coordinates are chains of links) or an interface of a flexible body. What changes of a row is in
components of N and referred to the row's own origin: inertias then travel from child to parent by a shift alone,
without a rotation.
"""

from enum import IntEnum
from typing import Annotated

import numpy as np

from kanefe.kernels.language import Columns, Matrix, Record, Rows, Symmetric, Vector


class Kind(IntEnum):
    """Kinds of rows: those between FIXED and SPHERICAL have one coordinate."""

    FIXED = 0
    REVOLUTE = 1
    AXIS = 2
    GIVEN = 3
    SPHERICAL = 4
    FREE = 5
    INTERFACE = 6


class Link(Record, is_frozen=True):
    """What is given of a row.

    Attributes
    ----------
    parent : int
        Row; -1: the ground.
    kind : Kind
    coordinate, speed : int
        The first of each.
    drive : int
        Driven coordinate; -1: it is free.
    flexible : int
        Flexible body of the link or of the interface; -1: none.
    has_gravity : bool
    carries : bool
        Of an interface: whether something is attached to it.
    place : Vector
        Origin from the parent's origin, in axes of the parent, m; of an interface undeformed.
    axes : Matrix
        From axes of the joint's fixed frame to those of the parent.
    mass : float
        kg.
    first, second : Vector, Symmetric
        Mass times centre of mass, kg m, and inertia about the origin, kg m2, in axes of the row.
    rotor : Vector
        Angular momentum of rotors, in axes of the row.
    along, about : float
        Travel along z and turn about z of a unit of the coordinate.
    armature : float
        Inertia against the acceleration of each speed alone, of a rotor behind a gear.
    """

    parent: int
    kind: int
    coordinate: int
    speed: int
    drive: int
    flexible: int
    has_gravity: bool
    carries: bool
    place: Vector
    axes: Matrix
    mass: float
    first: Vector
    second: Symmetric
    rotor: Vector
    along: float
    about: float
    armature: float


class InterfaceLink(Link):
    """An interface of a flexible body.

    Attributes
    ----------
    basis : int
        Where its motion by the modes, (6, k), is in the pool; of a beam that bends far the number of the section.
    bending : int
        Where its second-order motion, (k, 6 k), is in the pool; -1: none.
    bent : int
        Where its current basis is in the modal work, followed by as many numbers of workspace; -1: it does not change.
    """

    basis: int
    bending: int
    bent: int


class GivenLink(Link):
    """A link whose motion a C function gives.

    Attributes
    ----------
    function, complex_function : int
        Addresses, for real and for complex numbers.
    first_number : int
        First of its constants in `Tables.numbers`.
    """

    function: int
    complex_function: int
    first_number: int


LINK_INTEGERS = max(InterfaceLink.integer_count, GivenLink.integer_count)
"""How many whole numbers are given of each row, whatever its kind."""


class Links(Rows[Link]):
    """What is given of all rows: of `Tables.rows` and `Tables.geometry`."""


class Motion(Record):
    """How a row moves.

    Attributes
    ----------
    R : Matrix
        Axes of the row, to N.
    r, p : Vector
        Origin from the parent's origin and from that of N, m.
    v, w : Vector
        Velocity of the origin and angular velocity.
    Z, Y : Vector
        Acceleration of the origin, less gravity, and angular acceleration with du = 0: the remainders of Eq. 13-16.
    """

    R: Matrix
    r: Vector
    p: Vector
    v: Vector
    w: Vector
    Z: Vector
    Y: Vector


class Frame(Motion):
    """All that changes of a row. What it needs of its parent, articulated: f + M a + H alpha and n + H^T a + J alpha.

    Attributes
    ----------
    M, H, J : Symmetric, Matrix, Symmetric
        Articulated inertia.
    f, n : Vector
        Force and moment with du = 0.
    a, alpha : Vector
        Share of du in the acceleration of the origin and in the angular acceleration.
    """

    M: Symmetric
    H: Matrix
    J: Symmetric
    f: Vector
    n: Vector
    a: Vector
    alpha: Vector


class AxisFrame(Frame):
    """The frame of a link of one coordinate that is free.

    Attributes
    ----------
    Ul, Ua : Vector
        Inertia times the motion of a unit of the speed: force and moment that this needs.
    pivot : float
        Inverse of the inertia along the coordinate.
    rest : float
        Acceleration along the coordinate with the parent at rest.
    """

    Ul: Vector
    Ua: Vector
    pivot: float
    rest: float


class GivenFrame(AxisFrame):
    """The frame of a link whose motion a C function gives.

    Attributes
    ----------
    partial_v, partial_w : Vector
        Partial velocity of the origin and partial angular velocity.
    """

    partial_v: Vector
    partial_w: Vector


class BallFrame(Frame):
    """The frame of a spherical link.

    Attributes
    ----------
    turning : Symmetric
        Inverse of J, with the armature.
    """

    turning: Symmetric


class FreeFrame(Frame):
    """The frame of a free link, whose body moves as if alone.

    Attributes
    ----------
    moving : Symmetric
        Inverse of M, with the armature.
    turning : Symmetric
        Inverse of what resists turning while the body gives way, J - H^T M^-1 H.
    """

    moving: Symmetric
    turning: Symmetric


class InterfaceFrame(Frame):
    """The frame of an interface.

    Attributes
    ----------
    tangent : Matrix
        From rates of its slopes to its angular velocity, in G.
    """

    tangent: Matrix


FRAME_NUMBERS = max(kind.number_count for kind in (GivenFrame, BallFrame, FreeFrame, InterfaceFrame))
"""How many numbers there are of each row, whatever its kind."""


class FunctionFrame(Motion):
    """What the C function of a given link is called with, until inertias come to this place.

    Attributes
    ----------
    coordinate : ndarray, shape (1,)
    written : ndarray, shape (24,)
        What the function writes, as `FunctionMotion` has it.
    """

    coordinate: Annotated[np.ndarray, Columns(1)]
    written: Annotated[np.ndarray, Columns(24)]


class FunctionMotion(Motion):
    """What the C function of a given link has written, in axes of the joint's fixed frame.

    Attributes
    ----------
    coordinate : float
    position, turned : Vector, Matrix
        Of the moving frame.
    by_v, by_w : Vector
        Partial velocity and partial angular velocity.
    by_v_rate, by_w_rate : Vector
        Their derivatives by the coordinate.
    """

    coordinate: float
    position: Vector
    turned: Matrix
    by_v: Vector
    by_w: Vector
    by_v_rate: Vector
    by_w_rate: Vector


class Frames(Rows[Frame]):
    """What changes of all rows, and last of the ground, the parent -1: of the work array."""
