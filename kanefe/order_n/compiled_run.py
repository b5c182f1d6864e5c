"""A run of an autonomous scene in compiled code: the calls of its kernels, prepared once for the run."""

from __future__ import annotations

from typing import cast

import numpy as np

from kanefe.kernels.compiler.arrays import NOT_CALLED
from kanefe.kernels.compiler.entries import LATER, Call
from kanefe.kernels.constraints.closing import closing_memory_size
from kanefe.kernels.evaluation.momenta import balance
from kanefe.kernels.evaluation.stiff_directions import directions_memory_size, put_directions
from kanefe.kernels.events.closing_call import ClosingCall
from kanefe.kernels.events.watched_run import WatchedRun
from kanefe.kernels.steppers.integration import JacobianCall, Scene, integrate
from kanefe.kernels.steppers.sampling import pass_samples, progress_of
from kanefe.kernels.steppers.step_commands import NO_INERTIA, VECTOR, Command, Run, StepArrays, step_of
from kanefe.kernels.sweeps.drives import Drives
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.lookouts import Lookouts
from kanefe.order_n.rates_kernel import RatesKernel
from kanefe.tree.route import Answers, MethodNeeds
from kanefe.tree.scales import tangents, turning


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
        self._route, self._vectors, arrays = route, vectors, StepArrays(integers, reals, vectors)
        drives, inputs = np.zeros((len(route.model.drives), 3)), np.zeros_like(route.inputs.constants)
        closed, asked = np.zeros(vectors.shape[1]), np.zeros(vectors.shape[1])
        memory = np.zeros(kernel.memory_size)
        evaluated = kernel.prepared(drives, inputs, vectors, memory).for_kernels()
        closing = balanced = directed = NOT_CALLED
        if needs.directions:
            own = np.zeros(directions_memory_size(route.between, route.model.free_count + len(drives)))
            directions = put_directions.bound(route.scene, drives, inputs, arrays, memory, own)
            directed = directions.prepared().for_kernels()
        if route.has_loops:
            memory = np.zeros(closing_memory_size(route.scene))
            closing = route.closing.prepared(0.0, drives, closed, memory).for_kernels()
        if needs.balance:
            memory = np.zeros(route.memory_size)
            bound = balance.bound(0.0, route.scene, drives, inputs, arrays, memory)
            balanced = bound.prepared().for_kernels()
        motions = cast(Drives, route.motion_tables)  # of an autonomous scene
        derivatives = self._derivatives(needs.derivatives)
        loops = ClosingCall(route.has_loops, closing, motions, drives, closed)
        scene = Scene(evaluated, loops, balanced, directed, derivatives, drives, motions, route.fill, inputs, asked)
        self._inputs, self._integrate = inputs, integrate.bound(scene, LATER)
        self._lookouts = Lookouts(route, loops, inputs, vectors.shape[1])
        self._loops, self._sampling = loops, dict[int, Call]()
        self._going: Call | None = None
        self._given: Run | None = None

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
        evaluation, derivatives = call.evaluation.for_kernels(), done.for_kernels()
        turns = np.array(turning(route.model), dtype=np.int64).reshape(-1, 2)
        state, at = call.vectors.view(float), done.signature.number_count
        return JacobianCall(
            True, derivatives, evaluation, at, state, call.drives, call.inputs, turns, directions, found
        )

    def go_on(self, run: Run) -> int:
        """Continue without leaving compiled code; return what the method wants that is not to be had there.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        command, _ = self._begun(run)()
        return self._explained(command, run)

    def go_over_events(self, run: Run, watched: WatchedRun, restart_share: float) -> tuple[int, bool]:
        """Continue over events of loads, until one needs Python: see `pass_steps`."""
        command, is_done = self._lookouts.passing(self._begun(run), run, watched, restart_share)()
        return self._explained(int(command), run), bool(is_done)

    def go_over_samples(self, run: Run, sampler: Answers) -> int:
        """Continue over samples of controllers, whose functions are called where they are in Python: `pass_samples`."""
        going, samples = self._begun(run), sampler.samples
        call = self._sampling.get(id(samples.log))
        if call is None:
            command_at = going.signature.number_count
            given = going.for_kernels(), command_at, samples, self._loops, self._inputs
            call = self._sampling[id(samples.log)] = pass_samples.bound(*given, LATER).prepared(run)
        else:
            call.give(run)
        step, progress = step_of(run), progress_of(samples)
        state = step.state  # once: its place in the memory of the method is computed by name
        while (command := call()) == Command.SAMPLE and not progress.is_alarmed:
            sampler.answer(float(step.time), state)
        return self._explained(command, run)

    def _begun(self, run: Run) -> Call:
        """Return the call that continues a run; the arrays of outputs may be others each time."""
        route = self._route
        # controllers hold what is in the state
        self._inputs[:] = route.inputs.begun(route.parts(run.vectors[VECTOR.state])[2])
        if self._going is None:
            self._going = self._integrate.prepared(run)
        elif self._given is not run:
            self._going.give(run)
        self._given = run
        return self._going

    def prepared(
        self, run: Run, watched: WatchedRun | None, restart_share: float
    ) -> tuple[Call, Call | None, np.ndarray]:
        """Return the call of a run, that of a run over events, where it has any, and the values of loads they read."""
        call = self._begun(run)
        if watched is None:
            return call, None, self._inputs
        return call, self._lookouts.passing(call, run, watched, restart_share), self._inputs

    def values_at(self, run: Run, t: float) -> np.ndarray:
        """Return event values of loads at a time of the last step."""
        return self._lookouts.values_at(run, t)

    def _explained(self, command: int, run: Run) -> int:
        if command == NO_INERTIA:
            step = step_of(run)
            self._route.explain(float(step.time_at), step.at)
        return command
