"""The first-order form of a model: what the integrators see."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.assembly import consistent_start, project_positions, project_speeds
from kanefe.equations_of_motion import WORKS
from kanefe.frames import Matrix, Vector
from kanefe.integrate.scales import coordinate_moves, state_scales
from kanefe.kane.assemble import accelerations, held_accelerations
from kanefe.kane.energy import dissipated_power, drive_power, load_power
from kanefe.kane.tangents import elastic_stiffness
from kanefe.kernels.tolerances import NEAR_SINGULAR
from kanefe.model import Model

if TYPE_CHECKING:
    from kanefe.kernels.stepping import Run


DIFFERENCE = 1e-5
"""Of what is large: how far central differences go. Truncation and cancellation are both some 1e-10 then."""


class Dynamics:
    """State ``y = (q, u, dissipated energy, work of loads and drives)`` and its rate.

    Attributes
    ----------
    model : Model
    evaluations : int
        How often the equations of motion were evaluated.
    weakest : float
        Of the constraints at the last evaluation: see `ConstrainedSolver.weakest`.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.evaluations = 0
        self.weakest = 1.0
        self._order_n = model.order_n
        self._is_in_order_n = True  # but for evaluations with something that has inertia only through loops

    @property
    def is_autonomous(self) -> bool:
        """Whether whole runs can stay in compiled code."""
        return self._order_n is not None and self._order_n.is_autonomous

    @property
    def calls_functions(self) -> bool:
        """Whether loads or drives are functions of the user, which may change within a step."""
        is_constant = self._order_n is not None and self._order_n.inputs.is_constant
        return not is_constant or any(motion.pieces is None for motion, _ in self.model.drives)

    @property
    def has_kinks(self) -> bool:
        """Whether forces may jump or begin at once: those of stops and friction, and functions of the user."""
        return self.calls_functions or self.model.has_stops

    @property
    def is_tree_in_order_n(self) -> bool:
        """Whether the rates come from one sweep over a tree."""
        return self._order_n is not None and not self.model.constraints

    def go_on(self, run: Run, vectors: np.ndarray, is_implicit: bool, is_balanced: bool) -> int:
        """Go on with a run in compiled code: see `OrderN.go_on`; the scene is autonomous."""
        if self._order_n is None:
            raise TypeError("this scene needs the literal route")
        return self._order_n.go_on(run, vectors, is_implicit, is_balanced)

    def balance(self, run: Run, vectors: np.ndarray) -> None:
        """Write energy and momenta: see `OrderN.balance`."""
        if self._order_n is None:
            raise TypeError("this scene needs the literal route")
        self._order_n.balance(run, vectors)

    def name_what_is_not_finite(self, t: float, y: Vector) -> None:
        """Raise the ModelError of a load or motion that gives no numbers at a state; none if all do."""
        if self._order_n is not None:
            self._order_n.drives(t)
            self._order_n.values(t, *self.parts(y))

    def implicit_rate(self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float) -> None:
        """Write a linearly implicit evaluation: see `OrderN.evaluate`.

        That of the nearest closed state near a singular position, as in `rate`; where only loops hold something that
        has no inertia, the plain rates, which a linearly implicit method may use as well.
        """
        if self._order_n is None:
            raise TypeError("this scene needs the literal route")
        self.evaluations += 1
        self.weakest = self._order_n.evaluate(t, vectors, share_damping, share_stiffness)
        self._is_in_order_n = self.weakest > 0.0
        if self.weakest >= NEAR_SINGULAR:
            return
        from kanefe.kernels.stepping import AT, SLOPE  # it imports numba

        if not self._is_in_order_n:
            vectors[SLOPE] = self.rate(t, vectors[AT])
        else:
            asked = vectors[AT].copy()
            vectors[AT] = self.projected(t, asked)
            self._order_n.evaluate(t, vectors, share_damping, share_stiffness)
            vectors[AT] = asked

    def initial_state(self, start: float) -> Vector:
        """Return y at the start, consistent with the loops at that time (s)."""
        return np.concatenate((*consistent_start(self.model, start), np.zeros(WORKS)))

    def projected(self, t: float, y: Vector, stiffness: Matrix | None = None, share: float = 0.0) -> Vector:
        """Return the nearest state at which loops are closed and stay closed; y itself if it is one.

        `stiffness`, (free, free), or a share (s2) of that of modes and joints, is added to the mass matrix, in whose
        metric the state is the nearest.
        """
        if not self.model.constraints:
            return y
        q, u = self.parts(y)
        if self._order_n is not None and stiffness is None and self.model.free_count:
            found = self._order_n.closed(t, q, u, share)
            if found is not None:
                return np.concatenate((*found, y[len(q) + len(u) :]))
        if share > 0.0:
            stiffness = share * elastic_stiffness(self.model)
        q_closed = project_positions(self.model, t, q, stiffness)
        u_closed = project_speeds(self.model, t, q_closed, u, stiffness)
        if q_closed is q and u_closed is u:
            return y
        return np.concatenate((q_closed, u_closed, y[len(q) + len(u) :]))

    def parts(self, y: Vector) -> tuple[Vector, Vector]:
        """Return q and u of a state."""
        n = self.model.coordinate_count
        return y[:n], y[n : n + self.model.free_count]

    def rate(self, t: float, y: Vector) -> Vector:
        """Return dy/dt."""
        self.evaluations += 1
        if self._order_n is not None:
            rates, self.weakest = self._order_n.held_rates(t, y)
            self._is_in_order_n = self.weakest > 0.0
            if self.weakest >= NEAR_SINGULAR:
                return rates
            if self.weakest > 0.0:
                return self._order_n.rates(t, self.projected(t, y))
        q, u = self.parts(y)
        if self.model.constraints:
            du, _, self.weakest = held_accelerations(self.model, t, q, u)
            if self.weakest < NEAR_SINGULAR:
                q, u = self.parts(self.projected(t, y))
                du = accelerations(self.model, t, q, u)
        else:
            du = accelerations(self.model, t, q, u)
        return np.concatenate((self.model.coordinate_rates(q, u), du, self.powers(t, q, u, du)))

    def tangent_derivatives(self, t: float, y: Vector) -> Matrix:
        """Return derivatives of the rates of speeds and quadratures by tangents, then by speeds.

        Shape (free + quadratures, 2 free). A tangent is a change of the coordinates in the direction of a speed, of a
        rotation the rotation vector in the moving frame.
        """
        n = self.model.coordinate_count
        directions = self._tangents.copy()
        for at, speed in self._turning:
            # rates of Euler parameters by the angular velocity, in the frame that turns
            e0, e1, e2, e3 = 0.5 * y[at : at + 4]
            directions[speed : speed + 3, at : at + 4] = (-e1, e0, e3, -e2), (-e2, -e3, e0, e1), (-e3, e2, -e1, e0)
        return self._derivatives(t, y, directions)[:, n:].T

    @cached_property
    def _tangents(self) -> Matrix:
        """Directions of the state in which tangents and speeds are, (2 free, state); those of rotations left out."""
        n, m = self.model.coordinate_count, self.model.free_count
        directions = np.eye(2 * m, n + m + WORKS, k=n - m)
        directions[:m] = 0.0
        for turns, at, speed in coordinate_moves(self.model):
            if not turns:
                directions[speed, at] = 1.0
        return directions

    @cached_property
    def _turning(self) -> list[tuple[int, int]]:
        """First of the Euler parameters, and of the speeds, of each rotation."""
        return [(at, speed) for turns, at, speed in coordinate_moves(self.model) if turns]

    def jacobian(self, t: float, y: Vector) -> Matrix:
        """Return d(dy/dt)/dy, (state, state)."""
        directions = np.eye(len(y))[: len(y) - WORKS]  # nothing depends on the quadratures
        return np.vstack((self._derivatives(t, y, directions), np.zeros((WORKS, len(y))))).T

    def _derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix:
        """Return derivatives of dy/dt along directions, (k, state) both.

        Exact to round-off where the scene is in order n and no function of the user looks at the state; else by central
        differences.
        """
        order_n = self._order_n
        is_exact = self._is_in_order_n and self.weakest >= NEAR_SINGULAR
        if order_n is not None and not order_n.inputs.needs_state and is_exact:
            self.evaluations += len(directions)
            return order_n.derivatives(t, y, directions)
        reaches = DIFFERENCE / np.abs(directions / self._scales).max(axis=1)
        found = np.empty_like(directions)
        with np.errstate(over="ignore", invalid="ignore"):
            for i, (direction, reach) in enumerate(zip(directions, reaches, strict=True)):
                ahead, behind = self.rate(t, y + reach * direction), self.rate(t, y - reach * direction)
                found[i] = (ahead - behind) / (2.0 * reach)
        return found

    @cached_property
    def _scales(self) -> Vector:
        return state_scales(self.model)

    def powers(self, t: float, q: Vector, u: Vector, du: Vector) -> Vector:
        """Return the rates of the quadratures, in W; nothing is computed where nothing exchanges energy."""
        if not self.model.has_power:
            return np.zeros(WORKS)
        if self.is_tree_in_order_n and self._order_n is not None:
            return self._order_n.rates(t, np.concatenate((q, u, np.zeros(WORKS))))[-WORKS:]
        work = load_power(self.model, t, q, u) + drive_power(self.model, t, q, u, du)
        return np.array((dissipated_power(self.model, t, q, u), work))
