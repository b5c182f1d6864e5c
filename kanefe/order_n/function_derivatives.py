"""Derivatives of rates where functions of the user look at the state: by differences of these alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.order_n.read_state import ReadState

if TYPE_CHECKING:
    from kanefe.order_n.evaluated import Evaluated
    from kanefe.order_n.rates_kernel import RatesKernel
    from kanefe.tree.scene_state import SceneState


def add_functions(
    found: Matrix,
    route: Evaluated,
    kernel: RatesKernel,
    t: float,
    y: Vector,
    at: np.ndarray,
    directions: Matrix,
    reaches: Vector,
) -> bool:
    """Add to derivatives of dy/dt along directions, (k, state) both, what the values of functions change of them.

    Return whether all is finite. `at`: the values at the state; `reaches`: how far to go along each direction. Rates
    are linear in what loads give, but for friction.
    """
    slopes = (_compiled_slopes if route.is_autonomous else _python_slopes)(route, t, y, directions, reaches)
    acting = np.flatnonzero(slopes.any(axis=0))
    if len(acting):
        steps = np.maximum(np.abs(at[acting]), np.abs(at).max() or 1.0)
        moved = np.vstack((at, at + steps[:, None] * np.eye(len(at))[acting]))
        rates = _rates_with(route, kernel, t, y, moved)
        found += slopes[:, acting] @ ((rates[1:] - rates[0]) / steps[:, None])
    return bool(np.isfinite(found).all())


def calls_for_derivatives(route: Evaluated, t: float, y: Vector, directions: Matrix) -> int:
    """Return how many calls of functions in Python derivatives along directions take at a state."""
    count = 1  # for the values at the state
    for _, load in route.inputs.of_state:
        state = ReadState(route.state(t, y))
        load.value(t, state)
        count += 1 + 2 * len(state.moved_by(directions))
    return count + 2 * len(directions) * len(route.inputs.between)


def _compiled_slopes(route: Evaluated, t: float, y: Vector, directions: Matrix, reaches: Vector) -> Matrix:
    """Return the derivatives of the values of functions that are compiled, (k, values)."""
    fill = getattr(route.fill, "__wrapped__", route.fill)  # of machine code the function behind it
    values = np.tile(route.inputs.begun(route.parts(y)[2]), (2, len(directions), 1))
    for i, step in enumerate(reaches[:, None] * directions):
        fill(t, y + step, values[0, i])
        fill(t, y - step, values[1, i])
    return np.asarray((values[0] - values[1]) / (2.0 * reaches[:, None]))


def _python_slopes(route: Evaluated, t: float, y: Vector, directions: Matrix, reaches: Vector) -> Matrix:
    """Return the same of functions in Python: each is called along the directions that move what it reads alone."""
    layout, model = route.inputs, route.model
    slopes = np.zeros((len(directions), len(layout.constants)))
    for place, state, factor in layout.held:
        slopes[:, place] = factor * directions[:, model.coordinate_count + model.free_count + state]
    states: dict[int, tuple[SceneState, SceneState]] = {}  # which several functions look at

    def beside(i: int) -> tuple[SceneState, SceneState]:
        if i not in states:
            step = reaches[i] * directions[i]
            states[i] = route.state(t, y + step), route.state(t, y - step)
        return states[i]

    for where, load in layout.of_state:
        read = ReadState(route.state(t, y))
        load.value(t, read)
        for i in read.moved_by(directions):
            ahead, behind = (load.value(t, state) for state in beside(i))
            slopes[i, where] = (ahead - behind) / (2.0 * reaches[i])
    for where, number in layout.between:
        own = model.loads[number]
        for i, reach in enumerate(reaches):
            ahead, behind = (own.inputs(t, x.load_ends(number), x.load_states(number)) for x in beside(i))
            slopes[i, where] = (ahead - behind) / (2.0 * reach)
    return slopes


def _rates_with(route: Evaluated, kernel: RatesKernel, t: float, y: Vector, values: Matrix) -> Matrix:
    """Return dy/dt while loads have given values, one set a row."""
    call = kernel.take()
    call.at[:], call.drives[:] = y, route.drives(t)
    found = np.empty((len(values), len(y)))
    for row, own in zip(found, values, strict=True):
        call.inputs[:] = own
        call(t)
        row[:] = call.slope
    call.inputs[:] = route.inputs.constants
    kernel.give_back(call)
    return found
