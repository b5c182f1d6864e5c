"""Flexible bodies: what is given of each, what changes of its modes, and what couples these to interfaces.

Modes are of unit mass and diagonal stiffness. What changes is in the mesh frame G of the body.
"""

from typing import Annotated

import numpy as np

from kanefe.kernels.language import Array, Many, Matrix, One, Record, Rows, Start, Symmetric, Table, Values, Vector


class ModalCoordinates(Record, is_frozen=True):
    """The coordinates of a flexible body of k modes.

    Attributes
    ----------
    k : int
    first_eta, first_deta : int
        First coordinate and first speed.
    """

    k: int
    first_eta: int
    first_deta: int


class AllModalCoordinates(Rows[ModalCoordinates]):
    """Those of all flexible bodies: of `FlexibleTables.bodies`."""


class Arm(Record):
    """A spring and a damper in series along a mode, whose state z follows ``dz/dt = rate (pull eta - z)``."""

    mode: float
    state: float
    pull: float
    rate: float


class Arms(Rows[Arm]):
    """The arms of a body."""


class ModalBody(ModalCoordinates):
    """A flexible body of k modes.

    Attributes
    ----------
    link : int
        Its row.
    constants : int
        Where its constants begin in the pool.
    mass : float
    first, second : Vector, Symmetric
        Moments of mass: int rho r and int rho r r^T.
    stiffness : ndarray, shape (k,)
    translation, shapes, rotation : Values
        Linear momentum, moments int rho r psi^T and angular momentum of each mode.
    products : ndarray, shape (k, 9 k)
        Symmetric and antisymmetric moments of two modes.
    work : int
        Where what changes begins in the modal work.
    eta, deta : ndarray, shape (k,)
    even, odd, odd_rates : Values
        Products with eta, and the antisymmetric ones with deta.
    linear, angular : Values
        C: inertia between the motion of G and the modes.
    p, x : ndarray, shape (k,)
        Forces on the modes and their accelerations.
    scale : ndarray, shape (k,)
        Of a linearly implicit sweep: what the modes are scaled by.
    transform : int
        -1: the modes are the coordinates themselves.
    to_modes, from_modes : ndarray, shape (k, k)
        To modes and back, transposed.
    damped : int
        -1: there is no damping.
    damping : ndarray, shape (k, k)
    bends_twice : int
        -1: there is no second-order displacement.
    quadratic : ndarray, shape (k, 6 k)
        Its moments.
    bending : int
    bent : ndarray, shape (9, k)
        Workspace of these.
    wet : int
        -1: there is no fluid around it.
    fluid_mass, fluid_lever, fluid_inertia : Symmetric, Matrix, Symmetric
        Added mass of G, see `kanefe.kernels.sweeps.fluid`: H of its M, H, J.
    fluid_linear, fluid_angular : Values
        That between the motion of G and the modes.
    arm_count, springs, arms : int, int, Arms
        Arms of a viscoelastic body that pull on one mode each.
    carried, carried_count : int
        First of its interfaces that carry something, in `FlexibleTables.carrying`, and how many they are.
    is_exact : bool
        Whether it is a beam that bends far, see `kanefe.kernels.beams`.
    """

    link: int
    constants: Annotated[int, Start("pool")]
    mass: Annotated[float, One(float)]
    first: Annotated[Vector, One(Vector)]
    second: Annotated[Symmetric, One(Symmetric)]
    stiffness: Annotated[np.ndarray, Array("k")]
    translation: Annotated[Values, Many(Vector, "k")]
    shapes: Annotated[Values, Many(Symmetric, "k")]
    rotation: Annotated[Values, Many(Vector, "k")]
    products: Annotated[np.ndarray, Array("k", "9k")]
    work: Annotated[int, Start("modal")]
    eta: Annotated[np.ndarray, Array("k")]
    deta: Annotated[np.ndarray, Array("k")]
    even: Annotated[Values, Many(Symmetric, "k")]
    odd: Annotated[Values, Many(Vector, "k")]
    odd_rates: Annotated[Values, Many(Vector, "k")]
    linear: Annotated[Values, Many(Vector, "k")]
    angular: Annotated[Values, Many(Vector, "k")]
    p: Annotated[np.ndarray, Array("k")]
    x: Annotated[np.ndarray, Array("k")]
    scale: Annotated[np.ndarray, Array("k")]
    transform: Annotated[int, Start("pool")]
    to_modes: Annotated[np.ndarray, Array("k", "k")]
    from_modes: Annotated[np.ndarray, Array("k", "k")]
    damped: Annotated[int, Start("pool")]
    damping: Annotated[np.ndarray, Array("k", "k")]
    bends_twice: Annotated[int, Start("pool")]
    quadratic: Annotated[np.ndarray, Array("k", "6k")]
    bending: Annotated[int, Start("modal")]
    bent: Annotated[np.ndarray, Array(9, "k")]
    wet: Annotated[int, Start("pool")]
    fluid_mass: Annotated[Symmetric, One(Symmetric)]
    fluid_lever: Annotated[Matrix, One(Matrix)]
    fluid_inertia: Annotated[Symmetric, One(Symmetric)]
    fluid_linear: Annotated[Values, Many(Vector, "k")]
    fluid_angular: Annotated[Values, Many(Vector, "k")]
    arm_count: int
    springs: Annotated[int, Start("pool")]
    arms: Annotated[Arms, Table(Arms, "arm_count", Arm.number_count)]
    carried: int
    carried_count: int
    is_exact: bool


class ModalBodies(Rows[ModalBody]):
    """All flexible bodies: of `FlexibleTables.bodies`, `FlexibleTables.pool` and the modal work."""


class BorderedBody(ModalBody):
    """A flexible body with what couples its modes to G and to its interfaces that carry something: n = 6 for each.

    Attributes
    ----------
    border : int
        Where it begins in the border work.
    basis : ndarray, shape (n, k)
        B, the motion of the interfaces from the modes.
    lever : ndarray, shape (n, 6)
        H, their motion with G while the modes give way.
    inertia, force : ndarray, shapes (n, 6), (n,)
        A, a block of six for each interface, and f of what they carry.
    series : ndarray, shape (n, 6)
        A' H.
    gram : ndarray, shape (n, n)
        B B^T.
    factors, pivots : ndarray, shapes (n, n), (n,)
        Those of 1 + A B B^T.
    held, column : ndarray, shape (n,)
        y_0, and a column that is used on the way to it.
    """

    border: Annotated[int, Start("border")]
    basis: Annotated[np.ndarray, Array("6carried_count", "k")]
    lever: Annotated[np.ndarray, Array("6carried_count", 6)]
    inertia: Annotated[np.ndarray, Array("6carried_count", 6)]
    series: Annotated[np.ndarray, Array("6carried_count", 6)]
    gram: Annotated[np.ndarray, Array("6carried_count", "6carried_count")]
    factors: Annotated[np.ndarray, Array("6carried_count", "6carried_count")]
    force: Annotated[np.ndarray, Array("6carried_count")]
    pivots: Annotated[np.ndarray, Array("6carried_count")]
    held: Annotated[np.ndarray, Array("6carried_count")]
    column: Annotated[np.ndarray, Array("6carried_count")]


class BorderedBodies(Rows[BorderedBody]):
    """All flexible bodies: of the arrays of `ModalBodies` and the border work."""
