"""Vectors and matrices with operators: against numpy, and compiled against plain."""

import numpy as np
import pytest

from kanefe.kernels.values.tensors import (
    Matrix,
    Skew,
    Symmetric,
    Value,
    Vector,
    congruent,
    contract,
    cross,
    diagonal,
    dot,
    outer,
    rotation,
    skew,
    square,
    symmetric,
    turned_about_z,
)

ROUND_OFF = 1e-14  # of sums of nine products of numbers near 1


def array(value: Value) -> np.ndarray:
    """Return a value as numpy has it."""
    return np.array([*(value if isinstance(value, Vector) else value.full)]).reshape(
        3 if isinstance(value, Vector) else (3, 3)
    )


@pytest.fixture(params=[float, complex])
def values(request: pytest.FixtureRequest) -> tuple[Vector, Vector, Matrix, Matrix, Symmetric]:
    """Return two vectors, two matrices, and a symmetric matrix far from singular, of real or of complex numbers."""
    rng = np.random.default_rng(1)
    given = rng.standard_normal(30) + (1j * rng.standard_normal(30) if request.param is complex else 0.0)
    A, S = given[6:15].reshape(3, 3), given[15:24].reshape(3, 3)
    S = S @ S.T + 10.0 * np.eye(3)
    kept = S[np.triu_indices(3)]
    return Vector(*given[:3]), Vector(*given[3:6]), Matrix(*A.ravel()), Matrix(*given[21:30]), Symmetric(*kept)


def test_products_and_sums_are_those_of_numpy(values: tuple[Vector, Vector, Matrix, Matrix, Symmetric]) -> None:
    a, b, A, B, S = values
    x, y, P, Q, T = map(array, values)
    rotated = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    for found, wanted in (
        (a + 2.0 * b - a * 3.0, -2.0 * x + 2.0 * y),
        (-A + B * 2.0, 2.0 * Q - P),
        (A @ b, P @ y),
        (A @ B, P @ Q),
        (S @ a, T @ x),
        (S @ A, T @ P),
        (A @ S, P @ T),
        (A.T, P.T),
        (A.x, P[:, 0]),
        (A.y, P[:, 1]),
        (A.z, P[:, 2]),
        (S.inverse, np.linalg.inv(T)),
        (outer(a, b), np.outer(x, y)),
        (square(a, 3.0 * a), 3.0 * np.outer(x, x)),
        (symmetric(S.full), T),
        (congruent(A, S), P @ T @ P.T),
        (diagonal(a.x), x[0] * np.eye(3)),
        (cross(a, b), np.cross(x, y)),
        (skew(a) @ b, np.cross(x, y)),
        (skew(a) @ A, np.cross(x, P.T).T),
        (A @ skew(a), P @ array(skew(a))),
        (skew(a) @ skew(b), array(skew(a)) @ array(skew(b))),
        (turned_about_z(A, 0.6, 0.8), P @ rotated),
    ):
        np.testing.assert_allclose(array(found), wanted, rtol=ROUND_OFF, atol=20.0 * ROUND_OFF)
    assert dot(a, b) == pytest.approx(np.sum(x * y), rel=ROUND_OFF)  # without conjugation
    assert contract(S, square(a, a)) == pytest.approx(np.sum(T * np.outer(x, x)), rel=10.0 * ROUND_OFF)
    assert S.trace == pytest.approx(np.trace(T), rel=ROUND_OFF)


def test_euler_parameters_are_normalised() -> None:
    R = array(rotation(0.3, -1.2, 0.4, 2.0))
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=ROUND_OFF)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=ROUND_OFF)
    np.testing.assert_allclose(R, array(rotation(-0.6, 2.4, -0.8, -4.0)), atol=ROUND_OFF)


def test_a_number_of_numpy_times_a_value_is_a_value() -> None:
    assert isinstance(np.float64(2.0) * Vector(1.0, 2.0, 3.0), Vector)
    assert isinstance(Skew(1.0, 2.0, 3.0) * np.complex128(1j), Skew)


@pytest.mark.parametrize(
    ("mistake", "told"),
    [
        (lambda v, S: v + S, r"'Vector' and 'Symmetric'"),
        (lambda v, S: S - v, r"'Symmetric' and 'Vector'"),
        (lambda v, S: v * v, r"'Vector' and 'Vector'"),
        (lambda v, S: S @ 2.0, r"'Symmetric' and 'float'"),
        (lambda v, S: cross(v, S), "a Vector is wanted, not a Symmetric"),
        (lambda v, S: Vector(1.0, 2.0), "a Vector has 3 numbers, not 2"),
    ],
)
def test_what_does_not_go_together_is_refused(mistake, told: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(TypeError, match=told):
        mistake(Vector(1.0, 2.0, 3.0), Symmetric(1.0, 0.0, 0.0, 1.0, 0.0, 1.0))
