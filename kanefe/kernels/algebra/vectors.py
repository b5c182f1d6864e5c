"""3-vectors and 3 x 3 matrices as tuples, and their places in the rows of an array.

Rows are read and written by number, never through a view: making views costs more than what is done with them.
A matrix is nine numbers, row by row; a symmetric one six: xx, xy, xz, yy, yz, zz.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from kanefe.kernels.compiler._numba import inlined
from kanefe.kernels.values.tensors import Matrix, Vector

Numbers = tuple[Any, ...]


@inlined
def as_vector(a: Numbers) -> Vector:
    """Return three numbers as a value."""
    return Vector(a[0], a[1], a[2])


@inlined
def as_matrix(A: Numbers) -> Matrix:
    """Return nine numbers as a value."""
    return Matrix(A[0], A[1], A[2], A[3], A[4], A[5], A[6], A[7], A[8])


@inlined
def nine_of(A: Matrix) -> Numbers:
    """Return the numbers of a matrix, row by row."""
    x, y, z = A.x, A.y, A.z
    return x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z


@inlined
def numbers_of(a: Vector) -> Numbers:
    """Return a value as three numbers."""
    return a.x, a.y, a.z


@inlined
def vector(array: np.ndarray, i: int, at: int) -> Numbers:
    """Read a vector in row i of an array."""
    return array[i, at], array[i, at + 1], array[i, at + 2]


@inlined
def matrix(array: np.ndarray, i: int, at: int) -> Numbers:
    """Read a matrix in row i of an array."""
    return (
        array[i, at],
        array[i, at + 1],
        array[i, at + 2],
        array[i, at + 3],
        array[i, at + 4],
        array[i, at + 5],
        array[i, at + 6],
        array[i, at + 7],
        array[i, at + 8],
    )


@inlined
def symmetric(array: np.ndarray, i: int, at: int) -> Numbers:
    """Read a symmetric matrix in row i of an array."""
    return array[i, at], array[i, at + 1], array[i, at + 2], array[i, at + 3], array[i, at + 4], array[i, at + 5]


@inlined
def three(x: np.ndarray, at: int) -> Numbers:
    """Read three numbers of a list."""
    return x[at], x[at + 1], x[at + 2]


@inlined
def six(x: np.ndarray, at: int) -> Numbers:
    """Read six numbers of a list."""
    return x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5]


@inlined
def put_three(x: np.ndarray, at: int, values: Numbers) -> None:
    """Write three numbers of a list."""
    x[at], x[at + 1], x[at + 2] = values[0], values[1], values[2]


@inlined
def put(array: np.ndarray, i: int, at: int, values: Numbers) -> None:
    """Write a vector."""
    array[i, at] = values[0]
    array[i, at + 1] = values[1]
    array[i, at + 2] = values[2]


@inlined
def put_matrix(array: np.ndarray, i: int, at: int, values: Numbers) -> None:
    """Write a matrix."""
    array[i, at] = values[0]
    array[i, at + 1] = values[1]
    array[i, at + 2] = values[2]
    array[i, at + 3] = values[3]
    array[i, at + 4] = values[4]
    array[i, at + 5] = values[5]
    array[i, at + 6] = values[6]
    array[i, at + 7] = values[7]
    array[i, at + 8] = values[8]


@inlined
def accumulate(array: np.ndarray, i: int, at: int, values: Numbers) -> None:
    """Add a vector."""
    array[i, at] += values[0]
    array[i, at + 1] += values[1]
    array[i, at + 2] += values[2]


@inlined
def plus(a: Numbers, b: Numbers) -> Numbers:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inlined
def minus(a: Numbers, b: Numbers) -> Numbers:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@inlined
def times(s: Any, a: Numbers) -> Numbers:
    """Return s a."""
    return s * a[0], s * a[1], s * a[2]


@inlined
def dot(a: Numbers, b: Numbers) -> Any:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def norm(a: Numbers) -> Any:
    """Return the length of a."""
    return np.sqrt(dot(a, a))


@inlined
def cross(a: Numbers, b: Numbers) -> Numbers:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def rotated(R: Numbers, a: Numbers) -> Numbers:
    """Return R a."""
    return (
        R[0] * a[0] + R[1] * a[1] + R[2] * a[2],
        R[3] * a[0] + R[4] * a[1] + R[5] * a[2],
        R[6] * a[0] + R[7] * a[1] + R[8] * a[2],
    )


@inlined
def rotated_back(R: Numbers, a: Numbers) -> Numbers:
    """Return R^T a."""
    return (
        R[0] * a[0] + R[3] * a[1] + R[6] * a[2],
        R[1] * a[0] + R[4] * a[1] + R[7] * a[2],
        R[2] * a[0] + R[5] * a[1] + R[8] * a[2],
    )


@inlined
def product(A: Numbers, B: Numbers) -> Numbers:
    """Return A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6], A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6], A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6], A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )  # fmt: skip


@inlined
def transposed(A: Numbers) -> Numbers:
    """Return A^T."""
    return A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]


@inlined
def full(S: Numbers) -> Numbers:
    """Return the nine numbers of a symmetric matrix."""
    return S[0], S[1], S[2], S[1], S[3], S[4], S[2], S[4], S[5]


@inlined
def upper(A: Numbers) -> Numbers:
    """Return the six numbers of a matrix that is symmetric."""
    return A[0], A[1], A[2], A[4], A[5], A[8]


@inlined
def symmetric_times(S: Numbers, a: Numbers) -> Numbers:
    """Return S a."""
    return (
        S[0] * a[0] + S[1] * a[1] + S[2] * a[2],
        S[1] * a[0] + S[3] * a[1] + S[4] * a[2],
        S[2] * a[0] + S[4] * a[1] + S[5] * a[2],
    )


@inlined
def congruent(R: Numbers, S: Numbers) -> Numbers:
    """Return R S R^T of a symmetric S."""
    x = symmetric_times(S, (R[0], R[1], R[2]))
    y = symmetric_times(S, (R[3], R[4], R[5]))
    z = symmetric_times(S, (R[6], R[7], R[8]))
    return (
        R[0] * x[0] + R[1] * x[1] + R[2] * x[2],
        R[0] * y[0] + R[1] * y[1] + R[2] * y[2],
        R[0] * z[0] + R[1] * z[1] + R[2] * z[2],
        R[3] * y[0] + R[4] * y[1] + R[5] * y[2],
        R[3] * z[0] + R[4] * z[1] + R[5] * z[2],
        R[6] * z[0] + R[7] * z[1] + R[8] * z[2],
    )


@inlined
def skew_product(a: Numbers, B: Numbers) -> Numbers:
    """Return a~ B: the cross product of a with every column."""
    return (
        a[1] * B[6] - a[2] * B[3], a[1] * B[7] - a[2] * B[4], a[1] * B[8] - a[2] * B[5],
        a[2] * B[0] - a[0] * B[6], a[2] * B[1] - a[0] * B[7], a[2] * B[2] - a[0] * B[8],
        a[0] * B[3] - a[1] * B[0], a[0] * B[4] - a[1] * B[1], a[0] * B[5] - a[1] * B[2],
    )  # fmt: skip


@inlined
def symmetric_inverse(S: Numbers) -> Numbers:
    """Return S^-1 of a symmetric matrix by its cofactors; infinite where S is singular."""
    c0 = S[3] * S[5] - S[4] * S[4]
    c1 = S[2] * S[4] - S[1] * S[5]
    c2 = S[1] * S[4] - S[2] * S[3]
    d = 1.0 / (S[0] * c0 + S[1] * c1 + S[2] * c2)
    return (
        d * c0, d * c1, d * c2,
        d * (S[0] * S[5] - S[2] * S[2]), d * (S[1] * S[2] - S[0] * S[4]), d * (S[0] * S[3] - S[1] * S[1]),
    )  # fmt: skip


@inlined
def turned_about_z(A: Numbers, angle: Any) -> Numbers:
    """Return A Rz(angle)."""
    c, s = np.cos(angle), np.sin(angle)
    return (
        c * A[0] + s * A[1], c * A[1] - s * A[0], A[2],
        c * A[3] + s * A[4], c * A[4] - s * A[3], A[5],
        c * A[6] + s * A[7], c * A[7] - s * A[6], A[8],
    )  # fmt: skip


@inlined
def rotation(q: np.ndarray, at: int) -> Numbers:
    """Return the rotation matrix of Euler parameters, which are normalised first (Eq. 6)."""
    e0, e1, e2, e3 = q[at], q[at + 1], q[at + 2], q[at + 3]
    s = 2.0 / (e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3)
    return (
        1.0 - s * (e2 * e2 + e3 * e3), s * (e1 * e2 - e0 * e3), s * (e1 * e3 + e0 * e2),
        s * (e1 * e2 + e0 * e3), 1.0 - s * (e1 * e1 + e3 * e3), s * (e2 * e3 - e0 * e1),
        s * (e1 * e3 - e0 * e2), s * (e2 * e3 + e0 * e1), 1.0 - s * (e1 * e1 + e2 * e2),
    )  # fmt: skip


@inlined
def copy(source: np.ndarray, target: np.ndarray) -> None:
    """Copy numbers one by one: arrays cannot be assigned to slices where no memory is to be had."""
    for i in range(len(source)):
        target[i] = source[i]
