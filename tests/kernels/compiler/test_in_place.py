"""Named tuples that kernels read in the places of their calls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from kanefe.kernels.compiler._numba import kernel
from kanefe.kernels.compiler.arrays import IntegerRows, RealRows, Reals, Values
from kanefe.kernels.compiler.entries import LATER, entry
from kanefe.kernels.compiler.signatures import COMPLEX, REAL, in_place, signature_of


class Inner(NamedTuple):
    rows: IntegerRows
    is_on: bool


@in_place
class Whole(NamedTuple):
    weights: Reals
    inner: Inner
    count: int


in_place(Inner)


class Given(NamedTuple):
    whole: Whole
    factor: float


@kernel
def weighed(whole: Whole, i: int) -> float:
    return whole.weights[i] * whole.inner.rows[1, i] + whole.count


@entry(REAL, COMPLEX)
def weigh(before: RealRows, given: Given, found: Values) -> int:
    whole = given.whole
    for i in range(len(whole.weights)):
        found[i] = given.factor * weighed(whole, i) + before[0, 0]
    return whole.inner.rows.shape[1] if whole.inner.is_on else -1


@pytest.mark.parametrize("kind", [float, complex])
def test_a_tuple_is_read_where_it_is(kind: type) -> None:
    rows, found = np.arange(6).reshape(2, 3), np.zeros(3, dtype=kind)
    whole = Whole(np.array((1.0, 2.0, 3.0)), Inner(rows, True), 7)
    bound = weigh.bound(np.full((1, 1), 0.5), LATER, found, is_complex=kind is complex)
    call = bound.prepared(Given(whole, 2.0))
    assert call() == 3
    assert found.tolist() == [20.5, 30.5, 44.5]
    call.give(Given(whole._replace(inner=Inner(rows[:, :2].copy(), False), count=0, weights=np.ones(2)), 1.0))
    assert call() == -1
    assert found.tolist() == [3.5, 4.5, 44.5]


def test_a_float_is_not_among_the_places() -> None:
    Wrong = in_place(NamedTuple("Wrong", [("x", float)]))

    def function(wrong: float) -> None:
        pass

    function.__annotations__["wrong"] = Wrong
    with pytest.raises(TypeError, match="Wrong is read in place: a float in it is not among the places"):
        signature_of(function, REAL)
