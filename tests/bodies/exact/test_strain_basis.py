"""Functions of strains: what they span, where they break, and what is refused."""

import numpy as np
import pytest
from scipy.interpolate import BSpline as Scipys

import kanefe as kf

X = np.linspace(0.0, 1.0, 41)
SPLINES = [
    kf.BSpline(0, 3),
    kf.BSpline(1, 1),
    kf.BSpline(2, 4),
    kf.BSpline(3, (0.2, 0.2, 0.7)),
    kf.BSpline(2, (0.5,) * 3),
]


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_splines_are_a_partition_of_unity_and_not_negative(basis):
    values = basis.values(X)
    assert values.shape == (len(X), basis.count)
    np.testing.assert_allclose(values.sum(axis=1), 1.0, rtol=0, atol=1e-15 * basis.count)
    assert values.min() >= 0.0


@pytest.mark.parametrize("basis", SPLINES, ids=repr)
def test_splines_are_scipys(basis):
    knots = np.concatenate((np.zeros(basis.degree + 1), _inner(basis), np.ones(basis.degree + 1)))
    x = X[:-1]  # scipy has no value of the last function at the end
    expected = Scipys.design_matrix(x, knots, basis.degree).toarray()
    np.testing.assert_allclose(basis.values(x), expected, rtol=0, atol=1e-14)


def _inner(basis):
    if isinstance(basis.knots, int):
        return np.linspace(0.0, 1.0, basis.knots + 1)[1:-1]
    return np.array(basis.knots)


def test_polynomials_are_orthogonal_and_have_no_breaks():
    basis = kf.Legendre(7)
    x, w = np.polynomial.legendre.leggauss(7)
    values = basis.values(0.5 * (x + 1.0))
    gram = values.T @ (0.5 * w[:, None] * values)
    np.testing.assert_allclose(gram, np.diag(1.0 / (2.0 * np.arange(7) + 1.0)), rtol=0, atol=1e-15)
    assert (basis.degree, len(basis.breaks)) == (6, 0)


def test_knots_are_breaks_once():
    np.testing.assert_array_equal(kf.BSpline(3, (0.2, 0.2, 0.7)).breaks, (0.2, 0.7))
    np.testing.assert_allclose(kf.BSpline(1, 4).breaks, (0.25, 0.5, 0.75), rtol=0, atol=1e-16)
    assert kf.BSpline(3, (0.2, 0.2, 0.7)).count == 7


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.Legendre(0), "at least 1"),
        (lambda: kf.Legendre(2.0), "count = 2.0"),
        (lambda: kf.Legendre(True), "count = True"),
        (lambda: kf.BSpline(-1, 3), "degree = -1"),
        (lambda: kf.BSpline(1.5, 3), "degree = 1.5"),
        (lambda: kf.BSpline(2, 0), "at least 1 is needed"),
        (lambda: kf.BSpline(2, (0.5, 0.2)), "in order and within"),
        (lambda: kf.BSpline(2, (0.0, 0.2)), "in order and within"),
        (lambda: kf.BSpline(2, (0.3, float("nan"))), "in order and within|nan"),
        (lambda: kf.BSpline(1, (0.5,) * 3), "given 3 times, more than degree"),
    ],
)
def test_bad_functions_are_refused(make, message):
    with pytest.raises(kf.ModelError, match=message):
        make()
