"""The kernel that tells forces of states, with the tables of a scene."""

from __future__ import annotations

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.evaluation.evaluation import scene_of
from kanefe.kernels.evaluation.force_tables import force_memory_size
from kanefe.kernels.evaluation.forces import Evaluated, States, forces_of_states
from kanefe.kernels.scene import Scene
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
    scene : Scene
    complete : tuple
        One with a row for each body and interface, and the builder of its tables.

    Attributes
    ----------
    told : ForceTableBuilder
    """

    def __init__(
        self,
        evaluation: RatesKernel,
        scene: Scene,
        complete: tuple[FrameOffsets, Scene],
    ) -> None:
        self._evaluation, self._evaluated = evaluation, scene
        builder, (tables, flexible, *_) = complete
        between, order = loads_between(builder)
        loops = loop_tables(builder, tables, flexible)
        self.told = ForceTableBuilder(builder, between, order, loops)
        whole = scene_of(tables, flexible, between, loops)
        self._memory_size = force_memory_size(whole, self.told.tables)
        self._bound = forces_of_states.bound(whole, self.told.tables, *(LATER,) * 5)

    def prepared(
        self, times: Vector, driven: np.ndarray, values: Matrix, states: Matrix, rates: Matrix
    ) -> tuple[Call, Matrix, Vector]:
        """Return the call for some states, what it writes, and whether that is told; `rates` are known, or no rows."""
        call = self._evaluation.new_call()
        found, is_told = np.zeros((len(states), self.told.told.size)), np.zeros(len(states), dtype=np.int64)
        memory = call.call.arguments[-1]
        evaluated = Evaluated(call.call.for_kernels(), self._evaluated, call.drives, call.inputs, call.vectors, memory)
        told = States(times, driven, values, states, rates)
        prepared = self._bound.prepared(evaluated, told, found, is_told, np.zeros(self._memory_size))
        return prepared, found, is_told
