"""Inertia and force that a body brings to its row."""

from typing import Any

from kanefe.kernels.language import inlined
from kanefe.kernels.tree import Frame
from kanefe.kernels.values.tensors import (
    NO_INERTIA,
    NO_MATRIX,
    ZERO,
    Matrix,
    Symmetric,
    Vector,
    congruent,
    cross,
    diagonal,
    skew,
)


@inlined
def put_inertia(frame: Frame, mass: Any, c: Vector, J: Symmetric, f: Vector, n: Vector) -> None:
    """Write what a body brings to its row; c is its mass times its centre of mass."""
    frame.M, frame.H, frame.J = diagonal(mass), (-skew(c)).full, J
    frame.f, frame.n = f, n


@inlined
def put_rigid(frame: Frame, mass: Any, first: Vector, second: Symmetric, rotor: Vector) -> None:
    """Write inertia and force of a rigid body; the gyroscopic moment is w~ J w (Eq. 17, 37).

    Parameters
    ----------
    first, second, rotor : Vector, Symmetric, Vector
        Mass times centre of mass, inertia about the origin, and angular momentum of rotors, in axes of the row.
    """
    R, w, Z, Y = frame.R, frame.w, frame.Z, frame.Y
    c, J = R @ first, congruent(R, second)
    f = mass * Z + cross(Y, c) + cross(w, cross(w, c))
    n = cross(c, Z) + J @ Y + cross(w, J @ w + R @ rotor)
    put_inertia(frame, mass, c, J, f, n)


@inlined
def first_moment(H: Matrix) -> Vector:
    """Return mass times centre of mass of a row, from its origin, which its H has."""
    return Vector(H.z.y, H.x.z, H.y.x)


@inlined
def clear_forces(frame: Frame) -> None:
    """Write no force."""
    frame.f, frame.n = ZERO, ZERO


@inlined
def clear(frame: Frame) -> None:
    """Write no inertia and no force."""
    frame.M, frame.H, frame.J = NO_INERTIA, NO_MATRIX, NO_INERTIA
    clear_forces(frame)
