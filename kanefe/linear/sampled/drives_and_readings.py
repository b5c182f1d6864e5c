"""What controllers read of small motions, and how their drives act on them: derivatives by states and inputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.linear.linearisation import Linearisation
from kanefe.linear.outputs import output_rows, outputs_of
from kanefe.linear.sampled.sampled_laws import LinearLaw
from kanefe.linear.small_motions import Directions
from kanefe.linear.tangents import difference

ROUND_OFF = 1e-11
"""Change relative to the largest change of the inputs that is round-off of differences."""


def pushed(plant: Linearisation, laws: Sequence[LinearLaw]) -> Directions:
    """Return the accelerations due to unit drives of all controllers, in which loads are linear."""
    model, t, n = plant.model, plant.time, plant.model.free_count
    columns = []
    for at in _held(plant, laws):
        beside = []
        for sign in (0.5, -0.5):
            state = plant.state.copy()
            state[at] += sign
            beside.append(model.parts(model.rhs(t, state))[1])
        columns.append(beside[0] - beside[1])
    ddu = np.zeros((plant.small.size, len(columns)))
    ddu[:n] = np.array(columns).T
    return Directions(np.zeros_like(ddu), np.zeros_like(ddu), ddu)


def _held(plant: Linearisation, laws: Sequence[LinearLaw]) -> list[int]:
    """Return the places of the drives of all controllers in the state."""
    first = plant.model.coordinate_count + plant.model.free_count
    places = [plant.model.held[law.controller.name] for law in laws]
    return [first + i for held in places for i in range(held.start, held.stop)]


def read_rows(
    plant: Linearisation, read: Callable[[Vector], Vector], acting: np.ndarray, laws: Sequence[LinearLaw], size: int
) -> Matrix:
    """Return the derivatives of the readings of a controller by the states of the loop, (reads, states)."""
    small, y = plant.small, plant.state
    z = plant.model.parts(y)[2]
    rows = np.zeros((len(read(y)), size))
    columns = [
        (along, i, steps[i])
        for along in (small.along_positions, small.along_speeds)
        for steps in (small.steps(along),)
        for i in range(along.z.shape[1])
    ]
    for column, (along, i, step) in enumerate(columns):

        def beside(h: float, along: Directions = along, i: int = i) -> Vector:
            moved = small.moved(along, i, h)
            return read(np.concatenate((moved.q, moved.u, z)))

        rows[:, column] = difference(beside, step)
    for place, at in zip(acting, _held(plant, laws), strict=True):
        unit = np.zeros(len(y))
        unit[at] = 0.5
        rows[:, place] = read(y + unit) - read(y - unit)
    sizes = np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
    return np.where(np.abs(rows) > ROUND_OFF * sizes, rows, 0.0)


def read_inputs(plant: Linearisation, law: LinearLaw, driven: Directions) -> Matrix:
    """Return the derivatives of readings by the inputs, (reads, inputs): nonzero for accelerations only."""
    rows = np.zeros((len(law.controller.reads), driven.ddu.shape[1]))
    for row, reading in zip(rows, law.controller.reads, strict=True):
        if "acceleration" in reading.what and len(row):
            frame = f"{reading.body}/{reading.interface}" if reading.interface else reading.body
            axis = f"{'xyz'[reading.component]}{chr(39) if reading.is_own else ''}"
            row[:] = output_rows(plant.small, outputs_of(plant.small, f"{reading.what} {frame} {axis}"), driven)[0]
    return rows
