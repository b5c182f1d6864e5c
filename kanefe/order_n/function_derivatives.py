"""Derivatives of rates where compiled functions of the user look at the state: by differences of these alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector

if TYPE_CHECKING:
    from kanefe.order_n.evaluated import Evaluated
    from kanefe.order_n.rates_kernel import RatesKernel

NOT_IMPLICIT = 0.0, 0.0


def add_functions(
    found: Matrix, route: Evaluated, kernel: RatesKernel, t: float, y: Vector, directions: Matrix, reaches: Vector
) -> bool:
    """Add to derivatives of dy/dt along directions, (k, state) both, what the values of functions change of them.

    Return whether all is finite. `reaches`: how far to go along each direction. Rates are linear in what loads give,
    but for friction.
    """
    fill = getattr(route.fill, "__wrapped__", route.fill)  # of machine code the function behind it
    at = route.inputs.begun(route.parts(y)[2]).copy()
    values = np.tile(at, (2, len(directions), 1))
    for i, step in enumerate(reaches[:, None] * directions):
        fill(t, y + step, values[0, i])
        fill(t, y - step, values[1, i])
    fill(t, y, at)
    slopes = (values[0] - values[1]) / (2.0 * reaches[:, None])
    acting = np.flatnonzero(slopes.any(axis=0))
    if len(acting):
        steps = np.maximum(np.abs(at[acting]), np.abs(at).max() or 1.0)
        moved = np.vstack((at, at + steps[:, None] * np.eye(len(at))[acting]))
        rates = _rates_with(route, kernel, t, y, moved)
        found += slopes[:, acting] @ ((rates[1:] - rates[0]) / steps[:, None])
    return bool(np.isfinite(found).all())


def _rates_with(route: Evaluated, kernel: RatesKernel, t: float, y: Vector, values: Matrix) -> Matrix:
    """Return dy/dt while loads have given values, one set a row."""
    call = kernel.take()
    call.at[:], call.drives[:] = y, route.drives(t)
    found = np.empty((len(values), len(y)))
    for row, own in zip(found, values, strict=True):
        call.inputs[:] = own
        call(t, False, NOT_IMPLICIT)
        row[:] = call.slope
    call.inputs[:] = route.inputs.constants
    kernel.give_back(call)
    return found
