"""Orientations as users say them: Euler parameters, a matrix, a rotation of scipy, axis and angle, Euler angles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Vector, euler_parameters, euler_parameters_from_matrix, multiply, numbers

ROUND_OFF = 1e-8
"""How far given axes may be from a rotation: numbers typed with nine digits pass."""

AXES = "xyz"


@runtime_checkable
class Rotation(Protocol):
    """A rotation that has a matrix, such as `scipy.spatial.transform.Rotation`."""

    def as_matrix(self) -> Any:
        """Return A_ab of axes b seen from a, (3, 3)."""
        ...


Orientation = Sequence[float] | Sequence[Sequence[float]] | np.ndarray | Rotation
"""Euler parameters (4,), scalar first; a rotation matrix (3, 3), its columns the axes; or a rotation of scipy."""


def orientation_parameters(given: object, what: str) -> Vector:
    """Return unit Euler parameters of an orientation; a ModelError names what it is.

    Parameters
    ----------
    given : array_like, shape (4,) or (3, 3), or Rotation
    what : str
        For the message.
    """
    value = numbers(given.as_matrix() if isinstance(given, Rotation) else given)
    if value.shape == (4,) and np.all(np.isfinite(value)) and np.linalg.norm(value) > 1e-12:
        return np.asarray(value / np.linalg.norm(value))
    is_matrix = value.shape == (3, 3) and bool(abs(value.T @ value - np.eye(3)).max() < ROUND_OFF)
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
        If the axis has no length or the angle is no finite number.

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
    named = isinstance(axis, str) and axis in AXES and len(axis) == 1
    direction: Any = np.eye(3)[AXES.index(str(axis))] if named else axis
    return euler_parameters(direction, float(turn))


def euler_angles(order: str, angles: float | Sequence[float] | Vector) -> Vector:
    """Return the Euler parameters of successive rotations about axes, shape (4,), for ``orientation=`` and ``axes=``.

    Parameters
    ----------
    order : str
        One to three axes. Capitals: each about the axis as the rotations before have turned it ("ZXZ", "XYZ"); small
        letters: each about the axis that stays. As scipy says it.
    angles : float or array_like, shape (len(order),)
        rad.

    Raises
    ------
    ModelError
        If the order has other letters or both kinds, or the angles are not as many finite numbers.

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
