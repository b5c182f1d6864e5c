"""The order-n route of a frozen model: the calls of the kernels.

What the literal route (`kanefe.kane`) computes from dense matrices is here computed in sweeps over the tree, in time
proportional to the number of bodies. Objects are read-only after they are made: several threads may use one.
"""

from __future__ import annotations

import threading
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn, Self

import numpy as np

from kanefe.errors import ModelError, SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kernels.compiler.entries import LATER, Bound
from kanefe.kernels.constraints.closing import ENDED, close_state, closing_memory_size
from kanefe.kernels.constraints.least_forces import LEAST_GAIN
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.kernels.evaluation.evaluation import evaluate
from kanefe.kernels.evaluation.momenta import balance, balances_of_states
from kanefe.kernels.steppers.step_commands import NO_INERTIA, NOT_FINITE, VECTOR, Run, StepArrays, step_of
from kanefe.order_n.derivative_call import DerivativeCall
from kanefe.order_n.rates_kernel import RatesCall, RatesKernel
from kanefe.order_n.scene_in_tables import SceneInTables
from kanefe.order_n.state_kernels import StateKernels
from kanefe.order_n.sweeps import Sweeps
from kanefe.order_n.swept_state import MotionsKernel, SweptState
from kanefe.order_n.watching import Watching
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.model_outputs import MechanicalEnergy
from kanefe.tree.route import Evaluation, Form, MethodNeeds, Obstacle
from kanefe.tree.run_sweeps import RunSweeps
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.order_n.compiled_run import CompiledRun
    from kanefe.order_n.force_kernel import ForceKernel
    from kanefe.order_n.impact_steps import ImpactSteps
    from kanefe.tree.contact_changes import ContactDecider

GROWN = 1e100
"""Coordinates and speeds beyond which squares overflow, so that no scene is left to explain."""

NEAR_PARADOX = 1e-2
"""Fraction that friction leaves of what a normal force does, below which a run that finds no step has come to
Painleve's paradox."""


class OrderN(SceneInTables):
    """The equations of motion of a model in order n.

    Parameters
    ----------
    model : ModelData
        Without `obstacles_of`.
    """

    name = "order n"

    def __init__(self, model: ModelData) -> None:
        super().__init__(model)
        self._frames = MotionsKernel(self)
        self._derivative_calls: list[DerivativeCall] = []  # that no thread uses
        self._looks = threading.local()

    def __reduce__(self) -> tuple[Any, ...]:
        return OrderN, (self.model,)  # tables have addresses, which are those of a process

    def started_otherwise(self, model: ModelData) -> Self:
        """Return the route of a model that differs in its start alone, with the same tables and kernels."""
        other = super().started_otherwise(model)
        other._looks = threading.local()
        return other

    def lacks(self, form: Form) -> str:
        """Return why there are no substructures."""
        return "" if form is Form.SWEEPS else super().lacks(form)

    def state(self, t: float, y: Vector) -> SceneState:
        """Return what functions of the user see of a state that begins with q, u and z."""
        return SweptState(self._frames, t, y)

    def sweeps(self, times: np.ndarray, states: Matrix) -> RunSweeps | None:
        """Return what is computed of all states of a run at once."""
        return Sweeps(self, times, states)

    @cached_property
    def force_kernel(self) -> ForceKernel:
        """What tells forces of states."""
        from kanefe.order_n.force_kernel import ForceKernel

        return ForceKernel(self.kernel_in_space, self.scene, self.complete)

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        found = Sweeps(self, np.array([t], dtype=float), np.asarray(y, dtype=float)[None]).balances[0, :3]
        return MechanicalEnergy(*found.tolist())

    @cached_property
    def balances(self) -> Bound:
        """What tells energies and momenta: see `kanefe.kernels.evaluation.momenta.balances_of_states`."""
        return balances_of_states.bound(self.scene, *(LATER,) * 3)

    @cached_property
    def watching(self) -> Watching:
        """The function that computes event values of loads with kernels for them."""
        return Watching(self)

    def asked_contacts(
        self, what: int, t: float, y: Vector, span: float = 0.0, stop: float = np.inf, rtol: float = 0.0
    ) -> ContactDecider:
        """Return what has decided an event of rigid contacts; the literal route's where only loops hold something."""
        from kanefe.order_n.contact_changing import decider_of

        looks = vars(self._looks)
        decider: ContactDecider | None = looks.get("decider")
        if decider is None:
            decider = looks["decider"] = decider_of(self)
        if decider.ask(what, t, y, span, stop, rtol):
            return decider
        return super().asked_contacts(what, t, y, span, stop, rtol)

    def evaluate(self, t: float, y: Vector) -> Evaluation:
        """Return the rates at a state; where something has only loops to hold it, those of the literal route."""
        rates, weakest = self.held_rates(t, y)
        if weakest >= NEAR_SINGULAR:
            return Evaluation(rates, weakest)
        if weakest > 0.0:
            return Evaluation(self.held_rates(t, self.projected(t, y))[0], weakest)
        return super().evaluate(t, y)._replace(is_own=False)

    def rates(self, t: float, y: Vector) -> Vector:
        """Return dy/dt of a state without quadratures."""
        found = self._rates_kernel(False).rates(t, y) if self._is_plain else None
        return super().rates(t, y) if found is None else found

    def held_rates(self, t: float, y: Vector) -> tuple[Vector, float]:
        """Return dy/dt, and the smallest pivot of the constraints: near zero they are better left to the literal route.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        kernel = self._rates_kernel(False)
        call = kernel.take()
        call.at[: len(y)] = y
        call.at[len(y) :] = 0.0
        weakest = self._sweep(call, t)
        rates = call.slope.copy()
        kernel.give_back(call)
        return rates, weakest

    def sweep_implicitly(
        self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float, share_of_rates: float = 0.0
    ) -> float:
        """Write a linearly implicit evaluation: see `sweep`.

        That of the nearest closed state near a singular position, as in `evaluate`; where only loops hold something
        that has no inertia, the plain rates, which a linearly implicit method may use as well.
        """
        shares = share_damping, share_stiffness, share_of_rates
        weakest = self.sweep(t, vectors, *shares)
        if weakest >= NEAR_SINGULAR:
            return weakest
        if weakest == 0.0:
            vectors[VECTOR.slope], weakest, _ = self.evaluate(t, vectors[VECTOR.at])
        else:
            asked = vectors[VECTOR.at].copy()
            vectors[VECTOR.at] = self.projected(t, asked)
            self.sweep(t, vectors, *shares)
            vectors[VECTOR.at] = asked
        return weakest

    def sweep(
        self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float, share_of_rates: float = 0.0
    ) -> float:
        """Write a linearly implicit evaluation to the second of four vectors; return the smallest pivot, see above.

        The first is the state; see `kanefe.kernels.sweeps.implicit` for the shares and for the other two, the pushes.
        """
        kernel = self._rates_kernel(True)
        call = kernel.take()
        call.vectors[:] = vectors
        call.share(True, share_damping, share_stiffness, share_of_rates)
        weakest = self._sweep(call, t)
        vectors[VECTOR.slope] = call.slope
        call.share(False, 0.0, 0.0, 0.0)
        kernel.give_back(call)
        return weakest

    def _sweep(self, call: RatesCall, t: float) -> float:
        if not self._inputs_stay:
            call.inputs[:] = self.values(t, call.at.copy())  # functions of the user may keep what they see
        if self._drives:
            call.drives[:] = self.drives(t)
        done, weakest = call(t)
        if done == NO_INERTIA:
            if self.has_loops:  # what has no inertia by itself may be held by a loop
                return 0.0
            self.explain(t, call.at)
        if done == NOT_FINITE:  # an integrator takes a smaller step; a load that is not a number is named
            self.values(t, call.at)
            self._check_determined(t, call.at, 0.0)
        return weakest

    def derivatives(self, t: float, y: Vector, directions: Matrix, reaches: Vector | None = None) -> Matrix | None:
        """Return derivatives of dy/dt along directions in the rows of a matrix, exact to round-off, or None."""
        if not self.inputs.needs_state:
            return self.partial_derivatives(t, y, directions)
        self._check_directions(y, directions)
        if reaches is None or not self.is_complex:
            return None
        from kanefe.order_n.function_derivatives import add_functions

        values = self.values(t, y)
        found = self._derivatives_with(values, t, y, directions)
        is_finite = add_functions(found, self, self._rates_kernel(False), t, y, values, directions, reaches)
        return found if is_finite else None

    def calls_for_derivatives(self, t: float, y: Vector, directions: Matrix) -> int:
        """Return how many calls of functions in Python derivatives along so many directions take at a state."""
        if not self.is_complex:
            return super().calls_for_derivatives(t, y, directions)
        from kanefe.order_n.function_derivatives import calls_for_derivatives

        return calls_for_derivatives(self, t, y, directions)

    def partial_derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix | None:
        """Return the same, with what functions of the user give held constant.

        Raises
        ------
        ModelError
            If the state or the directions have another shape: the kernel would read beyond them.
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        self._check_directions(y, directions)
        return self._derivatives_with(self.values(t, y), t, y, directions) if self.is_complex else None

    def _derivatives_with(self, values: np.ndarray, t: float, y: Vector, directions: Matrix) -> Matrix:
        """Return derivatives while loads have given values."""
        calls = self._derivative_calls
        call = calls.pop() if calls else self.derivative_call(len(y))
        done, found = call(t, y, self.drives(t), values, directions)
        calls.append(call)
        if not done:
            self.explain(t, y)
        return found

    def _check_directions(self, y: Vector, directions: Matrix) -> None:
        """Raise a ModelError if a state with quadratures, or directions beside it, have another shape."""
        size = self._run_size
        for name, given, is_right in (
            ("the state", y, np.shape(y) == (size,)),
            ("directions, one a row,", directions, np.ndim(directions) == 2 and np.shape(directions)[1] == size),
        ):
            if not is_right:
                raise ModelError(
                    f"derivatives: {name} of this model must have {size} entries, those of y and {QUADRATURES} "
                    f"energy quadratures, not shape {np.shape(given)}. Remedy: "
                    f"numpy.append(y, numpy.zeros({QUADRATURES})) for a state, and numpy.eye({size}) for all directions"
                )

    def derivative_call(self, size: int) -> DerivativeCall:
        """Return a call that differentiates the rates of states with quadratures, of that size."""
        return DerivativeCall(self.scene, size, len(self._drives), len(self.inputs.constants))

    def balance(self, run: Run) -> None:
        """Write what a method asks for by BALANCE: see `kanefe.kernels.evaluation.momenta`."""
        t, memory = float(step_of(run).time_at), np.empty(self.memory_size)
        arrays = StepArrays(run.integers, run.reals, run.vectors)
        balance(t, self.scene, self.drives(t), self.inputs.constants, arrays, memory)

    def projected(self, t: float, y: Vector, share: float = 0.0) -> Vector:
        """Return the nearest state at which loops are closed and stay closed; y itself if it is one.

        The literal route finds it where something has no inertia of its own, and names the loops that stay open.
        """
        if not self.has_loops:
            return y
        if self.model.free_count:
            closed = np.array(y, dtype=float)
            memory = np.empty(closing_memory_size(self.scene))
            ended, _ = self.closing(share, self.drives(t), closed, memory)
            if ended == ENDED.closed:
                return closed
        return super().projected(t, y, share)

    def wrenches_of_loads(self, t: float, y: Vector) -> dict[int, Matrix]:
        """Return the wrenches of loads between frames on their ends in N, from one sweep."""
        return self._state_kernels.wrenches_of_loads(t, y)

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free and the driven speeds at a state, from one sweep."""
        return self._state_kernels.mass_matrix(t, y)

    @cached_property
    def _state_kernels(self) -> StateKernels:
        return StateKernels(self, self._order)

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the power taken and given; of trees from one sweep."""
        if not self.model.has_power:
            return np.zeros(QUADRATURES)
        if self.model.constraints:
            return super().powers(t, y, du)
        return self.held_rates(t, y)[0][-QUADRATURES:]

    def check_functions(self, t: float, y: Vector) -> None:
        """Raise the error of a load or motion that gives no numbers at a state, or of Painleve's paradox.

        Towards that a force grows without bound, and a run ends a little before.
        """
        self.drives(t)
        for load in self.model.loads:
            load.check_at(t)
        self.values(t, y)
        self._check_determined(t, y, NEAR_PARADOX)

    def _check_determined(self, t: float, y: Vector, least: float) -> None:
        if self.model.rigid_contacts and np.all(np.isfinite(y)):
            from kanefe.literal.contact_forces import check_determined

            check_determined(self.view(t, y), max(least, LEAST_GAIN))

    def rates_call(self) -> RatesCall:
        """Return a call that evaluates the rates, which nobody else uses."""
        return self._rates_kernel(False).take()

    def compiled_run(
        self, integers: np.ndarray, reals: np.ndarray, vectors: np.ndarray, needs: MethodNeeds
    ) -> CompiledRun:
        """Return a run that stays in compiled code, of a method with that memory; the scene is autonomous."""
        from kanefe.order_n.compiled_run import CompiledRun  # a run's alone

        kernel = self._rates_kernel(needs.implicit, needs.balance)
        return CompiledRun(self, kernel, integers, reals, vectors, needs)

    def impact_steps(self, told: Vector, too_deep: float, bends: tuple[np.ndarray, np.ndarray]) -> ImpactSteps | None:
        """Return compiled steps over impacts, of one thread; None where a run calls functions in Python."""
        if not self.is_autonomous:
            return None
        from kanefe.order_n.impact_steps import ImpactSteps

        return ImpactSteps(self, told, too_deep, bends)

    def _rates_kernel(self, is_implicit: bool, is_balanced: bool = False) -> RatesKernel:
        """Return the kernel that evaluates the rates, in a run with the balance or else."""
        return self.kernel_in_space

    @cached_property
    def kernel_in_space(self) -> RatesKernel:
        """The kernel that evaluates the rates in space."""
        return self._kernel_of(evaluate.bound(LATER, self.scene, *(LATER,) * 4), self.memory_size)

    def _kernel_of(self, evaluation: Bound, memory_size: int) -> RatesKernel:
        """Return a kernel of rates."""
        return RatesKernel(evaluation, memory_size, self._run_size, len(self._drives), self.inputs.constants)

    @cached_property
    def closing(self) -> Bound:
        """What closes loops: see `close_state`."""
        return close_state.bound(LATER, self.scene, LATER, LATER, LATER)

    def explain(self, t: float, y: Vector) -> NoReturn:
        """Raise the error of the literal route for a state at which the sweep failed."""
        q, u, z = self.parts(y)
        if all(np.all(np.abs(x) < GROWN) for x in (q, u)):
            from kanefe.tree.bent import bent_too_far

            if bent := bent_too_far(self, t, q, u):
                raise SimulationError(f"at t = {t:.6g} s {bent}")
            self.accelerations_at(self.at(t, q, u, z))
        raise SimulationError(
            f"the equations of motion have no finite solution at t = {t:.6g} s. "
            "Remedy: check the loads for growth without bound, or take smaller steps"
        )


def obstacles_of(model: ModelData) -> tuple[Obstacle, ...]:
    """Return what keeps a scene from the order-n route; nothing: it is served."""
    flexible = [body.flexible for body in model.bodies if body.flexible is not None]
    if flexible:
        from kanefe.bodies.exact.inertia import BeamInertia
        from kanefe.bodies.mass_moments import MassMoments

        if not all(isinstance(terms.free_moments, (MassMoments, BeamInertia)) for terms in flexible):
            return (Obstacle("bodies in the nodal form", "models without a mass field"),)
    for body in model.bodies:
        if body.joint.links() is None:
            return (Obstacle("joints that give no links", f"that of {body.name!r}"),)
    return ()
