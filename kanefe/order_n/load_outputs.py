"""Outputs of loads by compiled functions, for states of a run from one call: see `kanefe.kernels.loads.telling`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.constraints.loop_tables import no_loops
from kanefe.kernels.evaluation.evaluation import scene_of
from kanefe.kernels.loads.telling import States, tell_states
from kanefe.kernels.scene import memory_size
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.tables.load_tables import told_loads
from kanefe.tree.run_sweeps import OutputFunction


class LoadOutputs:
    """The kernel that tells outputs of some loads.

    Parameters
    ----------
    route : Evaluated
    functions : dict of int to (function, int)
        Of each load by its number, and how many outputs it writes.

    Attributes
    ----------
    columns : dict of int to slice
        Of each load, by its number.
    """

    def __init__(self, route: Evaluated, functions: Mapping[int, tuple[OutputFunction, int]]) -> None:
        between, order = told_loads(route.places, functions)
        counts = np.array([functions[number][1] for number in order], dtype=np.int64)
        ends = np.cumsum(counts).tolist()
        self.columns = {n: slice(end - functions[n][1], end) for n, end in zip(order, ends, strict=True)}
        self._width = int(counts.sum())
        scene = scene_of(route.tables, route.flexible, between, no_loops())
        self._memory_size = memory_size(scene)
        self._bound = tell_states.bound(scene, counts, *(LATER,) * 3)

    def prepared(self, times: Vector, drives: np.ndarray, values: Matrix, states: Matrix) -> tuple[Call, Matrix]:
        """Return the call for some states, and what it writes, (T, outputs)."""
        found = np.zeros((len(states), self._width))
        return self._bound.prepared(States(times, drives, values, states), found, np.zeros(self._memory_size)), found
