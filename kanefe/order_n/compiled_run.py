"""A run of an autonomous scene in compiled code: the calls of its kernels, prepared once for the run."""

from __future__ import annotations

from typing import cast

import numpy as np

from kanefe.kernels.compiler.arrays import Prepared
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.constraints.closing import closing_memory_size
from kanefe.kernels.evaluation.momenta import balance
from kanefe.kernels.steppers.integration import JacobianCall, Scene, integrate
from kanefe.kernels.steppers.step_commands import AT, NO_INERTIA, STATE, TIME_AT, Run
from kanefe.kernels.steppers.steps_with_events import WatchedRun
from kanefe.kernels.sweeps.drives import Drives
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.lookouts import Lookouts
from kanefe.order_n.rates_kernel import RatesKernel
from kanefe.tree.route import MethodNeeds
from kanefe.tree.scales import tangents, turning

NOT_CALLED = Prepared(0, np.zeros(1, dtype=np.int64), np.zeros(1))


class CompiledRun:
    """A run that stays in compiled code: of one thread at a time, and not to be pickled.

    Parameters
    ----------
    route : Evaluated
        Of an autonomous scene.
    kernel : RatesKernel
        That the run takes.
    integers, reals, vectors : ndarray
        Memory of its method.
    needs : MethodNeeds
    """

    def __init__(
        self,
        route: Evaluated,
        kernel: RatesKernel,
        integers: np.ndarray,
        reals: np.ndarray,
        vectors: np.ndarray,
        needs: MethodNeeds,
    ) -> None:
        self._route, self._vectors = route, vectors
        drives, inputs = np.empty((len(route.model.drives), 3)), np.empty_like(route.inputs.constants)
        closed, asked = np.empty(vectors.shape[1]), np.empty(vectors.shape[1])
        self._kept: list[Call] = []  # of which the kernels know the addresses
        evaluated = self._for_kernels(kernel.prepared(drives, inputs, vectors))
        closing = balanced = NOT_CALLED
        if route.has_loops:
            memory = np.empty(closing_memory_size(route.tables, route.elastic, route.loops))
            closing = self._for_kernels(route.closing.prepared(0.0, drives, closed, memory))
        if needs.balance:
            tables, memory = (route.tables, route.elastic, route.between), np.empty(route.memory_size)
            bound = balance.bound(0.0, *tables, drives, inputs, integers, reals, vectors, memory)
            balanced = self._for_kernels(bound.prepared())
        motions = cast(Drives, route.motion_tables)  # of an autonomous scene
        derivatives = self._derivatives(needs.derivatives)
        scene = Scene(
            evaluated,
            closing,
            balanced,
            derivatives,
            route.has_loops,
            drives,
            motions,
            route.fill,
            inputs,
            closed,
            asked,
        )
        self._inputs, self._integrate = inputs, integrate.bound(scene, LATER, vectors)
        self._lookouts = Lookouts(route, motions, inputs, vectors)
        self._passing: tuple[Run, Call] | None = None

    def _derivatives(self, are_needed: bool) -> JacobianCall:
        """Return what differentiates the rates; nothing where that is not exact, or Python has to say why."""
        route, size = self._route, self._vectors.shape[1]
        if not are_needed or route.inputs.needs_state or not route.is_complex:
            none = np.zeros((0, 0))
            return JacobianCall(
                False, NOT_CALLED, NOT_CALLED, 0, none, none, np.zeros(0), np.zeros((0, 2), dtype=np.int64), none, none
            )
        call, directions = route.derivative_call(size), tangents(route.model).copy()
        found = np.zeros_like(directions)
        done = call.prepared(directions, found)
        evaluation, derivatives = self._for_kernels(call.evaluation), self._for_kernels(done)
        turns = np.array(turning(route.model), dtype=np.int64).reshape(-1, 2)
        state, at = call.vectors.view(float), done.signature.number_count
        return JacobianCall(
            True, derivatives, evaluation, at, state, call.drives, call.inputs, turns, directions, found
        )

    def _for_kernels(self, call: Call) -> Prepared:
        self._kept.append(call)
        return call.for_kernels()

    def go_on(self, run: Run) -> int:
        """Continue without leaving compiled code; return what the method wants that is not to be had there.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        route, vectors = self._route, self._vectors
        self._inputs[:] = route.inputs.begun(route.parts(vectors[STATE])[2])  # controllers hold what is in STATE
        command, _ = self._integrate(run)
        return self._explained(command, run)

    def go_over_events(self, run: Run, watched: WatchedRun, restart_share: float) -> tuple[int, bool]:
        """Continue over events of loads, until one needs Python: see `pass_steps`."""
        self._inputs[:] = self._route.inputs.begun(self._route.parts(self._vectors[STATE])[2])
        if self._passing is None or self._passing[0] is not run:
            call = self._lookouts.passing(self._integrate.prepared(run), run, watched, restart_share)
            self._passing = run, call
        command, is_done = self._passing[1]()
        return self._explained(int(command), run), bool(is_done)

    def prepared(
        self, run: Run, watched: WatchedRun | None, restart_share: float
    ) -> tuple[Call, Call | None, list[Call], np.ndarray]:
        """Return the call of a run, that of a run over events, where it has any, and what both need.

        That is the calls that they make by their address, and the values of loads that they read.
        """
        self._inputs[:] = self._route.inputs.begun(self._route.parts(self._vectors[STATE])[2])
        call = self._integrate.prepared(run)
        if watched is None:
            return call, None, list(self._kept), self._inputs
        passing = self._lookouts.passing(call, run, watched, restart_share)
        return call, passing, [*self._kept, *self._lookouts.kept], self._inputs

    def values_at(self, run: Run, t: float) -> np.ndarray:
        """Return event values of loads at a time of the last step."""
        return self._lookouts.values_at(run, t)

    def _explained(self, command: int, run: Run) -> int:
        if command == NO_INERTIA:
            self._route.explain(float(run.reals[TIME_AT]), self._vectors[AT])
        return command
