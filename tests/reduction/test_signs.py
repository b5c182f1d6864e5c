"""Signs of modes by a rule."""

from __future__ import annotations

import numpy as np

from kanefe.reduction.signs import with_fixed_signs


def test_signs_do_not_depend_on_those_given() -> None:
    modes = np.linalg.qr(np.random.default_rng(3).standard_normal((50, 6)))[0]
    squares = np.arange(1.0, 7.0)
    flipped = modes * np.array([1, -1, -1, 1, -1, 1])
    found = with_fixed_signs(modes, squares)
    assert np.array_equal(found, with_fixed_signs(flipped, squares))
    assert np.array_equal(np.abs(found), np.abs(modes))


def test_modes_of_one_frequency_are_turned_alike() -> None:
    modes = np.linalg.qr(np.random.default_rng(3).standard_normal((50, 4)))[0]
    squares = np.array([1.0, 2.0, 2.0 * (1.0 + 1e-12), 3.0])
    turn = np.eye(4)
    turn[1:3, 1:3] = [[0.6, -0.8], [0.8, 0.6]]
    found = with_fixed_signs(modes, squares)
    np.testing.assert_allclose(with_fixed_signs(modes @ turn, squares), found, rtol=0.0, atol=1e-14)  # round-off
    np.testing.assert_allclose(found.T @ found, np.eye(4), rtol=0.0, atol=1e-14)


def test_no_modes() -> None:
    assert with_fixed_signs(np.zeros((5, 0)), np.zeros(0)).shape == (5, 0)
