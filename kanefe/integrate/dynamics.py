"""The first-order form of a model: what the integrators see."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.frames import Matrix, Vector
from kanefe.kernels.constraints.tolerances import NEAR_SINGULAR
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.scales import coordinate_moves, modal_frequencies, state_scales, tangents, turning

if TYPE_CHECKING:
    from kanefe.kernels.steppers.step_commands import Run


DIFFERENCE = 1e-5
"""Step of central differences relative to the scale of the quantity: truncation and cancellation are then both about
1e-10."""


class Dynamics:
    """State ``y = (q, u, z, dissipated energy, work of loads and drives)`` and its rate, counted.

    Attributes
    ----------
    model : Model
    route : Route
    evaluations : int
        How often the equations of motion were evaluated.
    weakest : float
        Of the constraints at the last evaluation: see `ConstrainedSolver.weakest`.
    seconds_looking : float
        Time before the run in which functions of the time were looked through for changes, s.
    """

    def __init__(self, model: Model) -> None:
        self.model, self.route = model, model.route
        self.evaluations = 0
        self.weakest = 1.0
        self.seconds_looking = 0.0
        self._is_own = True  # but for evaluations with something that has inertia only through loops

    @property
    def is_autonomous(self) -> bool:
        """Whether whole runs can stay in compiled code."""
        return self.route.is_autonomous

    @property
    def calls_functions(self) -> bool:
        """Whether loads or drives are functions of the user, which may change within a step."""
        return not self.route.is_constant or any(motion.pieces is None for motion, _ in self.model.drives)

    @property
    def has_kinks(self) -> bool:
        """Whether forces may jump or begin at once: those of stops, of contacts, and functions of the user."""
        at_once = any(load.acts_at_once for load in self.model.loads)
        return self.calls_functions or self.model.has_stops or at_once

    def balance(self, run: Run) -> None:
        """Write energy and momenta that a method asks for."""
        self.route.balance(run)

    def name_what_is_not_finite(self, t: float, y: Vector) -> None:
        """Raise the error of a load or motion that gives no numbers at a state, or of forces that have no value."""
        self.route.check_functions(t, y)

    def implicit_rate(
        self, t: float, vectors: np.ndarray, share_damping: float, share_stiffness: float, share_of_rates: float = 0.0
    ) -> None:
        """Write a linearly implicit evaluation: see `Route.sweep_implicitly`."""
        self.evaluations += 1
        self.weakest = self.route.sweep_implicitly(t, vectors, share_damping, share_stiffness, share_of_rates)

    def initial_state(self, start: float) -> Vector:
        """Return y at the start, consistent with the loops at that time (s)."""
        return np.concatenate((self.route.start(start), np.zeros(QUADRATURES)))

    def scales(self, t: float, y: Vector, looseness: float = 1.0) -> Vector:
        """Return what counts as a large value of each component of y, for a run that begins at a state.

        Where loads may act at once, their power jumps, and no step is short enough for a small part of the kinetic
        energy that a small and fast scene has by its `state_scales` alone: that of the start is taken in. And impacts
        pass on the energy of all modes, so that modes are as large as their energy is, not as far as they move: times
        `looseness`, by which the absolute tolerance is below the usual one for the sake of other components.
        """
        found = state_scales(self.model).copy()
        if any(load.acts_at_once for load in self.model.loads):
            found[-QUADRATURES:] = np.maximum(found[-QUADRATURES:], self.model.energy(t, y[:-QUADRATURES]).kinetic)
            shares = looseness / np.maximum(modal_frequencies(self.model), looseness)  # 1 of joints, whose are zero
            found[self.model.coordinate_count :][: self.model.free_count] *= shares
            for turns, at, speed in coordinate_moves(self.model):
                if not turns:
                    found[at] *= shares[speed]
        return found

    def projected(self, t: float, y: Vector, share: float = 0.0) -> Vector:
        """Return the nearest state at which loops are closed: see `Route.projected`."""
        return self.route.projected(t, y, share)

    def parts(self, y: Vector) -> tuple[Vector, Vector]:
        """Return q and u of a state."""
        n = self.model.coordinate_count
        return y[:n], y[n : n + self.model.free_count]

    def rate(self, t: float, y: Vector) -> Vector:
        """Return dy/dt."""
        self.evaluations += 1
        rates, self.weakest, self._is_own = self.route.evaluate(t, y)
        return rates

    def tangent_derivatives(self, t: float, y: Vector) -> Matrix:
        """Return derivatives of the rates of speeds, states and quadratures by tangents, then by speeds and states.

        Shape (free + states + quadratures, 2 free + states); states that stay between events are left out of the
        second. A tangent is a change of the coordinates in the direction of a speed, of a
        rotation the rotation vector in the moving frame.
        """
        return self._derivatives(t, y, self._tangents(y))[:, self.model.coordinate_count :].T

    def calls_for_jacobian(self, t: float) -> int:
        """Return how many calls of functions of the user in Python a Jacobian takes, that of the start (s)."""
        if self.is_autonomous:
            return 0
        y = self.initial_state(t)
        return self.route.calls_for_derivatives(t, y, self._tangents(y))

    def _tangents(self, y: Vector) -> Matrix:
        """Return the directions in y of changes along each speed and of speeds and states that move, (k, state)."""
        directions = tangents(self.model).copy()
        for at, speed in turning(self.model):
            # rates of Euler parameters by the angular velocity, in the frame that turns
            e0, e1, e2, e3 = 0.5 * y[at : at + 4]
            directions[speed : speed + 3, at : at + 4] = (-e1, e0, e3, -e2), (-e2, -e3, e0, e1), (-e3, e2, -e1, e0)
        return directions

    def jacobian(self, t: float, y: Vector) -> Matrix:
        """Return d(dy/dt)/dy, (state, state)."""
        directions = np.eye(len(y))[: len(y) - QUADRATURES]  # nothing depends on the quadratures
        return np.vstack((self._derivatives(t, y, directions), np.zeros((QUADRATURES, len(y))))).T

    def _derivatives(self, t: float, y: Vector, directions: Matrix) -> Matrix:
        """Return derivatives of dy/dt along directions, (k, state) both.

        Exact to round-off where the scene is in order n, but for functions of the user that look at the state: of these
        by central differences. Else of all by central differences.
        """
        reaches = DIFFERENCE / np.abs(directions / self._scales).max(axis=1)
        if self._is_own and self.weakest >= NEAR_SINGULAR:
            exact = self.route.derivatives(t, y, directions, reaches)
            if exact is not None:
                self.evaluations += len(directions)
                return exact
        found = np.empty_like(directions)
        with np.errstate(over="ignore", invalid="ignore"):
            for i, (direction, reach) in enumerate(zip(directions, reaches, strict=True)):
                ahead, behind = self.rate(t, y + reach * direction), self.rate(t, y - reach * direction)
                found[i] = (ahead - behind) / (2.0 * reach)
        return found

    @cached_property
    def _scales(self) -> Vector:
        return state_scales(self.model)

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the rates of the quadratures, in W, at a state with accelerations du (free,)."""
        return self.route.powers(t, y, du)
