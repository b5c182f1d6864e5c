"""The kernel that tells forces of states, with the tables of a scene."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.constraints.holding import scale_of_rows
from kanefe.kernels.evaluation.evaluation import workspace_in
from kanefe.kernels.evaluation.force_tables import WIDTH, force_memory_size
from kanefe.kernels.evaluation.forces import forces_of_states
from kanefe.kernels.layout import DRIVES, SPEEDS
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.order_n.rates_kernel import RatesKernel
from kanefe.order_n.tables.constraint_tables import loop_tables
from kanefe.order_n.tables.force_tables import ForceTableBuilder
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.load_tables import loads_between


class ForceKernel:
    """The kernel of forces with the tables of a scene; several threads may use it.

    Parameters
    ----------
    evaluation : RatesKernel
        In space: what computes accelerations and multipliers.
    scene : tuple
        Its tables: of links, of flexible bodies, of loads, of loops.
    complete : tuple
        Tables with a row for each body and interface, and their builder.

    Attributes
    ----------
    told : ForceTableBuilder
    """

    def __init__(
        self,
        evaluation: RatesKernel,
        scene: tuple[Tables, FlexibleTables, LoadsBetween, Loops],
        complete: tuple[FrameOffsets, Tables, FlexibleTables],
    ) -> None:
        self._evaluation, self._evaluated = evaluation, scene
        builder, tables, flexible = complete
        between, order = loads_between(builder)
        loops = loop_tables(builder, tables, flexible)
        self.told = ForceTableBuilder(builder, between, order, loops)
        self._scene = tables, flexible, between, loops, self.told.tables
        self._bound = forces_of_states.bound(*self._scene, *(LATER,) * 15)

    def prepared(
        self, times: Vector, driven: np.ndarray, values: Matrix, states: Matrix, rates: Matrix
    ) -> tuple[Call, Matrix, Vector]:
        """Return the call for some states, what it writes, and whether that is told; `rates` are known, or no rows."""
        places, call = self.told.tables.places, self._evaluation.new_call()
        tables, _, _, loops = self._evaluated
        workspace = workspace_in(call.call.arguments[-1], *self._evaluated)
        scale = scale_of_rows(workspace.holding, loops, int(tables.sizes[SPEEDS] + tables.sizes[DRIVES]))
        found, is_told = np.zeros((len(states), int(places[WIDTH]))), np.zeros(len(states), dtype=np.int64)
        memory = workspace.multipliers, scale, workspace.holding
        evaluation = call.call.for_kernels(), call.vectors, call.drives, call.inputs, *memory
        given = times, driven, values, states, rates, found, is_told
        prepared = self._bound.prepared(*evaluation, *given, np.zeros(force_memory_size(*self._scene)))
        return prepared, found, is_told
