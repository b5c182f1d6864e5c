"""Frames, rotations and the notation of the package.

Notation
--------
A name carries quantity, frames and components, as the super- and subscripts of the paper do (Eq. 1, 2): ``A_AB`` maps
components in frame B to components in frame A, so that ``A_AC = A_AB @ A_BC``; ``p_AoBo_N`` is the position of B's
origin from A's origin, in components of N; ``w_AB_B`` is the angular velocity of B seen from A, in components of B.
Frames: N inertial, R rigid body, G mesh frame of a flexible body, n interface or node.

The paper names the matrix of Eq. 6 and Eq. 8 ``T_(b<-a)`` and that of Eq. 7 the other way round; all of them are
``A_ab`` here (see EQUATIONS.md).

Euler parameters are scalar first, ``e = (e0, e1, e2, e3)``, and need not be normalised to be read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any, Protocol, TypeGuard, runtime_checkable

import numpy as np

from kanefe.errors import ModelError

Vector = np.ndarray
Matrix = np.ndarray
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def skews(v: np.ndarray) -> np.ndarray:
    """Return v~ of vectors (..., 3), see `skew`, shape (..., 3, 3)."""
    found = np.zeros((*v.shape, 3))
    found[..., 2, 1], found[..., 0, 2], found[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    return found - found.swapaxes(-1, -2)


def skew(v: Vector | Sequence[float]) -> Matrix:
    """Return v~, the matrix of the cross product: ``skew(a) @ b = a x b`` (Eq. 4), shape (3, 3)."""
    x, y, z = v.tolist() if isinstance(v, np.ndarray) else v
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def axial(T: Matrix) -> Vector:
    """Return ``(T_yz - T_zy, T_zx - T_xz, T_xy - T_yx)``: ``axial(a b^T) = a x b``, shape (3,)."""
    return np.array((T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0]))


def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b of two 3-vectors, or row by row (n, 3), faster than numpy's general routine."""
    # numbers of Python take a third of the time of those of numpy, with the same digits
    a0, a1, a2 = a.tolist() if a.ndim == 1 else a.T
    b0, b1, b2 = b.tolist() if b.ndim == 1 else b.T
    return np.array((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0)).T


def euler_parameters(axis: Vector | Sequence[float], angle: float) -> Vector:
    """Return the Euler parameters of a rotation by `angle` (rad) about `axis` (Eq. 5), shape (4,).

    Raises
    ------
    ModelError
        If the axis has no length.

    Examples
    --------
    >>> euler_parameters((0, 0, 1), np.pi).round(12)
    array([0., 0., 0., 1.])
    """
    return np.concatenate(([math.cos(angle / 2)], math.sin(angle / 2) * unit_vector(axis, "the axis of a rotation")))


def numbers(value: object) -> np.ndarray:
    """Return a new array of floats; NaN of shape () if `value` is none, so that the check of the caller reports it.

    Texts, booleans, complex numbers, decimals (floats do not calculate with them) and whole numbers beyond the range of
    floats are not converted.
    """
    if type(value) is float:  # most are
        return np.array(value)
    try:
        given = np.array(value)
        if given.dtype.kind == "O" and all(one is None or _is_real(one) for one in given.flat):
            given = given.astype(float)
    except (TypeError, ValueError, OverflowError):
        return np.array(np.nan)
    return given.astype(float, copy=False) if given.dtype.kind in "fiu" else np.array(np.nan)


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def shaped_numbers(value: object, shape: tuple[int, ...], what: str, *, is_finite: bool = True) -> np.ndarray:
    """Return an array of floats of a shape; raise a ModelError that names `what` if it is another, or not finite."""
    array = numbers(value)
    if array.shape != shape or (is_finite and not np.all(np.isfinite(array))):
        finite = "finite " if is_finite else ""
        wanted = f"{finite}numbers of shape {shape}" if shape else f"one {finite}number"
        raise ModelError(f"{what} must be {wanted}; got {value!r}")
    return array


def unit_vector(v: Vector | Sequence[float], what: str) -> Vector:
    """Return v / |v|; raise a ModelError that names `what` if v has no length or is not three finite numbers."""
    array = numbers(v)
    length = math.sqrt(array.dot(array)) if array.shape == (3,) else 0.0
    if not 1e-300 <= length < math.inf:
        raise ModelError(f"{what} must be three finite numbers with a length above zero, not {v!r}")
    return array / length


def direction(value: object, what: str) -> Vector:
    """Return a unit vector from "x", "-z" or three numbers; a ModelError names `what` if it is none of these."""
    if isinstance(value, str) and value.removeprefix("-") in AXES:
        return np.array(AXES[value.removeprefix("-")]) * (-1.0 if value.startswith("-") else 1.0)
    given = numbers(value) if not isinstance(value, str) else np.zeros(0)
    length = math.sqrt(given.dot(given)) if given.shape == (3,) else 0.0
    if not (length > 0.0 and math.isfinite(length)):
        raise ModelError(f"{what} must be 'x', 'y', 'z', one of these with a minus, or three numbers, not {value!r}")
    return given / length


def axis_rotation(axis: Vector | Sequence[float], angle: float) -> Matrix:
    """Return the rotation matrix (Eq. 6) about a unit vector by `angle` in rad, shape (3, 3); the axis is not checked.

    Examples
    --------
    >>> axis_rotation(np.array((0.0, 0.0, 1.0)), np.pi / 2).round(12).tolist()
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    k = 2.0 * math.sin(0.5 * angle) ** 2
    return np.array(
        (
            (c + k * x * x, k * x * y - s * z, k * x * z + s * y),
            (k * x * y + s * z, c + k * y * y, k * y * z - s * x),
            (k * x * z - s * y, k * y * z + s * x, c + k * z * z),
        )
    )


def rotation_matrix(e: Vector) -> Matrix:
    """Return A_ab of the frame b whose orientation seen from a is e (Eq. 6), shape (3, 3).

    The paper's matrix is printed for unit parameters under the name ``T_(b<-a)``; it maps components in b to
    components in a. Here e is normalised first, so that the drift of an integrator does not scale lengths.
    """
    e0, e1, e2, e3 = e / math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + e[3] * e[3])
    return 2.0 * np.array(
        (
            (e0 * e0 + e1 * e1 - 0.5, e1 * e2 - e0 * e3, e1 * e3 + e0 * e2),
            (e1 * e2 + e0 * e3, e0 * e0 + e2 * e2 - 0.5, e2 * e3 - e0 * e1),
            (e1 * e3 - e0 * e2, e2 * e3 + e0 * e1, e0 * e0 + e3 * e3 - 0.5),
        )
    )


def rotation_matrices(e: Matrix) -> np.ndarray:
    """Return A_ab of many Euler parameters (T, 4), shape (T, 3, 3): see `rotation_matrix`."""
    e0, e1, e2, e3 = (np.asarray(e, dtype=float) / np.linalg.norm(e, axis=1)[:, None]).T
    rows = (
        (e0 * e0 + e1 * e1 - 0.5, e1 * e2 - e0 * e3, e1 * e3 + e0 * e2),
        (e1 * e2 + e0 * e3, e0 * e0 + e2 * e2 - 0.5, e2 * e3 - e0 * e1),
        (e1 * e3 - e0 * e2, e2 * e3 + e0 * e1, e0 * e0 + e3 * e3 - 0.5),
    )
    return np.ascontiguousarray(2.0 * np.moveaxis(np.array(rows), 2, 0))


def euler_parameters_from_matrix(A: Matrix) -> Vector:
    """Return unit Euler parameters of A_ab with e0 >= 0 where e0 is not tiny (inverse of Eq. 6), shape (4,).

    The largest of the four parameters is found first and divides the others, so that no rotation is singular.
    """
    trace = A[0, 0] + A[1, 1] + A[2, 2]
    squares = np.array((trace, A[0, 0], A[1, 1], A[2, 2])) * 2.0 - trace + 1.0  # 4 e_i^2
    i = int(np.argmax(squares))
    e = np.empty(4)
    if i == 0:
        e[:] = squares[0], A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1]
    elif i == 1:
        e[:] = A[2, 1] - A[1, 2], squares[1], A[0, 1] + A[1, 0], A[0, 2] + A[2, 0]
    elif i == 2:
        e[:] = A[0, 2] - A[2, 0], A[0, 1] + A[1, 0], squares[2], A[1, 2] + A[2, 1]
    else:
        e[:] = A[1, 0] - A[0, 1], A[0, 2] + A[2, 0], A[1, 2] + A[2, 1], squares[3]
    e /= np.linalg.norm(e)
    return -e if e[0] < 0 else e


def multiply(e_ab: Vector, e_bc: Vector) -> Vector:
    """Return the Euler parameters e_ac of two successive rotations (Eq. 7 for parameters), shape (4,).

    Also row by row, (n, 4); a single row is combined with all.
    """
    if e_bc.ndim == 2 and len(e_bc) == 1 < len(e_ab):
        b0, b1, b2, b3 = e_bc[0].tolist()
        return e_ab @ np.array(((b0, b1, b2, b3), (-b1, b0, -b3, b2), (-b2, b3, b0, -b1), (-b3, -b2, b1, b0)))
    a0, a1, a2, a3 = e_ab.T
    b0, b1, b2, b3 = e_bc.T
    return np.array(
        (
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
            a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
            a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
        )
    ).T


def euler_parameters_from_matrices(A: Matrix) -> Matrix:
    """Return the Euler parameters (T, 4) of rotation matrices (T, 3, 3): see `euler_parameters_from_matrix`."""
    trace = np.trace(A, axis1=1, axis2=2)
    e = np.empty((len(A), 4, 4))  # 4 e_i e_j
    e[:, 0, 0], e[:, range(1, 4), range(1, 4)] = trace, np.diagonal(A, axis1=1, axis2=2)
    e[:, range(4), range(4)] = 2.0 * np.diagonal(e, axis1=1, axis2=2) - trace[:, None] + 1.0
    for i, (j, k) in enumerate(((2, 1), (0, 2), (1, 0)), start=1):
        e[:, 0, i] = e[:, i, 0] = A[:, j, k] - A[:, k, j]
        e[:, j + 1, k + 1] = e[:, k + 1, j + 1] = A[:, j, k] + A[:, k, j]
    rows = e[np.arange(len(A)), np.diagonal(e, axis1=1, axis2=2).argmax(axis=1)]
    return np.asarray(np.where(rows[:, :1] < 0.0, -rows, rows) / np.linalg.norm(rows, axis=1)[:, None])


def euler_parameter_rates(e_ab: Vector, w_ab_b: Vector) -> Vector:
    """Return de/dt from the angular velocity of b seen from a, in components of b (Nikravesh 1988), shape (4,)."""
    return 0.5 * multiply(e_ab, np.concatenate(([0.0], w_ab_b)))


def rotation_matrix_rate(A_ab: Matrix, w_ab_b: Vector) -> Matrix:
    """Return dA_ab/dt = A_ab w_ab_b~ = w_ab_a~ A_ab (Eq. 8), shape (3, 3).

    Eq. 8 prints the frames of the angular velocity in the opposite order to its matrix.
    """
    return A_ab @ skew(w_ab_b)


def euler_parameters_from_rotation_vector(theta: Vector) -> Vector:
    """Return the Euler parameters of exp(theta~), theta in rad, shape (4,)."""
    angle = math.sqrt(theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2)
    half_sinc = 0.5 - angle**2 / 48 if angle < 1e-4 else math.sin(angle / 2) / angle
    return np.array((math.cos(angle / 2), half_sinc * theta[0], half_sinc * theta[1], half_sinc * theta[2]))


def rotation_vector(e: Vector) -> Vector:
    """Return the rotation vector theta (|theta| <= pi, rad) of Euler parameters e: the logarithm, shape (3,)."""
    e = -e if e[0] < 0 else e
    vector = np.asarray(e[1:], dtype=float)
    sine = float(np.linalg.norm(vector))
    if sine < 1e-8 * abs(e[0]):
        return 2.0 * vector / e[0]
    return 2.0 * math.atan2(sine, e[0]) * vector / sine


def rotation_vectors(e: Matrix) -> Matrix:
    """Return the rotation vectors (T, 3) of many Euler parameters (T, 4): see `rotation_vector`."""
    e = np.where(e[:, :1] < 0.0, -e, e)
    sine = np.maximum(np.linalg.norm(e[:, 1:], axis=1), 1e-300)
    return np.asarray((2.0 * np.arctan2(sine, e[:, 0]) / sine)[:, None] * e[:, 1:])


def moved_to(place: Vector, wrench: np.ndarray) -> np.ndarray:
    """Return wrenches (..., 6) about the origin as those about a place (3,), in the same axes."""
    moment = wrench[..., 3:] - np.cross(place, wrench[..., :3])
    return np.concatenate((wrench[..., :3], moment), axis=-1)


def across(axis: Vector) -> tuple[Vector, Vector]:
    """Return two unit vectors perpendicular to a unit axis and to each other, right-handed with it."""
    first = cross(axis, np.eye(3)[int(np.argmin(abs(axis)))])
    first = first / np.linalg.norm(first)
    return first, cross(axis, first)


def turn_to(direction: Vector) -> Matrix:
    """Return a rotation matrix whose third column is a unit vector; the identity for z."""
    if direction[2] == 1.0:
        return np.eye(3)
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    x = cross(helper, direction)
    x /= np.linalg.norm(x)
    return np.array((x, cross(direction, x), direction)).T.copy()


NOT_A_ROTATION = 1e-8
"""Largest deviation of given axes from a rotation: numbers typed with nine digits pass."""


@runtime_checkable
class Rotation(Protocol):
    """A rotation that has a matrix, such as `scipy.spatial.transform.Rotation`."""

    def as_matrix(self) -> Any:
        """Return A_ab of axes b seen from a, (3, 3)."""
        ...


def is_rotation(given: object) -> TypeGuard[Rotation]:
    """Return whether an orientation keeps that protocol: asked of its class, which is faster than `isinstance`."""
    return hasattr(type(given), "as_matrix")


Orientation = Sequence[float] | Sequence[Sequence[float]] | np.ndarray | Rotation
"""Euler parameters (4,), scalar first; a rotation matrix (3, 3) with the axes as columns; or a rotation of scipy."""


def orientation_parameters(given: object, what: str) -> Vector:
    """Return unit Euler parameters of an orientation; a ModelError names `what` if it is none.

    Parameters
    ----------
    given : array_like, shape (4,) or (3, 3), or Rotation
    what : str
        Name of the orientation in the message.
    """
    value = numbers(given.as_matrix() if is_rotation(given) else given)
    length = math.sqrt(value.dot(value)) if value.shape == (4,) else 0.0
    if 1e-12 < length < math.inf:
        return np.asarray(value / length)
    is_matrix = value.shape == (3, 3) and bool(abs(value.T @ value - np.eye(3)).max() < NOT_A_ROTATION)
    if not is_matrix or np.linalg.det(value) < 0.0:
        raise ModelError(
            f"{what} must be a rotation, not {given!r}: four Euler parameters with a length, scalar first, a "
            "right-handed matrix (3, 3) with unit columns, or a Rotation of scipy. Remedy: kanefe.rotation_about(axis, "
            "angle) or kanefe.euler_angles('XYZ', angles), in rad"
        )
    left, _, right = np.linalg.svd(value)
    return euler_parameters_from_matrix(left @ right)


def rotation_about(axis: str | Sequence[float] | Vector, angle: float) -> Vector:
    """Return the Euler parameters of a rotation about an axis, shape (4,), for ``orientation=`` and ``axes=``.

    Parameters
    ----------
    axis : "x", "y", "z" or array_like, shape (3,)
        Its length does not matter.
    angle : float
        rad.

    Raises
    ------
    ModelError
        If the axis has no length or the angle is not a finite number.

    Examples
    --------
    >>> import kanefe as kf
    >>> import numpy as np
    >>> kf.rotation_about("z", np.pi / 2).round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """
    turn = numbers(angle)
    if turn.shape != () or not np.isfinite(turn):
        raise ModelError(f"the angle of a rotation must be a finite number in rad, not {angle!r}")
    given: Any = AXES.get(axis, axis) if isinstance(axis, str) else axis
    return euler_parameters(given, float(turn))


def euler_angles(order: str, angles: float | Sequence[float] | Vector) -> Vector:
    """Return the Euler parameters of successive rotations about axes, shape (4,), for ``orientation=`` and ``axes=``.

    Parameters
    ----------
    order : str
        One to three axes, as in scipy. Capitals: intrinsic rotations, each about an axis that the previous rotations
        have turned ("ZXZ", "XYZ"); small letters: extrinsic rotations, each about a fixed axis.
    angles : float or array_like, shape (len(order),)
        rad.

    Raises
    ------
    ModelError
        If the order has other letters or both kinds, or the angles are not one finite number for each axis.

    Examples
    --------
    >>> import kanefe as kf
    >>> import numpy as np
    >>> np.allclose(kf.euler_angles("XYZ", (0.1, 0.2, 0.3)), kf.euler_angles("zyx", (0.3, 0.2, 0.1)))
    True
    """
    if (
        not isinstance(order, str)
        or not 1 <= len(order) <= 3
        or not (set(order) <= set("xyz") or set(order) <= set("XYZ"))
    ):
        raise ModelError(
            f"the order of Euler angles is {order!r}. Remedy: up to three of 'X', 'Y', 'Z' about axes that turn along, "
            "or of 'x', 'y', 'z' about axes that stay"
        )
    turns = np.atleast_1d(numbers(angles))
    if turns.shape != (len(order),) or not np.all(np.isfinite(turns)):
        raise ModelError(f"Euler angles {order!r} must be {len(order)} finite numbers in rad, not {angles!r}")
    e = np.array((1.0, 0.0, 0.0, 0.0))
    for axis, turn in zip(order, turns, strict=True):
        one = rotation_about(axis.lower(), float(turn))
        e = multiply(e, one) if order.isupper() else multiply(one, e)
    return e
