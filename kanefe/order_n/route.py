"""The order-n route of a frozen model: tables, the values of its loads, and the calls of the kernels.

What the literal route (`kanefe.kane`) computes from dense matrices is here computed in sweeps over the tree, in time
proportional to the number of bodies. Objects are read-only after they are made: several threads may use one.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple, cast, overload

import numpy as np

from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector, cross
from kanefe.kane.assemble import accelerations
from kanefe.kane.bent import bent_too_far
from kanefe.kane.route import LiteralRoute
from kanefe.kane.state import State
from kanefe.kernels._numba import IS_COMPILED
from kanefe.kernels.arrays import Prepared
from kanefe.kernels.closing import CLOSED, close_state, closing_memory_size
from kanefe.kernels.constraints import Loops
from kanefe.kernels.derivatives import derivatives
from kanefe.kernels.drives import Drives
from kanefe.kernels.entries import LATER, Bound
from kanefe.kernels.evaluation import evaluate, workspace_size
from kanefe.kernels.filling import filler
from kanefe.kernels.integration import Scene, integrate
from kanefe.kernels.layout import COMPLEX_FUNCTION, GIVEN, KIND, FlexibleTables, Tables
from kanefe.kernels.loads_between import COMPLEX, LoadsBetween
from kanefe.kernels.momenta import balance
from kanefe.kernels.outward import motion_memory_size, motions_of_rows
from kanefe.kernels.stepping import AT, NO_INERTIA, NOT_FINITE, PUSH_STIFFNESS, SLOPE, STATE, TIME_AT, Run
from kanefe.kernels.tolerances import NEAR_SINGULAR
from kanefe.kernels.units import expect
from kanefe.loads.functions import SPENT
from kanefe.order_n.constraint_tables import loop_tables
from kanefe.order_n.drive_tables import drive_tables
from kanefe.order_n.load_tables import loads_between
from kanefe.order_n.seats import Seat, Seats
from kanefe.order_n.sweeps import Sweeps
from kanefe.order_n.tables import TableBuilder
from kanefe.tree.model_data import WORKS, ModelData
from kanefe.tree.placed import Placed
from kanefe.tree.route import Evaluation, Form, Obstacle, RunSweeps
from kanefe.tree.scene_state import SceneState

GROWN = 1e100
"""Coordinates and speeds beyond which squares overflow: there is no scene left to explain."""

NO_DRIVES = np.zeros((0, 3))

NOT_CALLED = Prepared(0, np.zeros(1, dtype=np.int64), np.zeros(1))


class Going(NamedTuple):
    """The run that went on last: what is prepared for it serves until it ends.

    Attributes
    ----------
    vectors : ndarray
        Of the run.
    evaluation : Bound
    inputs : ndarray
    integrate : Bound
        Takes a `Run`.
    kept : object
        Arrays whose addresses it has.
    """

    vectors: np.ndarray
    evaluation: Bound
    inputs: np.ndarray
    integrate: Bound
    kept: Any


class OrderN(LiteralRoute):
    """The equations of motion of a model in order n.

    Parameters
    ----------
    model : ModelData
        Without `obstacles_of`.
    """

    name = "order n"

    def __init__(self, model: ModelData) -> None:
        super().__init__(model)
        self.reason = "all parts of the scene have kernels"
        builder = TableBuilder(model)
        self.tables, self.flexible = builder.tables()
        self.between = loads_between(builder)
        self.loops = loop_tables(builder)
        self._size = model.coordinate_count + model.free_count + model.state_count + WORKS
        self._workspace_size = workspace_size(self.tables, self.flexible, self.between, self.loops)
        self.places: Seats = builder
        self.inputs = builder.inputs
        self._constants = self.inputs.constants if self.inputs.is_constant else None
        parts = tuple(self.inputs.compiled())
        self._has_compiled_loads = bool(parts)
        self._fill = filler(parts)
        self._drives = model.drives
        self._motions = drive_tables(model)
        self._going: Going | None = None

    def lacks(self, form: Form) -> str:
        """Return why there are no substructures."""
        return "" if form is Form.SWEEPS else super().lacks(form)

    @property
    def is_constant(self) -> bool:
        """Whether no load is a function of the user."""
        return self.inputs.is_constant

    @property
    def is_autonomous(self) -> bool:
        """Whether no Python function is called in a run, so that whole runs can be compiled."""
        calls_python = not self.inputs.is_constant and not self._has_compiled_loads
        return not calls_python and self._motions is not None

    def drives(self, t: float) -> np.ndarray:
        """Return position, speed and acceleration of the driven coordinates, (driven, 3)."""
        if not self._drives:
            return NO_DRIVES
        names = ("position", "velocity", "acceleration")
        with SPENT.counted():
            values = [[motion.at(what, t, name) for what in names] for motion, name in self._drives]
        return np.array(values).reshape(-1, 3)

    def values(self, t: float, y: Vector) -> np.ndarray:
        """Return the values of all loads at a state that begins with q, u and z."""
        layout = self.inputs
        if layout.is_constant and not layout.held:
            return layout.constants
        values = layout.begun(self.parts(y)[2])
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

    def state(self, t: float, y: Vector) -> SceneState:
        """Return what functions of the user see of a state that begins with q, u and z."""
        return SceneState(self.model, t, *self.parts(y), frames=_Frames(self, t, y))

    def sweeps(self, times: np.ndarray, states: Matrix) -> RunSweeps | None:
        """Return what is computed of all states of a run at once."""
        return Sweeps(self, times, states)

    def evaluate(self, t: float, y: Vector) -> Evaluation:
        """Return the rates at a state; where something has only loops to hold it, those of the literal route."""
        rates, weakest = self.held_rates(t, y)
        if weakest >= NEAR_SINGULAR:
            return Evaluation(rates, weakest)
        if weakest > 0.0:
            return Evaluation(self.held_rates(t, self.projected(t, y))[0], weakest)
        return super().evaluate(t, y)._replace(is_own=False)

    def held_rates(self, t: float, y: Vector) -> tuple[Vector, float]:
        """Return dy/dt, and the smallest pivot of the constraints: near zero they are better left to the literal route.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        vectors = np.empty((2, self._size))
        vectors[AT, : len(y)] = y
        vectors[AT, len(y) :] = 0.0
        weakest = self.sweep(t, vectors)
        return vectors[SLOPE], weakest

    def sweep_implicitly(self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float) -> float:
        """Write a linearly implicit evaluation: see `sweep`.

        That of the nearest closed state near a singular position, as in `evaluate`; where only loops hold something
        that has no inertia, the plain rates, which a linearly implicit method may use as well.
        """
        weakest = self.sweep(t, vectors, share_damping, share_stiffness)
        if weakest >= NEAR_SINGULAR:
            return weakest
        if weakest == 0.0:
            vectors[SLOPE], weakest, _ = self.evaluate(t, vectors[AT])
        else:
            asked = vectors[AT].copy()
            vectors[AT] = self.projected(t, asked)
            self.sweep(t, vectors, share_damping, share_stiffness)
            vectors[AT] = asked
        return weakest

    def sweep(self, t: float, vectors: np.ndarray, share_damping: float = 0.0, share_stiffness: float = 0.0) -> float:
        """Write dy/dt of the state in the first row of vectors to the second; return the smallest pivot, see above.

        With four rows or more the evaluation is linearly implicit: see `kanefe.kernels.implicit` for the shares and
        for the two rows of pushes.
        """
        y = vectors[AT]
        inputs, drives = self.values(t, y), self.drives(t)
        done, weakest = self._evaluate(drives, t, inputs, vectors, (share_damping, share_stiffness))
        if done == NO_INERTIA:
            if self.loops is not None:  # what has no inertia by itself may be held by a loop
                return 0.0
            self._explain(t, y)
        if done == NOT_FINITE:  # an integrator takes a smaller step; a load that is not a number is named
            self.values(t, y)
        return weakest

    def derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix | None:
        """Return derivatives of dy/dt along directions in the rows of a matrix, exact to round-off, or None."""
        if self.inputs.needs_state or not self.is_complex:
            return None
        return self.partial_derivatives(t, y, directions)

    def partial_derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix | None:
        """Return the same, with what functions of the user give held constant.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        if not self.is_complex:
            return None
        vectors = np.empty((2, len(y)), dtype=complex)
        vectors[AT] = y
        inputs = self.values(t, y)
        found = np.empty((len(directions), len(y)))
        memory = np.empty(self._workspace_size, dtype=complex)
        scene = False, t, 0.0, 0.0, *self._scene
        call, _kept = evaluate.bound(*scene, self.drives(t), inputs, vectors, memory, is_complex=True).prepared()
        along = np.ascontiguousarray(directions, dtype=float)
        if not derivatives.bound(call, vectors, along, found, is_complex=True)():
            self._explain(t, y)
        return found

    @property
    def is_complex(self) -> bool:
        """Whether all kernels of the scene take complex numbers, from which exact derivatives come."""
        given = self.tables.rows[self.tables.rows[:, KIND] == GIVEN]
        of_links = bool(np.all(given[:, COMPLEX_FUNCTION] != 0))
        return of_links and (self.between is None or bool(np.all(self.between.addresses[:, COMPLEX] != 0)))

    def balance(self, run: Run, vectors: np.ndarray) -> None:
        """Write what a method asks for by BALANCE: see `kanefe.kernels.momenta`."""
        t, scene = float(run.reals[TIME_AT]), (self.tables, self.flexible, self.between)
        memory = np.empty(self._workspace_size)
        balance(t, *scene, self.drives(t), self.inputs.constants, run.integers, run.reals, vectors, memory)

    def projected(self, t: float, y: Vector, stiffness: Matrix | None = None, share: float = 0.0) -> Vector:
        """Return the nearest state at which loops are closed and stay closed; y itself if it is one.

        The literal route finds it where something has no inertia of its own, and names the loops that stay open.
        """
        if self.loops is None:
            return y
        if stiffness is None and self.model.free_count:
            closed = np.array(y, dtype=float)
            memory = np.empty(closing_memory_size(self.tables, self.flexible, self.loops))
            ended, _ = self._closing(share, self.drives(t), closed, memory)
            if ended == CLOSED:
                return closed
        return super().projected(t, y, stiffness, share)

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the power taken and given; of trees from one sweep."""
        if not self.model.has_power:
            return np.zeros(WORKS)
        if self.model.constraints:
            return super().powers(t, y, du)
        return self.held_rates(t, y)[0][-WORKS:]

    def check_functions(self, t: float, y: Vector) -> None:
        """Raise the ModelError of a load or motion that gives no numbers at a state."""
        self.drives(t)
        self.values(t, y)

    def go_on(self, run: Run, vectors: np.ndarray, is_implicit: bool, is_balanced: bool) -> int:
        """Go on with a run without leaving compiled code; return what its method wants that is not to be had there.

        The scene is autonomous. `is_implicit`, `is_balanced`: whether the method asks for linearly implicit
        evaluations, and for energy and momenta.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        command, _ = self._integrate(run, vectors, is_implicit, is_balanced)
        if command == NO_INERTIA:
            y = vectors[AT]
            self._explain(float(run.reals[TIME_AT]), y)
        return command

    @property
    def _scene(self) -> tuple[Tables, FlexibleTables | None, LoadsBetween | None, Loops | None]:
        return self.tables, self.flexible, self.between, self.loops

    def _evaluate(
        self, drives: np.ndarray, t: float, inputs: np.ndarray, vectors: np.ndarray, shares: tuple[float, float]
    ) -> tuple[int, float]:
        """Call the kernel that evaluates the rates once."""
        memory, is_implicit = np.empty(self._workspace_size), len(vectors) > PUSH_STIFFNESS
        return self._evaluation(is_implicit, t, *shares, drives, inputs, vectors, memory)  # type: ignore[no-any-return]

    def _integrate(self, run: Run, vectors: np.ndarray, is_implicit: bool, is_balanced: bool) -> tuple[int, float]:
        """Call the kernel that goes on with a run."""
        return self._go_on_by(self._evaluation, self._workspace_size, run, vectors, is_balanced)

    def _go_on_by(
        self, evaluation: Bound, size: int, run: Run, vectors: np.ndarray, is_balanced: bool
    ) -> tuple[int, float]:
        """Go on with a run by a kernel of evaluations with a memory of that size."""
        going = self._going
        if going is None or going.vectors is not vectors or going.evaluation is not evaluation:
            scene, kept = self._scene_of(evaluation, size, run, vectors, is_balanced)
            going = Going(vectors, evaluation, scene.inputs, integrate.bound(scene, LATER, vectors), kept)
            self._going = going
        going.inputs[:] = self.inputs.begun(self.parts(vectors[STATE])[2])  # controllers hold what is in STATE
        return going.integrate(run)  # type: ignore[no-any-return]

    def _scene_of(
        self, evaluation: Bound, size: int, run: Run, vectors: np.ndarray, is_balanced: bool
    ) -> tuple[Scene, Any]:
        """Return what a run needs of the scene, and what has to be kept as long."""
        drives, inputs = np.empty((len(self._drives), 3)), np.empty_like(self.inputs.constants)
        closed, asked = np.empty(self._size), np.empty(self._size)
        evaluated, kept = evaluation.prepared(False, 0.0, 0.0, 0.0, drives, inputs, vectors, np.empty(size))
        closing = balanced = NOT_CALLED
        if self.loops is not None:
            memory = np.empty(closing_memory_size(self.tables, self.flexible, self.loops))
            closing, kept_too = self._closing.prepared(0.0, drives, closed, memory)
            kept = kept + kept_too
        if is_balanced:
            memory, tables = np.empty(self._workspace_size), (self.tables, self.flexible, self.between)
            bound = balance.bound(0.0, *tables, drives, inputs, run.integers, run.reals, vectors, memory)
            balanced, kept_too = bound.prepared()
            kept = kept + kept_too
        has_loops, motions = self.loops is not None, cast(Drives, self._motions)  # of an autonomous scene
        scene = Scene(evaluated, closing, balanced, has_loops, drives, motions, self._fill, inputs, closed, asked)
        return scene, kept

    @cached_property
    def _evaluation(self) -> Bound:
        return self._expected(evaluate.bound(LATER, LATER, LATER, LATER, *self._scene, LATER, LATER, LATER, LATER))

    def _expected(self, evaluation: Bound) -> Bound:
        """Have what most runs of the scene need built with its evaluation, where it is not."""
        if IS_COMPILED:
            closing = () if self.loops is None else (self._closing.unit,)
            expect((evaluation.unit, integrate.unit(integrate.variants[0]), *closing))
        return evaluation

    @cached_property
    def _closing(self) -> Bound:
        return close_state.bound(LATER, self.tables, self.flexible, self.loops, LATER, LATER, LATER)

    @cached_property
    def motions(self) -> Bound:
        """Where all rows are at one time: see `motions_of_rows`."""
        return motions_of_rows.bound(self.tables, self.flexible, *(LATER,) * 6)

    def _explain(self, t: float, y: Vector) -> None:
        """Raise the error of the literal route for a state at which the sweep failed."""
        q, u, z = self.parts(y)
        if all(np.all(np.abs(x) < GROWN) for x in (q, u)):
            if bent := bent_too_far(self.model, t, q, u):
                raise SimulationError(f"at t = {t:.6g} s {bent}")
            accelerations(State(self.model, t, q, u, z))
        raise SimulationError(
            f"the equations of motion have no finite solution at t = {t:.6g} s. "
            "Remedy: check the loads for growth without bound, or take smaller steps"
        )


def obstacles_of(model: ModelData) -> tuple[Obstacle, ...]:
    """Return what keeps a scene from the order-n route; nothing: it is served."""
    for body in model.bodies:
        if body.flexible is not None and not isinstance(body.flexible.free_moments, MassMoments):
            return (Obstacle("bodies in the nodal form", "matrices of nodes that rotate"),)
    for body in model.bodies:
        if body.joint.links() is None:
            return (Obstacle("joints that give no links", f"that of {body.name!r}"),)
    return ()


class _Frames(Sequence[Placed]):
    """Motion of every body's frame at a state: one sweep when the first is asked for."""

    def __init__(self, route: OrderN, t: float, y: Vector) -> None:
        self._route, self._t, self._y = route, t, y
        self._rows: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self._route.places.seats)

    @overload
    def __getitem__(self, number: int) -> Placed: ...

    @overload
    def __getitem__(self, number: slice) -> list[Placed]: ...

    def __getitem__(self, number: int | slice) -> Placed | list[Placed]:
        route = self._route
        if isinstance(number, slice):
            return [self[i] for i in range(*number.indices(len(self)))]
        if self._rows is None:
            found = np.empty((1, len(route.tables.rows), 18))
            none, states = np.zeros((0, route.model.free_count)), np.array(self._y)[None]
            drives, memory = route.drives(self._t), np.empty(motion_memory_size(route.tables, route.flexible))
            route.motions(drives[None], states, none, found, drives, memory)
            self._rows = found[0]
        return _placed(self._rows, route.places.seats[number])


def _placed(work: np.ndarray, seat: Seat) -> Placed:
    if seat.row < 0:
        return Placed(seat.axes, seat.place, np.zeros(3), np.zeros(3))
    p, R, v, w = work[seat.row, :3], work[seat.row, 3:12].reshape(3, 3), work[seat.row, 12:15], work[seat.row, 15:18]
    lever, A = R @ seat.place, R @ seat.axes
    return Placed(A, p + lever, A.T @ (v + cross(w, lever)), A.T @ w)
