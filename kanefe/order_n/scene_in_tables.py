"""A scene in the tables of the kernels, and what its drives and loads give them at a state."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler._numba import IS_COMPILED
from kanefe.kernels.compiler.compiled_functions import expect
from kanefe.kernels.compiler.filling import filler
from kanefe.kernels.constraints.loop_tables import no_loops
from kanefe.kernels.evaluation.evaluation import evaluate, scene_of
from kanefe.kernels.loads.acting import BetweenLoads
from kanefe.kernels.scene import Scene, links_of, memory_size
from kanefe.kernels.tree import GivenLink, Kind
from kanefe.literal.route import LiteralRoute
from kanefe.loads.functions import SPENT
from kanefe.order_n.laws import functions_of_laws
from kanefe.order_n.tables.constraint_tables import loop_tables
from kanefe.order_n.tables.drive_tables import drive_tables
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.load_tables import loads_between, told_loads
from kanefe.order_n.tables.scene_tables import TableBuilder
from kanefe.tree.model_data import QUADRATURES, ModelData

if TYPE_CHECKING:
    from kanefe.order_n.tree_matrix import TreePattern

NO_DRIVES = np.zeros((0, 3))


class SceneInTables(LiteralRoute):
    """A scene as the kernels take it; its attributes are those of `kanefe.order_n.evaluated.Evaluated`.

    Parameters
    ----------
    model : ModelData
        Without obstacles.
    """

    def __init__(self, model: ModelData) -> None:
        super().__init__(model)
        self.reason = "all parts of the scene have kernels"
        if IS_COMPILED:  # what is missing is built together
            expect((evaluate.unit(), *functions_of_laws(model)))
        builder = TableBuilder(model)
        self.tables, self.flexible = builder.tables()
        self.between, self._order = loads_between(builder)
        self.loops = loop_tables(builder, self.tables, self.flexible)
        self.has_loops = model.is_constrained
        self.scene = scene_of(self.tables, self.flexible, self.between, self.loops)
        self.memory_size = memory_size(self.scene)
        self.places: FrameOffsets = builder
        self.inputs = builder.inputs
        self._inputs_stay = self.inputs.is_constant and not self.inputs.held
        self.fill = filler(tuple(self.inputs.compiled()))
        self._drives = model.drives
        self._is_plain = self._inputs_stay and not self._drives
        self.motion_tables = drive_tables(model)

    @property
    def is_constant(self) -> bool:
        """Whether no load is a function of the user."""
        return self.inputs.is_constant

    @property
    def is_autonomous(self) -> bool:
        """Whether no Python function is called in a run, so that whole runs can be compiled."""
        return not self.inputs.calls_python and self.motion_tables is not None

    @property
    def _run_size(self) -> int:
        """Number of values of a state of a run: those of q, u and z, and the energy quadratures."""
        return self.model.coordinate_count + self.model.free_count + self.model.state_count + QUADRATURES

    def drives(self, t: float) -> np.ndarray:
        """Return position, speed and acceleration of the driven coordinates, (driven, 3)."""
        if not self._drives:
            return NO_DRIVES
        names = ("position", "velocity", "acceleration")
        with SPENT.counted():
            values = [[motion.at(name, t, what) for name in names] for motion, what in self._drives]
        return np.array(values).reshape(-1, 3)

    def drives_over(self, times: np.ndarray) -> np.ndarray:
        """Return the same at many times, (T, driven, 3)."""
        if not self._drives:
            return np.zeros((len(times), 0, 3))
        with SPENT.counted():
            return np.stack([motion.over(times, what) for motion, what in self._drives], axis=1)

    def values_over(self, times: np.ndarray, states: Matrix) -> np.ndarray:
        """Return the values of all loads at many states (T, n), (T, inputs): see `values`."""
        if self._inputs_stay:
            return np.repeat(self.inputs.constants[None], len(times), axis=0)
        found = [self.values(t, y) for t, y in zip(times.tolist(), states, strict=True)]
        return np.array(found).reshape(len(times), -1)

    def values(self, t: float, y: Vector) -> np.ndarray:
        """Return the values of all loads at a state that begins with q, u and z."""
        layout = self.inputs
        if self._inputs_stay:
            return layout.constants
        values = layout.begun(self.parts(y)[2]).copy()
        for where, load in layout.of_time:
            values[where] = load.value(t, None)
        if layout.needs_state:
            state = self.state(t, y)
            for where, load in layout.of_state:
                values[where] = load.value(t, state)
            for where, number in layout.between:
                load_between = self.model.loads[number]
                with SPENT.counted():
                    values[where] = load_between.inputs(t, state.load_ends(number), state.load_states(number))
        return values

    @cached_property
    def is_complex(self) -> bool:
        """Whether all kernels of the scene take complex numbers, from which exact derivatives come."""
        of_links = all(GivenLink(one).complex_function for one in links_of(self.scene) if one.kind == Kind.GIVEN)
        return of_links and all(load.complex_function for load in BetweenLoads(self.between.loads))

    @cached_property
    def newton_pattern(self) -> TreePattern | None:
        """Where entries of Newton matrices are that keep the structure of the tree; None where dense ones are taken."""
        from kanefe.order_n.tree_matrix import pattern_if_less

        return pattern_if_less(self)  # type: ignore[arg-type]  # it is an `Evaluated` where it is `OrderN`

    @cached_property
    def complete(self) -> tuple[FrameOffsets, Scene]:
        """A scene in which every body and every interface has a row of its own, and where frames are in it."""
        builder = TableBuilder(self.model, is_complete=True)
        return builder, scene_of(*builder.tables(), told_loads(builder, {})[0], no_loops())
