"""The order-n route of a frozen model: tables, the values of its loads, and the calls of the kernels.

What the literal route (`kanefe.kane`) computes from dense matrices is here computed in sweeps over the tree, in time
proportional to the number of bodies. Objects are read-only after they are made: several threads may use one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import accelerations, all_speeds
from kanefe.kernels._numba import filler
from kanefe.kernels.closing import CLOSED, close_loops
from kanefe.kernels.derivatives import derivatives
from kanefe.kernels.drives import Drives
from kanefe.kernels.march import march, room_size
from kanefe.kernels.momenta import balance
from kanefe.kernels.outward import frames_of_rows
from kanefe.kernels.planar.march import march_planar
from kanefe.kernels.planar.march import room_size as planar_room_size
from kanefe.kernels.stepping import AT, NO_INERTIA, NOT_FINITE, PUSH_STIFFNESS, SLOPE, TIME_AT, Run
from kanefe.loads import Bushing, SpringDamper
from kanefe.order_n.constraint_tables import loop_tables
from kanefe.order_n.drive_tables import drive_tables
from kanefe.order_n.load_tables import interaction_tables
from kanefe.order_n.planar_tables import floats_in_plane, planar_tables
from kanefe.order_n.seats import Seat
from kanefe.order_n.tables import TableBuilder
from kanefe.tree.model_data import WORKS, ModelData
from kanefe.tree.scene_state import SceneState

GROWN = 1e100
"""Coordinates and speeds beyond which squares overflow: there is no scene left to explain."""

NO_DRIVES = np.zeros((0, 3))


@dataclass(slots=True)
class Placed:
    """Motion of a frame F: position in N (m), A_NF, velocity (m/s) and angular velocity (rad/s) in components of F."""

    p_NoFo_N: Vector
    A_NF: Matrix
    v: Vector
    w: Vector


class OrderN:
    """The equations of motion of a model in order n.

    Parameters
    ----------
    model : ModelData
        Without an `obstacle`.
    """

    def __init__(self, model: ModelData) -> None:
        self._model = model
        builder = TableBuilder(model)
        self.tables, self.flexible = builder.tables()
        self.between = interaction_tables(builder)
        self.loops = loop_tables(builder)
        self.planar = planar_tables(model, self.tables)
        # the kernels of the plane take the coordinates of a planar joint at once, without stiffness along them
        self._is_planar_if_implicit = not any(
            body.has_coordinate_forces and floats_in_plane(body.joint) for body in model.bodies
        )
        self._sizes = model.coordinate_count, model.free_count
        self._room = room_size(self.tables, self.flexible, self.loops, sum(self._sizes) + WORKS)
        self._planar_room = 0 if self.planar is None else planar_room_size(self.planar)
        self.seats: Sequence[Seat] = tuple(builder.seats)
        self.inputs = builder.inputs
        self._constants = self.inputs.constants if self.inputs.is_constant else None
        parts = tuple(self.inputs.compiled())
        self._has_compiled_loads = bool(parts)
        self._fill = filler(parts)
        self._drives = model.drives
        self._motions = drive_tables(model)

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
        values = [[motion.at(what, t, name) for what in names] for motion, name in self._drives]
        return np.array(values).reshape(-1, 3)

    def values(self, t: float, q: Vector, u: Vector) -> np.ndarray:
        """Return the values of all loads at a state."""
        layout = self.inputs
        if layout.is_constant:
            return layout.constants
        values = layout.constants.copy()
        for where, load in layout.of_time:
            values[where] = load.value(t, None)
        if layout.needs_state:
            state = SceneState(self._model, t, q, all_speeds(self._model, t, u), self.frames(t, q, u))
            for where, load in layout.of_state:
                values[where] = load.value(t, state)
            for where, item in layout.laws:
                values[where] = _law_of(item, t, state)
        return values

    def frames(self, t: float, q: Vector, u: Vector) -> list[Placed]:
        """Return the motion of every body's frame."""
        work = frames_of_rows(self.tables, self.flexible, self.drives(t), q, u)
        return [_placed(work, seat) for seat in self.seats]

    def rates(self, t: float, y: Vector) -> Vector:
        """Return dy/dt of ``y = (q, u, dissipated energy, work)``; see `held_rates` for what it raises."""
        return self.held_rates(t, y)[0]

    def held_rates(self, t: float, y: Vector) -> tuple[Vector, float]:
        """Return dy/dt, and the smallest pivot of the constraints: near zero they are better left to the literal route.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        vectors = np.empty((2, len(y)))
        vectors[AT] = y
        weakest = self.evaluate(t, vectors)
        return vectors[SLOPE], weakest

    def evaluate(
        self, t: float, vectors: np.ndarray, share_damping: float = 0.0, share_stiffness: float = 0.0
    ) -> float:
        """Write dy/dt of the state in the first row of vectors to the second; return the smallest pivot, see above.

        With four rows or more the evaluation is linearly implicit: see `kanefe.kernels.implicit` for the shares and
        for the two rows of pushes.
        """
        n, m = self._sizes
        y, shares = vectors[AT], (share_damping, share_stiffness)
        inputs, drives = self.values(t, y[:n], y[n : n + m]), self.drives(t)
        is_implicit = len(vectors) > PUSH_STIFFNESS
        done, weakest = self._march(drives, None, None, t, inputs, vectors, shares, None, is_implicit=is_implicit)
        if done == NO_INERTIA:
            if self.loops is not None:  # what has no inertia by itself may be held by a loop
                return 0.0
            self._explain(t, y[:n], y[n : n + m])
        if done == NOT_FINITE:  # an integrator takes a smaller step; a load that is not a number is named
            self.values(t, y[:n], y[n : n + m])
        return weakest

    def derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix:
        """Return derivatives of dy/dt along directions in the rows of a matrix, (k, state) both; exact to round-off.

        Functions of the user that look at the state count as constant: their derivatives are not known.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        n, m = self._sizes
        vectors = np.empty((2, len(y)), dtype=complex)
        vectors[AT] = y
        inputs = self.values(t, y[:n], y[n : n + m])
        found = np.empty((len(directions), len(y)))
        scene = self.tables, self.flexible, self.between, self.loops
        try:
            is_regular = derivatives(
                *scene, self.drives(t), inputs, vectors, directions, found, np.empty(self._room, complex)
            )
        except ZeroDivisionError:  # numba divides complex numbers like Python, whatever its error model
            is_regular = False
        if not is_regular:
            self._explain(t, y[:n], y[n : n + m])
        return found

    def balance(self, run: Run, vectors: np.ndarray) -> None:
        """Write what a method asks for by BALANCE: see `kanefe.kernels.momenta`."""
        scene = self.tables, self.flexible, self.between
        balance(*scene, self.drives(float(run.reals[TIME_AT])), run.integers, run.reals, vectors)

    def closed(self, t: float, q: Vector, u: Vector, share_stiffness: float = 0.0) -> tuple[Vector, Vector] | None:
        """Return the nearest coordinates at which the loops are closed, and speeds that keep them so.

        The nearest in the metric ``M + r K`` with a share r (s2) of the stiffness of modes and joints. None if the
        literal route has to find them: it can, where something has no inertia of its own, or names the loops that stay
        open.
        """
        if self.loops is None:
            return q, u
        q, u = q.copy(), u.copy()
        ended, _ = close_loops(self.tables, self.flexible, self.loops, self.drives(t), share_stiffness, q, u)
        return (q, u) if ended == CLOSED else None

    def go_on(self, run: Run, vectors: np.ndarray, is_implicit: bool, is_balanced: bool = False) -> int:
        """Go on with a run without leaving compiled code; return what its method wants that is not to be had there.

        The scene is autonomous. `is_implicit`, `is_balanced`: whether the method asks for linearly implicit
        evaluations, and for energy and momenta.

        Raises
        ------
        SimulationError
            If the mass matrix is singular; the message names the speeds without inertia.
        """
        n, m = self._sizes
        drives, inputs = np.empty((len(self._drives), 3)), self.inputs.constants.copy()
        moved, none = (drives, self._motions, self._fill), (0.0, 0.0)
        command, _ = self._march(
            *moved, 0.0, inputs, vectors, none, run, is_implicit=is_implicit, is_balanced=is_balanced
        )
        if command == NO_INERTIA:
            y = vectors[AT]
            self._explain(float(run.reals[TIME_AT]), y[:n], y[n : n + m])
        return command

    def _march(
        self,
        drives: np.ndarray,
        motions: Drives | None,
        fill: Callable[..., None] | None,
        t: float,
        inputs: np.ndarray,
        vectors: np.ndarray,
        shares: tuple[float, float],
        run: Run | None,
        *,
        is_implicit: bool,
        is_balanced: bool = False,
    ) -> tuple[int, float]:
        """Call the kernel of the scene: that of the plane for planar ones, else that of space."""
        rest = drives, motions, fill, t, inputs, vectors, *shares, run
        if self.planar is not None and (self._is_planar_if_implicit or not is_implicit) and not is_balanced:
            return march_planar(self.planar, *rest, np.empty(self._planar_room))
        return march(self.tables, self.flexible, self.between, self.loops, *rest, np.empty(self._room))

    def _explain(self, t: float, q: Vector, u: Vector) -> None:
        """Raise the error of the literal route for a state at which the sweep failed."""
        if all(np.all(np.abs(x) < GROWN) for x in (q, u)):
            accelerations(self._model, t, q, u)
        raise SimulationError(
            f"the equations of motion have no finite solution at t = {t:.6g} s. "
            "Remedy: check the loads for growth without bound, or take smaller steps"
        )


class Obstacle(NamedTuple):
    """What of a scene the kernels do not have, in words: of which kind it is, and more of it."""

    kind: str
    detail: str


def obstacle(model: ModelData) -> Obstacle | None:
    """Return what keeps a scene from the order-n route; None: nothing does."""
    for body in model.bodies:
        if body.flexible is not None and not isinstance(body.flexible.free_moments, MassMoments):
            return Obstacle("bodies in the nodal form", "matrices of nodes that rotate")
    for body in model.bodies:
        if body.joint.links() is None:
            return Obstacle("joints that give no links", f"that of {body.name!r}")
    return None


def _placed(work: np.ndarray, seat: Seat) -> Placed:
    if seat.row < 0:
        return Placed(seat.place, seat.axes, np.zeros(3), np.zeros(3))
    p, R, v, w = work[seat.row, :3], work[seat.row, 3:12].reshape(3, 3), work[seat.row, 12:15], work[seat.row, 15:18]
    lever, A = R @ seat.place, R @ seat.axes
    return Placed(p + lever, A, A.T @ (v + np.cross(w, lever)), A.T @ w)


def _law_of(item: SpringDamper | Bushing, t: float, state: SceneState) -> Any:
    """Return what the user's law of a spring or bushing gives at a state."""
    (p_a, A_a, v_a, w_a), (p_b, A_b, v_b, w_b) = state.marker(item.a), state.marker(item.b)
    line = p_b - p_a
    if isinstance(item, SpringDamper):
        length = float(np.linalg.norm(line))
        return item.given(t, length, float(line @ (v_b - v_a)) / length)
    rates = np.concatenate((A_a.T @ (v_b - v_a - np.cross(w_a, line)), A_a.T @ (w_b - w_a)))
    return item.given(t, A_a.T @ A_b, A_a.T @ line, rates)
