"""Routes: ways to evaluate the equations of a frozen scene, of which one is chosen when the scene is frozen."""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.loads.base import Load
from kanefe.tree.model_data import ModelData
from kanefe.tree.model_outputs import MechanicalEnergy
from kanefe.tree.run_sweeps import RunSweeps
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.kernels.events.watched_run import WatchedRun
    from kanefe.kernels.steppers.sampling import Samples
    from kanefe.kernels.steppers.step_commands import Run


class Obstacle(NamedTuple):
    """A part of a scene that the sweeps in order n do not support: its kind, and details."""

    kind: str
    detail: str

    def __str__(self) -> str:
        return f"{self.kind} ({self.detail})"


class Form(Enum):
    """The form of the equations that a method of integration uses."""

    DENSE = "mass matrix, forces and derivatives over all speeds"
    SWEEPS = "linearly implicit evaluations, energies and momenta by sweeps in order n"
    SUBSTRUCTURES = "residuals and borders of bodies with all degrees of freedom of the mesh"


class Evaluation(NamedTuple):
    """Rates at a state.

    Attributes
    ----------
    rates : ndarray, shape (state,)
        dy/dt of ``y = (q, u, z, energy dissipated, work)``.
    weakest : float
        Smallest pivot of a constraint, 1 at most: it approaches zero towards a singular position.
    is_own : bool
        Whether the route computed them itself; else the literal one did in its place.
    """

    rates: Vector
    weakest: float
    is_own: bool = True


class MethodNeeds(NamedTuple):
    """What a method needs besides rates.

    Linearly implicit evaluations, energy and momenta, derivatives, directions in which loads are stiff.
    """

    implicit: bool = False
    balance: bool = False
    derivatives: bool = False
    directions: bool = False


class Answers(Protocol):
    """The sampled controllers of a run, whose functions may be in Python."""

    @property
    def samples(self) -> Samples:
        """For compiled code."""
        ...

    def answer(self, t: float, y: Vector) -> None:
        """Do what compiled code asks for at a time (s) and a state."""
        ...


class PreparedRun(Protocol):
    """A run that stays in compiled code, used by one thread at a time."""

    def go_on(self, run: Run) -> int:
        """Continue; return the request of the method that compiled code cannot fulfil."""
        ...

    def go_over_events(self, run: Run, watched: WatchedRun, restart_share: float) -> tuple[int, bool]:
        """Continue over events of loads; return the method's request, and whether the last step needs no Python."""
        ...

    def go_over_samples(self, run: Run, sampler: Answers) -> int:
        """Continue over samples of controllers; return the method's request."""
        ...

    def prepared(self, run: Run, watched: WatchedRun | None, restart_share: float) -> tuple[Any, Any | None, Vector]:
        """Return the call of a run, that of a run over events if there are any, and the values of loads they read."""
        ...

    def values_at(self, run: Run, t: float) -> Vector:
        """Return event values of loads at a time of the last step."""
        ...


class WatchedEvents(Protocol):
    """Events of loads whose functions are compiled.

    Attributes
    ----------
    columns : dict of int to slice
        Columns of the values of each such load, by its number in the model.
    rows : dict of int to int
        Number of each such load in the tables of the kernel.
    contact_columns : dict of str to int
        Columns of the margins of rigid contacts, by the events that they lead to, see
        `kanefe.integrate.events.contact_changes`, and "largest", that of the largest force.
    """

    columns: dict[int, slice]
    rows: dict[int, int]
    contact_columns: dict[str, int]

    def values(self, times: np.ndarray, states: Matrix, only: int = ...) -> Matrix:
        """Return the values at times (T,) and states (T, n) that begin with q, u and z, (T, values).

        `only`: what is looked at, see `kanefe.kernels.loads.watching`.
        """
        ...

    def prepared(
        self,
        times: np.ndarray,
        drives: np.ndarray,
        inputs: np.ndarray,
        states: Matrix,
        change: np.ndarray = ...,
        only: np.ndarray = ...,
    ) -> tuple[Any, Matrix, Vector]:
        """Return the call of the kernel with these arrays, and the arrays that it writes: values, and what is near."""
        ...


class Evaluates(Protocol):
    """What evaluates states of a scene, and gives them to the literal route."""

    model: ModelData

    def evaluate(self, t: float, y: Vector) -> Evaluation:
        """Return the rates at a state; near a singular position those of the nearest one whose loops are closed.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        ...

    def rates(self, t: float, y: Vector) -> Vector:
        """Return dy/dt of a state without quadratures: see `evaluate`."""
        ...

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free and the driven speeds at a state, shape (free + driven, free + driven)."""
        ...

    def acting(self, t: float, y: Vector, du: Vector) -> tuple[Any, Vector]:
        """Return a state, `kanefe.states.state.State`, of a scene with the same loads, and its accelerations."""
        ...


class Route(Evaluates, Protocol):
    """The interface of all routes. States are ``y = (q, u, z, ...)``; entries after z are not used.

    Attributes
    ----------
    model : ModelData
    name, reason : str
        Name of the route, and the reason of its choice, for results.
    obstacles : tuple of Obstacle
        Parts of the scene that prevent sweeps in order n.
    is_autonomous : bool
        Whether whole runs stay in compiled code.
    is_constant : bool
        Whether no load is a function of the user.
    warns_at_start : bool
        Whether impacts at the start were warned of.
    """

    name: str
    reason: str
    obstacles: tuple[Obstacle, ...]
    warns_at_start: bool

    @property
    def is_autonomous(self) -> bool:
        """See above."""
        ...

    @property
    def is_constant(self) -> bool:
        """See above."""
        ...

    def started_otherwise(self, model: ModelData) -> Self:
        """Return the route of a model that differs from this one's in its start alone."""
        ...

    def lacks(self, form: Form) -> str:
        """Return why a form of equations is not available, with a remedy; an empty string if it is.

        The text continues a sentence that begins with the name of a method.
        """
        ...

    def check_dense(self, what: str) -> None:
        """Raise a ModelError that names what needs matrices over all speeds, if they are not available."""
        ...

    def check_outputs(self, count: int) -> None:
        """Raise a ModelError if this number of states of a run takes too much memory."""
        ...

    def start(self, t: float) -> Vector:
        """Return (q, u, z) at the start, consistent with the loops at time t (s)."""
        ...

    def started(self, t: float, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return loads between frames in their state at the start, time t (s)."""
        ...

    def derivatives(self, t: float, y: Vector, directions: Matrix, reaches: Vector | None = None) -> Matrix | None:
        """Return exact derivatives of dy/dt along the rows of a matrix, (k, state) both; None if not available.

        They are not available for scenes with functions of the user that depend on the state; where `reaches` says how
        far to go along each direction, those of compiled functions are differences.
        """
        ...

    def calls_for_derivatives(self, t: float, y: Vector, directions: Matrix) -> int:
        """Return how many calls of functions in Python derivatives along so many directions take at a state."""
        ...

    def partial_derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix | None:
        """Return derivatives with the values of functions of the user held constant; otherwise as `derivatives`."""
        ...

    def projected(self, t: float, y: Vector, share: float = 0.0) -> Vector:
        """Return the nearest state with closed loops and consistent speeds; y itself if it is one.

        The metric is the mass matrix plus a share (s2) of the stiffness of modes and joints, so that stiff modes, which
        the mass matrix alone would move, keep their values.
        """
        ...

    def wrenches_of_loads(self, t: float, y: Vector) -> dict[int, Matrix]:
        """Return the wrenches of loads between frames on their ends in N, (ends, 6), by the numbers of the loads.

        Without those of rigid contacts.
        """
        ...

    def state(self, t: float, y: Vector) -> SceneState:
        """Return the state passed to functions of the user."""
        ...

    def sweeps(self, times: np.ndarray, states: Matrix) -> RunSweeps | None:
        """Return quantities computed for all states of a run at once; None if each is evaluated separately."""
        ...

    @property
    def watching(self) -> WatchedEvents | None:
        """The function that computes event values of loads, if it is compiled."""
        ...

    def asked_contacts(
        self, what: int, t: float, y: Vector, span: float = ..., stop: float = ..., rtol: float = ...
    ) -> Any:
        """Return a `kanefe.tree.contact_changes.ContactDecider` that has been asked, see its `ask`."""
        ...

    def touched(self, t: float, y: Vector, span: float, stop: float, rtol: float) -> Vector:
        """Return a state (q, u, z) with what touches in it known, after impacts, as a run begins."""
        ...

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        ...

    def momenta(self, t: float, y: Vector) -> tuple[Vector, Vector]:
        """Return linear and angular momentum about N's origin, in N, kg m/s and kg m2/s."""
        ...

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the power dissipated and the power supplied at a state and accelerations du (free,), W, shape (2,)."""
        ...

    def sweep_implicitly(
        self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float, share_of_rates: float = 0.0
    ) -> float:
        """Write a linearly implicit evaluation to the rows of a method, for `Form.SWEEPS`; return the weakest pivot."""
        ...

    def balance(self, run: Run) -> None:
        """Write energies and momenta that a method requests, for `Form.SWEEPS`."""
        ...

    def compiled_run(
        self, integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, needs: MethodNeeds
    ) -> PreparedRun:
        """Return a run in compiled code of a method with this memory; only if `is_autonomous`."""
        ...

    def impact_steps(self, told: Vector, too_deep: float, bends: tuple[np.ndarray, np.ndarray]) -> Any | None:
        """Return compiled steps over impacts, `kanefe.order_n.impact_steps.ImpactSteps`; None where there are none."""
        ...

    def check_functions(self, t: float, y: Vector) -> None:
        """Raise a ModelError if a load or motion does not return numbers at a state."""
        ...

    def view(self, t: float, y: Vector) -> Any:
        """Return a state, `kanefe.states.state.State`, of a scene with the same motion of frames."""
        ...

    def widened(self, partial: Matrix) -> Matrix:
        """Return partial velocities over the free speeds of the scene from those over the speeds of a view."""
        ...
