"""Bushings: springs and dampers in all six directions between two ends (Eq. 11)."""

from typing import Any

import numpy as np

from kanefe.kernels.force_elements.places import SIGNATURE, Done, End, Ends, Wrenches
from kanefe.kernels.language import Matrix, Record, Vector, called_by_address, cross, dot, inlined
from kanefe.kernels.sweeps.slopes import slope_motion


class SixBySix(Record):
    """A matrix (6, 6), of displacements and rotations to forces and moments, as four matrices: see `in_blocks`."""

    force_by_shift: Matrix
    force_by_turn: Matrix
    moment_by_shift: Matrix
    moment_by_turn: Matrix


class BushingNumbers(Record):
    """Numbers of a bushing: its matrices, and whether a law of the user gives forces too."""

    stiffness: SixBySix
    damping: SixBySix
    inputs: float


@called_by_address(*SIGNATURE)
def bushing(t: float, numbers: Any, inputs: Any, ends: Any, states: Any, out: Any) -> None:
    """Write what it exerts on a and b; see `BushingNumbers`."""
    own, done = BushingNumbers(numbers), Done(out)
    d, theta, rate, spin = seen_from_a(ends)
    none = 0.0 * theta
    tangent = slope_motion(0, theta, none)[1]
    turning = solved(tangent, spin)
    spring, spring_r = six_by_six(own.stiffness, d, theta)
    beside, beside_r = six_by_six(own.stiffness, rate, turning)
    brake, brake_r = six_by_six(own.damping, rate, spin)
    force = -spring - brake
    moment = -solved(tangent.T, spring_r) - brake_r
    done.potential = 0.5 * (dot(spring, d) + dot(spring_r, theta))
    done.taken = dot(brake, rate) + dot(brake_r, spin)
    # of the skew part of the stiffness
    done.given = 0.5 * (dot(d, beside) + dot(theta, beside_r) - dot(rate, spring) - dot(turning, spring_r))
    if own.inputs > 0.0:
        more, more_r = Vector(inputs[0], inputs[1], inputs[2]), Vector(inputs[3], inputs[4], inputs[5])
        force, moment = force + more, moment + more_r
        done.given += dot(rate, more) + dot(spin, more_r)
    put_on_both(ends, force, moment, done)


def in_blocks(matrices: np.ndarray) -> np.ndarray:
    """Return matrices (..., 6, 6) as the numbers of `SixBySix`, (..., 36)."""
    return matrices.reshape(*matrices.shape[:-2], 2, 3, 2, 3).swapaxes(-3, -2).reshape(*matrices.shape[:-2], 36)


@inlined
def six_by_six(K: SixBySix, shift: Vector, turn: Vector) -> tuple[Vector, Vector]:
    """Return the force and the moment of a displacement and a rotation."""
    return K.force_by_shift @ shift + K.force_by_turn @ turn, K.moment_by_shift @ shift + K.moment_by_turn @ turn


@inlined
def rates_from_a(a: End, b: End) -> tuple[Vector, Vector]:
    """Return velocity and angular velocity of b seen from a, in the axes of a."""
    return a.A.T @ (b.v - a.v - cross(a.w, b.p - a.p)), a.A.T @ (b.w - a.w)


@inlined
def seen_from_a(ends: Any) -> tuple[Vector, Vector, Vector, Vector]:
    """Return where b is seen from a, in the axes of a: offset, rotation vector, rate, angular velocity."""
    a, b = Ends(ends)[0], Ends(ends)[1]
    rate, spin = rates_from_a(a, b)
    return a.A.T @ (b.p - a.p), rotation_vector_of(a.A.T @ b.A), rate, spin


@inlined
def put_on_both(ends: Any, force: Vector, moment: Vector, done: Done) -> None:
    """Write a force and moment on b at its origin, in the axes of a, and the reverse on a at the same point."""
    a, b, on = Ends(ends)[0], Ends(ends)[1], Wrenches(done.wrenches)
    force, moment = a.A @ force, a.A @ moment
    on[1].force, on[1].moment = force, moment
    on[0].force, on[0].moment = -force, -(moment + cross(b.p - a.p, force))


@inlined
def solved(A: Matrix, b: Vector) -> Vector:
    """Return A^-1 b by cofactors."""
    x, y, z = A.T.x, A.T.y, A.T.z
    first = cross(y, z)
    return (1.0 / dot(x, first)) * (b.x * first + b.y * cross(z, x) + b.z * cross(x, y))


@inlined
def rotation_vector_of(A: Matrix) -> Vector:
    """Return the rotation vector (at most half a turn) of a rotation matrix, through its largest Euler parameter."""
    trace, B = A.x.x + A.y.y + A.z.z, A.T
    rest, skewed = 1.0 - trace, Vector(A.y.z - A.z.y, A.z.x - A.x.z, A.x.y - A.y.x)
    largest = max(trace.real, A.x.x.real, A.y.y.real, A.z.z.real)
    if trace.real == largest:
        e0, e = 1.0 + trace, skewed
    elif A.x.x.real == largest:
        e0, e = skewed.x, A.x + B.x + Vector(rest, 0.0, 0.0)
    elif A.y.y.real == largest:
        e0, e = skewed.y, A.y + B.y + Vector(0.0, rest, 0.0)
    else:
        e0, e = skewed.z, A.z + B.z + Vector(0.0, 0.0, rest)
    square, sign = dot(e, e), -1.0 if e0.real < 0.0 else 1.0
    cosine = sign * e0
    if square.real < 1e-16 * (cosine * cosine).real:
        return (2.0 * sign / cosine) * e
    sine = np.sqrt(square)
    angle = 2.0 * np.arctan(sine / cosine) if cosine.real > sine.real else np.pi - 2.0 * np.arctan(cosine / sine)
    return (sign * angle / sine) * e
