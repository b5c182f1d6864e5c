"""What runs, frames and sweeps over states take of a route in order n."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import Bound
from kanefe.kernels.scene import Scene
from kanefe.kernels.sweeps.drives import Drives
from kanefe.kernels.tables import FlexibleTables, LoadsBetween, Loops, Tables
from kanefe.order_n.derivative_call import DerivativeCall
from kanefe.order_n.rates_kernel import RatesKernel
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.order_n.tables.inputs import InputLayout
from kanefe.tree.route import Evaluates, MethodNeeds, PreparedRun, WatchedEvents
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.order_n.force_kernel import ForceKernel


class Evaluated(Evaluates, Protocol):
    """A scene as tables of the kernels, and questions to it: see `kanefe.order_n.route.OrderN`.

    Attributes
    ----------
    model : ModelData
    places : FrameOffsets
        Where frames sit in the rows.
    inputs : InputLayout
    scene : Scene
        For the kernels.
    tables, flexible, between, loops : named tuples
        What is in it; `flexible` is empty where all bodies are rigid.
    motion_tables : Drives or None
        Of driven coordinates; None if one is a Python function.
    fill : function (t, y, inputs)
        Writes values of loads that are compiled functions.
    has_loops : bool
    memory_size : int
        Numbers that an evaluation in space writes on its way.
    """

    places: FrameOffsets
    inputs: InputLayout
    scene: Scene
    tables: Tables
    flexible: FlexibleTables
    between: LoadsBetween
    loops: Loops
    motion_tables: Drives | None
    fill: Any
    has_loops: bool
    memory_size: int

    @property
    def closing(self) -> Bound:
        """What closes loops: see `kanefe.kernels.constraints.closing.close_state`."""
        ...

    @property
    def balances(self) -> Bound:
        """The kernel of energies and momenta: see `kanefe.kernels.evaluation.momenta.balances_of_states`."""
        ...

    @property
    def kernel_in_space(self) -> RatesKernel:
        """The kernel that evaluates the rates in space."""
        ...

    @property
    def complete(self) -> tuple[FrameOffsets, Scene]:
        """A scene with a row for each body and interface, and where frames are in it."""
        ...

    @property
    def force_kernel(self) -> ForceKernel:
        """What tells forces of states."""
        ...

    @property
    def is_complex(self) -> bool:
        """Whether derivatives are exact, by complex numbers."""
        ...

    def derivative_call(self, size: int) -> DerivativeCall:
        """Return a call that differentiates the rates."""
        ...

    @property
    def watching(self) -> WatchedEvents:
        """The function that computes event values of loads."""
        ...

    @property
    def is_autonomous(self) -> bool:
        """Whether whole runs stay in compiled code."""
        ...

    def parts(self, y: Vector) -> tuple[Vector, Vector, Vector]:
        """Return q, u and z of a state."""
        ...

    def state(self, t: float, y: Vector) -> SceneState:
        """Return what functions of the user see of a state."""
        ...

    def drives(self, t: float) -> np.ndarray:
        """Return position, speed and acceleration of the driven coordinates."""
        ...

    def drives_over(self, times: np.ndarray) -> np.ndarray:
        """Return the same at many times."""
        ...

    def values_over(self, times: np.ndarray, states: Matrix) -> np.ndarray:
        """Return the values of all loads at many states."""
        ...

    def values(self, t: float, y: Vector) -> np.ndarray:
        """Return the values of all loads."""
        ...

    def compiled_run(
        self, integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, needs: MethodNeeds
    ) -> PreparedRun:
        """Return a run in compiled code."""
        ...

    def explain(self, t: float, y: Vector) -> NoReturn:
        """Raise the error of the literal route for a state at which the sweep failed."""
        ...
