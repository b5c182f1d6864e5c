"""What analyses ask of one state: the mass matrix, and what loads do on their ends, from one sweep each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER
from kanefe.kernels.evaluation.masses import put_masses
from kanefe.kernels.force_elements.places import WRENCH, WRENCHES
from kanefe.kernels.loads.telling import States, tell_states
from kanefe.order_n.evaluated import Evaluated


class StateKernels:
    """The kernels of a scene that are called for one state; several threads may use them.

    Parameters
    ----------
    route : Evaluated
    order : sequence of int
        Numbers of the loads between frames in the order of its tables.
    """

    def __init__(self, route: Evaluated, order: Sequence[int]) -> None:
        self._route, self._order = route, order
        self._ends = [len(route.model.loads[number].ends) for number in order]
        counts = WRENCHES + WRENCH * np.array(self._ends, dtype=np.int64)
        self._masses = put_masses.bound(route.scene, *(LATER,) * 4)
        self._told = tell_states.bound(route.scene, counts, *(LATER,) * 3)

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free and the driven speeds, (free + driven, free + driven)."""
        route = self._route
        size = route.model.free_count + route.model.driven_count
        found, memory = np.empty((size, size)), np.empty(route.memory_size)
        self._masses(route.drives(t), np.asarray(y, dtype=float), found, memory)
        return found

    def wrenches_of_loads(self, t: float, y: Vector) -> dict[int, Matrix]:
        """Return the wrenches of loads on their ends in N, (ends, 6), by the numbers of the loads."""
        route, wrenches, at = self._route, dict[int, Matrix](), 0
        if not self._order:
            return wrenches
        found = np.empty((1, sum(WRENCHES + WRENCH * count for count in self._ends)))
        states, drives, values = np.asarray(y, dtype=float)[None], route.drives(t)[None], route.values(t, y)[None]
        memory = np.empty(route.memory_size)
        self._told(States(np.array((t,)), drives, values, states), found, memory)
        for number, count in zip(self._order, self._ends, strict=True):
            at += WRENCHES
            wrenches[number] = found[0, at : at + WRENCH * count].reshape(count, WRENCH)
            at += WRENCH * count
        return wrenches
