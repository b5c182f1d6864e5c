"""Explicit methods prove themselves: order conditions over rooted trees, rates of convergence, and of dense output."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import DOP853, RK45

from kanefe.integrate.methods.compiled import Compiled
from kanefe.integrate.methods.explicit import tableau
from kanefe.integrate.methods.table import METHODS
from kanefe.integrate.run import integrate
from run_scenes import thrown_pendulum

EXPLICIT = [name for name, method in METHODS.items() if method.is_explicit]
CONTROLLED = [name for name in EXPLICIT if METHODS[name].has_error_control]

ROUND_OFF = 1e-13
"""Of sums of some twenty products of coefficients below a hundred."""

DENSE_ROUND_OFF = 3e-11
"""Of the dense output: its weights may reach a thousand."""

Tree = tuple["Tree", ...]


class Coefficients(NamedTuple):
    """What a kernel reads: stages with the rates at the end and those of the dense output, errors, dense output."""

    nodes: np.ndarray
    A: np.ndarray
    b: np.ndarray
    end: int
    errors: np.ndarray
    dense: np.ndarray
    order_of_error: int


def coefficients(name: str) -> Coefficients:
    stepper = METHODS[name].stepper
    assert isinstance(stepper, Compiled)
    kernels = stepper.load()
    of, table = kernels.whole(thrown_pendulum()), kernels.table
    end, estimates = of["stages"], of["estimates"]
    count = end + 1 + of["extra"]
    A, further = np.zeros((count, count)), np.zeros((len(table) - count, count))
    A[:, : table.shape[1] - 1] = table[:count, 1 : 1 + count]
    further[:, : table.shape[1] - 1] = table[count:, 1 : 1 + count]
    assert not np.any(table[:, 1 + count :])
    errors, dense = further[:estimates], further[estimates:]
    assert len(dense) == of["dense"]
    return Coefficients(table[:count, 0], A, A[end], end, errors, dense, of["order"])


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """Return the rooted trees with so many nodes: a tree is the tuple of what hangs on its root."""
    return tuple({tuple(sorted(forest, key=repr)) for forest in forests(order - 1, order - 1)})


def forests(nodes: int, largest: int) -> Iterator[Tree]:
    if nodes == 0:
        yield ()
    for size in range(min(nodes, largest), 0, -1):
        for tree in trees(size):
            for rest in forests(nodes - size, size):
                yield (tree, *rest)


def size_of(tree: Tree) -> int:
    return 1 + sum(map(size_of, tree))


def density(tree: Tree) -> float:
    return float(size_of(tree) * np.prod([density(branch) for branch in tree]))


def weights(found: Coefficients, tree: Tree) -> np.ndarray:
    """Return the derivatives of the stages that belong to a tree (Butcher's elementary weights)."""
    value = np.ones(len(found.A))
    for branch in tree:
        value = value * (found.A @ weights(found, branch))
    return value


def test_there_are_as_many_trees_as_is_known() -> None:
    assert [len(trees(order)) for order in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@pytest.mark.parametrize("name", EXPLICIT)
def test_the_coefficients_have_the_order_that_is_told_and_no_more(name: str) -> None:
    found, order = coefficients(name), METHODS[name].order
    np.testing.assert_allclose(found.A.sum(axis=1), found.nodes, atol=ROUND_OFF)
    assert not np.any(np.triu(found.A))
    misses = [
        max(abs(found.b @ weights(found, tree) - 1.0 / density(tree)) for tree in trees(size))
        for size in range(1, order + 2)
    ]
    assert max(misses[:-1]) < ROUND_OFF
    assert misses[-1] > 1e3 * ROUND_OFF


@pytest.mark.parametrize("name", CONTROLLED)
def test_the_estimate_of_the_error_has_the_order_that_steps_are_chosen_by(name: str) -> None:
    found = coefficients(name)
    first = []
    for error in found.errors:
        size = 1
        while max(abs(error @ weights(found, tree)) for tree in trees(size)) < ROUND_OFF:
            size += 1
        first.append(size)
    # of two estimates the size is that of the first, squared, over the second
    assert (first[0] if len(first) == 1 else 2 * first[0] - first[1]) == found.order_of_error


@pytest.mark.parametrize("name", EXPLICIT)
def test_the_dense_output_is_of_one_order_less(name: str) -> None:
    found, x = coefficients(name), np.linspace(0.0, 1.0, 11)
    misses = []
    for size in range(1, METHODS[name].order + 1):
        misses.append(0.0)
        for tree in trees(size):
            phi = weights(found, tree)
            step, start, end = found.b @ phi, phi[0], phi[found.end]
            rest = np.zeros_like(x)
            for row in range(len(found.dense) - 1, -1, -1):
                rest = (rest + found.dense[row] @ phi) * ((1.0 - x) if row % 2 == 0 else x)
            y = x * (step + (1.0 - x) * (start - step + (2.0 * step - end - start + rest) * x))
            misses[-1] = max(misses[-1], abs(y - x**size / density(tree)).max())
    assert max(misses[:-1]) < DENSE_ROUND_OFF
    assert misses[-1] > 1e2 * DENSE_ROUND_OFF


swing = cache(thrown_pendulum)
SPAN = 2.0
TIMES = np.linspace(0.0, SPAN, 78)[1:]
"""Most of them within steps."""


@cache
def exact() -> np.ndarray:
    return integrate(swing(), (0.0, SPAN), method="dop853", rtol=1e-13, output_times=TIMES).coordinates


def errors(name: str, steps: int) -> np.ndarray:
    """Return the errors at the end and within the steps."""
    run = integrate(swing(), (0.0, SPAN), method=name, step=SPAN / steps, output_times=TIMES)
    found = abs(run.coordinates - exact()).max(axis=1)
    return np.array((found[-1], found.max()))


@pytest.mark.parametrize("name", EXPLICIT)
def test_errors_fall_with_the_order_at_the_ends_of_steps_and_within(name: str) -> None:
    order = METHODS[name].order
    # so many that errors are between 1e-9 and 1e-4: in the range of the rate, and above those of the reference
    steps = {2: 800, 3: 300, 4: 100, 5: 60, 6: 40, 7: 30}.get(order, 20)
    coarse, fine = errors(name, steps), errors(name, 2 * steps)
    rates = np.log2(coarse / fine)
    assert rates[0] > order - 0.6
    # one order less, in one step in place of the sum of many: the rate is that of the method, reached from below
    assert rates[1] > order - 1.0
    assert coarse[1] < 1e-4


@pytest.mark.parametrize("name", CONTROLLED)
def test_tighter_tolerances_bring_smaller_errors(name: str) -> None:
    found = []
    for rtol in (1e-5, 1e-7, 1e-9):
        run = integrate(swing(), (0.0, SPAN), method=name, rtol=rtol, output_times=TIMES)
        found.append(abs(run.coordinates - exact()).max())
    assert found[0] > 5.0 * found[1] > 25.0 * found[2]
    assert found[2] < 1e-6  # a thousand times rtol, as at the other tolerances


def test_coefficients_are_those_of_scipy() -> None:
    theirs, ours = DOP853, METHODS["dop853"].stepper.load().table
    assert (
        ours.tobytes() == table_of(theirs, [theirs.E5, theirs.E3], theirs.D, theirs.A_EXTRA, theirs.C_EXTRA).tobytes()
    )
    theirs, ours = RK45, METHODS["dopri5"].stepper.load().table
    assert ours.tobytes() == table_of(theirs, [theirs.E], [theirs.P[:, 3]]).tobytes()


def table_of(method: Any, errors: Any, dense: Any, extra: Any = (), extra_c: Any = ()) -> np.ndarray:
    rest = {"extra": extra, "extra_c": extra_c, "dense": dense}
    return tableau(method.A, method.B, method.C, order=1, errors=errors, **rest).table
