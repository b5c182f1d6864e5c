"""All states of a run at once: frames, rates, energies and momenta from one compiled sweep each."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import (
    Matrix,
    cross,
    euler_parameters_from_matrices,
    euler_parameters_from_matrix,
    multiply,
)
from kanefe.kernels.evaluation.momenta import Balance
from kanefe.kernels.evaluation.replay import STATE_OF, TIME_OF, between_states, revisit
from kanefe.kernels.loads.telling import States
from kanefe.kernels.scene import Scene, links_of, memory_size
from kanefe.kernels.steppers.step_commands import Command, Run, Step
from kanefe.kernels.sweeps.outward import motions_of_rows
from kanefe.kernels.tree import Kind
from kanefe.kernels.values.filled import allocate
from kanefe.order_n.evaluated import Evaluated
from kanefe.order_n.load_outputs import LoadOutputs
from kanefe.order_n.run_forces import CompiledForces
from kanefe.order_n.tables.frame_offsets import FrameOffset, FrameOffsets
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.route import MethodNeeds
from kanefe.tree.run_sweeps import FrameMotions, OutputFunction

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


class Sweeps:
    """States of a run, and quantities of all of them that are computed on request, each once: see `RunSweeps`.

    Parameters
    ----------
    route : Evaluated
    times : ndarray, shape (T,)
        s.
    states : ndarray, shape (T, coordinates + free + states)
    """

    def __init__(self, route: Evaluated, times: np.ndarray, states: np.ndarray) -> None:
        self._route, self._times = route, times
        self._states = np.ascontiguousarray(states)
        self._turns: dict[int, Matrix] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return Sweeps, (self._route, self._times, self._states)  # tables have addresses, which are those of a process

    @cached_property
    def _drives(self) -> np.ndarray:
        return self._route.drives_over(self._times)

    @cached_property
    def placed(self) -> tuple[FrameOffsets, Scene]:
        """Where all frames are in the rows, those of interfaces with nothing attached included, and the rows."""
        route = self._route
        flexible = [(i, body.flexible) for i, body in enumerate(route.model.bodies) if body.flexible is not None]
        wanted = {(i, frame.name) for i, terms in flexible for frame in terms.body.interfaces}
        if wanted <= route.places.interfaces.keys():
            return route.places, route.scene
        return route.complete

    @cached_property
    def _moving(self) -> np.ndarray:
        """How all rows move; with accelerations if these are known by now."""
        known = self.__dict__.get("_accelerated")
        return self._motions(np.zeros((0, self._route.model.free_count)), 18) if known is None else known

    @cached_property
    def _accelerated(self) -> np.ndarray:
        n, m = self._route.model.coordinate_count, self._route.model.free_count
        return self._motions(np.ascontiguousarray(self.rates[:, n : n + m]), 24)

    def _motions(self, rates: np.ndarray, width: int) -> np.ndarray:
        """Return how all rows move, (T, rows, width)."""
        scene = self.placed[1]
        found = np.empty((len(self._times), len(scene.tables.rows), width))
        motions_of_rows(scene, self._drives, self._states, rates, found, np.empty(memory_size(scene)))
        return found

    def frame(self, number: int, interface: InterfaceFrame | None, is_accelerated: bool = False) -> FrameMotions:
        """Return the motion of a body's frame or of one of its interfaces, at all times."""
        frame_offset, T = self.frame_offset(number, interface), len(self._times)
        if frame_offset.row < 0:
            none = np.zeros((T, 3))
            return FrameMotions(
                np.tile(frame_offset.place, (T, 1)), np.tile(frame_offset.axes, (T, 1, 1)), none, none, none, none
            )
        found = self._row(frame_offset.row, is_accelerated)
        if frame_offset.is_row:
            return found
        p, axes, v, w, a, alpha = found
        rows = axes.reshape(-1, 3)  # of all matrices, of which one product is faster than T small ones
        if frame_offset.place.any():
            lever = (rows @ frame_offset.place).reshape(T, 3)
            swing = cross(w, lever)
            p, v = p + lever, v + swing
            if a is not None and alpha is not None:
                a = a + cross(alpha, lever) + cross(w, swing)
        return FrameMotions(p, (rows @ frame_offset.axes).reshape(T, 3, 3), v, w, a, alpha)

    def _row(self, row: int, is_accelerated: bool = False) -> FrameMotions:
        """Return the motion of a row; what is read of it at all times lies side by side."""
        x = np.ascontiguousarray((self._accelerated if is_accelerated else self._moving)[:, row])
        a, alpha = (x[:, 18:21], x[:, 21:24]) if is_accelerated else (None, None)
        return FrameMotions(x[:, :3], x[:, 3:12].reshape(-1, 3, 3), x[:, 12:15], x[:, 15:18], a, alpha)

    def rotation(self, number: int, interface: InterfaceFrame | None) -> Matrix:
        """Return the Euler parameters of a frame, (T, 4), continuous in the coordinates of the joints."""
        frame_offset, T = self.frame_offset(number, interface), len(self._times)
        e = self._turn(frame_offset.row)
        if not frame_offset.is_row:
            e = multiply(e, euler_parameters_from_matrix(frame_offset.axes)[None])
        if len(e) < T:  # nothing turns
            e = np.tile(e, (T, 1))
        e = e / np.linalg.norm(e, axis=1)[:, None]
        first = self._row(frame_offset.row).axes[0] if frame_offset.row >= 0 else np.eye(3)
        is_other = float(e[0] @ euler_parameters_from_matrix(first @ frame_offset.axes)) < 0.0
        return -e if is_other else e

    def _turn(self, row: int) -> Matrix:
        """Return the Euler parameters of a row: those of its links, which know how often they have turned."""
        links, chain = links_of(self.placed[1]), []
        while row >= 0 and row not in self._turns:
            chain.append(row)
            row = links[row].parent
        e = self._turns[row] if row >= 0 else np.array(((1.0, 0.0, 0.0, 0.0),))
        for link in reversed(chain):
            self._turns[link] = e = self._turned(e, link)
        return e

    def _turned(self, e: Matrix, row: int) -> Matrix:
        """Return the Euler parameters of a row from those of the row that carries it."""
        link = links_of(self.placed[1])[row]
        axes = np.eye(3) if link.kind == Kind.INTERFACE else np.array(link.axes.numbers).reshape(3, 3)
        if not np.array_equal(axes, np.eye(3)):
            e = multiply(e, euler_parameters_from_matrix(axes)[None])
        if link.kind in (Kind.SPHERICAL, Kind.FREE):
            first = link.coordinate + (3 if link.kind == Kind.FREE else 0)
            return multiply(e, self._states[:, first : first + 4])
        if link.kind <= Kind.AXIS:
            about = link.about if link.kind == Kind.AXIS else float(link.kind == Kind.REVOLUTE)
            if not about:
                return e
            angle = about * (self._drives[:, link.drive, 0] if link.drive >= 0 else self._states[:, link.coordinate])
            c, s = np.cos(0.5 * angle), np.sin(0.5 * angle)
            e0, e1, e2, e3 = e.T
            return np.array((e0 * c - e3 * s, e1 * c + e2 * s, e2 * c - e1 * s, e3 * c + e0 * s)).T  # about z
        # an interface, or a link whose function gives its axes: turns that are looked up
        here = self._row(row).axes
        before = self._row(link.parent).axes if link.parent >= 0 else np.eye(3)[None]
        own = euler_parameters_from_matrices((before @ axes).transpose(0, 2, 1) @ here)
        own[1:] *= np.cumprod(np.where(np.sum(own[1:] * own[:-1], axis=1) < 0.0, -1.0, 1.0))[:, None]
        return multiply(e, own)

    def frame_offset(self, number: int, interface: InterfaceFrame | None) -> FrameOffset:
        """Return where a frame sits; that of an interface with its own axes."""
        frame_offset = self.placed[0].frame_offset(number, interface)
        return (
            frame_offset
            if interface is None
            else FrameOffset(frame_offset.row, frame_offset.axes @ interface.axes, frame_offset.place)
        )

    @cached_property
    def forces(self) -> CompiledForces:
        """The forces of all states."""
        is_known = self._route.is_autonomous and not self._route.model.is_constrained
        rates = self.rates if is_known else np.zeros((0, self._states.shape[1] + QUADRATURES))
        given = self._times, self._drives, self._states, np.ascontiguousarray(rates)
        return CompiledForces(self._route, *given, self._accelerated_frame)

    def _accelerated_frame(self, number: int) -> FrameMotions:
        return self.frame(number, None, is_accelerated=True)

    def outputs_of_loads(self, functions: Mapping[int, tuple[OutputFunction, int]]) -> dict[int, Matrix]:
        """Return what compiled functions tell of some loads, by their numbers."""
        outputs = LoadOutputs(self._route, functions)
        values = self._route.values_over(self._times, self._states)
        call, found = outputs.prepared(self._times, self._drives, values, self._states)
        call()
        return {number: found[:, columns].copy() for number, columns in outputs.columns.items()}

    @cached_property
    def rates(self) -> Matrix:
        """The rates dy/dt of all states, (T, state and quadratures)."""
        route, T = self._route, len(self._times)
        size = self._states.shape[1] + QUADRATURES
        table = np.zeros((T, STATE_OF + size))
        table[:, TIME_OF], table[:, STATE_OF:-QUADRATURES] = self._times, self._states
        if not route.is_autonomous:
            for row in table:
                row[STATE_OF:] = route.evaluate(float(row[TIME_OF]), row[STATE_OF:].copy()).rates
            return table[:, STATE_OF:]
        for first, last in self._unchanged():
            self._revisit(table[first:last])
        return table[:, STATE_OF:]

    def _unchanged(self) -> list[tuple[int, int]]:
        """Return between which states controllers hold the same."""
        T, held = len(self._times), [state for _, state, _ in self._route.inputs.held]
        z = self._states[:, [self._route.model.coordinate_count + self._route.model.free_count + at for at in held]]
        jumps = (1 + np.flatnonzero(np.any(z[1:] != z[:-1], axis=1))).tolist()
        return list(zip((0, *jumps), (*jumps, T), strict=True))

    def _revisit(self, table: Matrix) -> None:
        """Write the rates of the states in a table, see `kanefe.kernels.evaluation.replay`, in their place."""
        route, size = self._route, table.shape[1] - STATE_OF
        integers, reals, numbers = allocate(Step, size=size)
        vectors, step = numbers.reshape(-1, size), Step(integers, reals, numbers)
        step.state[:] = table[0, STATE_OF:]
        none = np.zeros(0), np.zeros((0, size)), 0, np.zeros(1, dtype=np.int64)
        run = Run(revisit, between_states, integers, reals, vectors, table, *none)
        compiled = route.compiled_run(integers, reals, vectors, MethodNeeds())
        while compiled.go_on(run) != Command.DONE:  # at a singular position
            step.slope[:] = route.evaluate(float(step.time_at), step.at.copy()).rates

    @cached_property
    def balances(self) -> Matrix:
        """Kinetic, elastic and gravity energy (J), linear and angular momentum about N's origin, (T, 9)."""
        route, found = self._route, np.empty((len(self._times), Balance.number_count))
        inputs = route.inputs.constants[None]
        if route.inputs.between:
            inputs = route.values_over(self._times, self._states)
        route.balances(States(self._times, self._drives, inputs, self._states), found, np.empty(route.memory_size))
        return found
