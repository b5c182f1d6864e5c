"""Residuals of static shapes and modes: from K and M alone, kept with the body, and told where they are large."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
import scenes
from kanefe.errors import AccuracyWarning
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.residuals import largest_residual

ENDS = {"root": "clamped", "tip": "rigid"}


class _Worse:
    """Factors whose solutions are off by a part of themselves that changes from row to row."""

    def __init__(self, matrix, part):
        self._factors, self._part = splu_factorise(matrix), part

    def solve(self, b):
        x = self._factors.solve(b)
        return x + self._part * (x.T * np.cos(np.arange(len(x)))).T


def body(reduction, part=0.0):
    def factorise(matrix, *, definite=True):
        return _Worse(matrix, part)

    return kf.flexible_body(scenes.lattice_model(1, interior=12), ENDS, reduction=reduction, factorise=factorise)


def residuals(made):
    return made.provenance["reduction"]["residuals"]


@pytest.mark.parametrize(
    ("reduction", "names"),
    [
        (kf.CraigBampton(modes=3), {"constraint modes", "normal modes"}),
        (kf.CraigBampton(modes=3, loads=("gravity",)), {"constraint modes", "normal modes", "load cases"}),
        (kf.FreeInterface(modes=3), {"constraint modes", "normal modes", "attachment modes"}),
    ],
    ids=["modes", "loads", "free"],
)
def test_they_are_kept_with_the_body(reduction, names):
    found = residuals(body(reduction))
    assert set(found) == names
    assert max(found.values()) < 1e-10  # round-off


def test_a_solver_that_is_off_is_told():
    with pytest.warns(AccuracyWarning, match=r"constraint mode \d+ leaves .* unbalanced .* Remedy"):
        found = residuals(body(kf.CraigBampton(modes=3), part=1e-4))
    assert 1e-6 < found["constraint modes"] < 1.0


def test_the_worst_column_is_named():
    asked = np.array([[1.0, 0.0, 3.0], [0.0, 0.0, 4.0]])
    reached = asked + np.array([[0.0, 0.0, 0.0], [1e-7, 0.0, 5e-3]])
    with pytest.warns(AccuracyWarning, match=r"^mode 3 leaves 1.0e-03 of its forces"):
        assert largest_residual("mode", reached, asked) == pytest.approx(1e-3)
    assert largest_residual("mode", reached[:, :2], asked[:, :2]) == pytest.approx(1e-7)
    with pytest.warns(AccuracyWarning, match="nan"):
        largest_residual("mode", np.full((2, 1), np.nan), asked[:, :1])


def test_forces_in_stiff_directions_count_by_what_they_move():
    """K = diag(1, 1e10): 1e-4 along the second moves 1e-14, with an energy of 1e-18; along the first it is told."""
    K, solution = np.array([1.0, 1e10]), np.array([[1.0], [0.0]])
    asked = K[:, None] * solution
    for residual, is_told in (((0.0, 1e-4), False), ((1e-4, 0.0), True)):
        reached = asked + np.array([residual]).T
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            found = largest_residual("mode", reached, asked, moved=(solution, lambda f: f / K[:, None]))
        assert bool(told) is is_told
        assert found == pytest.approx(1e-4 if is_told else 1e-9)
