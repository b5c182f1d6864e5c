"""Generalised-alpha and HHT on the rotation group, order 2 (Chung & Hulbert 1993; Bruels, Cardona & Arnold 2012).

Stable for elastic modes of any frequency, which are damped where the step does not resolve them. The Newton matrix is
``M + gamma' h C + beta' h^2 K`` with C and K of the flexible bodies and of springs, dampers and stops; all
else is left to the iteration, whose residual is exact. Rotations advance by the exponential map. The step follows the
third-order part of the displacement, filtered by the same matrix so that unresolved modes do not hold it down.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import KanefeError
from kanefe.frames import Matrix, Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.followed_states import FollowedStates
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha, no_step
from kanefe.integrate.methods.kept_matrices import KeptMatrices
from kanefe.integrate.methods.method import Method, no_reactions_or_rigid_contacts
from kanefe.integrate.methods.python_stepper import PythonStepper
from kanefe.integrate.stepper import BESIDE, StepFailure, beyond
from kanefe.kane.assemble import accelerations, equations, mass_at_start, mass_matrix
from kanefe.kane.constraints import Rates, constraint_rates
from kanefe.kane.route import state_rates
from kanefe.kane.state import State
from kanefe.kane.tangents import constant_tangents, current_tangents
from kanefe.storage.scipy_later import scipy
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.route import Form
from kanefe.tree.scales import displacement_scales

if TYPE_CHECKING:
    from kanefe.integrate.stepper import StepControl

SPECTRAL_RADIUS = 0.8
"""Amplification factor of an unresolved mode per step: 1 keeps it, 0 removes it in one step."""

FORMULA = GeneralisedAlpha(SPECTRAL_RADIUS)

FIXED_RTOL = 1e-7
"""Relative tolerance with fixed steps: the iteration converges to a thousandth of it."""

LARGEST_ITERATIONS = 8

KEPT_ITERATIONS = 3
"""Iterations of a step above which its matrices are not reused for the next one."""


class GeneralisedAlphaStepper(PythonStepper):
    """Steps of the generalised-alpha method, landing on the wanted times.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        rtol: error of a step relative to 1 rad, to the size of the bodies (m), and for modal coordinates to the
        amplitude that moves a body by its own size. Or a fixed step.
    name : str
        Of the method.
    formula : GeneralisedAlpha
    """

    def __init__(
        self,
        dynamics: Dynamics,
        start: float,
        stop: float,
        control: StepControl,
        *,
        name: str,
        formula: GeneralisedAlpha = FORMULA,
    ) -> None:
        super().__init__(name, dynamics)
        self._states = FollowedStates()
        self._formula, self._model = formula, dynamics.model
        self._stop, self._fixed = stop, control.step
        rtol = control.rtol if control.step is None else FIXED_RTOL
        self._scales = rtol * displacement_scales(self._model)
        self._stiffness, self._damping = constant_tangents(self._model)
        self._h = control.step or 1e-4 * (stop - start)
        self._span, self._smallest = stop - start, 1e-12 * (stop - start)
        self._no_answer: tuple[float, KanefeError] | None = None
        self._factorisations = 0
        self._worst: int | None = None
        self.restart(start, dynamics.initial_state(start))

    def state(self) -> Vector:
        """Return the state at t."""
        return self._state.copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state): of third order, on the rotation group."""
        q0, u0 = self._dynamics.parts(self._before)
        h, (_, u1) = self.t - self.t_old, self._dynamics.parts(self._state)
        found = np.tile(self._state, (len(times), 1))
        for i in (times < self.t).nonzero()[0]:
            x = (times[i] - self.t_old) / h
            move = x * (1 - x) ** 2 * h * u0 + x * x * (x - 1) * h * u1 + x * x * (3 - 2 * x) * self._move
            rates = (1 - x) * (1 - 3 * x) * u0 + x * (3 * x - 2) * u1 + 6 * x * (1 - x) / h * self._move
            tail = len(q0) + len(u0)  # internal states and quadratures
            quadratures = (1 - x) * self._before[tail:] + x * self._state[tail:]
            found[i] = np.concatenate((self._model.advance(q0, move), rates, quadratures))
            found[i] = self._closed(times[i], found[i], h)
        return found

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state, with its accelerations."""
        self._t = self._t_old = t
        self._state = self._before = y.copy()
        _, u = self._dynamics.parts(y)
        self._du = accelerations(self._literal(t, y))
        self._a, self._begun, self._h_of_a = self._du.copy(), self._du, 0.0
        self._jerk: Vector | None = None
        self._move = np.zeros_like(u)
        self._power = self._dynamics.powers(t, y, self._du)
        self._states.forget()
        self._kept: KeptMatrices | None = None

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what is needed to continue; of the kept matrices those that are factored."""
        kept = self._kept
        return {
            "numbers": np.array((self.t, self._h, self._h_of_a, 0.0 if kept is None else kept.h)),
            "state": self._state.copy(),
            "du": self._du.copy(),
            "a": self._a.copy(),
            **({} if self._jerk is None else {"jerk": self._jerk.copy()}),
            "power": self._power.copy(),
            **({} if kept is None else kept.arrays()),
            **self._bends.snapshot(),
        }

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot."""
        self._bends.resume(snapshot)
        t, self._h, h_of_a, h = snapshot["numbers"].tolist()
        self.restart(t, snapshot["state"])
        self._h_of_a, self._jerk = h_of_a, np.array(snapshot["jerk"]) if "jerk" in snapshot else None
        self._du, self._a, self._power = (np.array(snapshot[name]) for name in ("du", "a", "power"))
        if "matrix" in snapshot:
            self._kept = KeptMatrices.from_arrays(self._model, h, snapshot)

    def _counted(self) -> dict[str, int | float]:
        return {"factorisations": self._factorisations}

    def _advance(self, target: float) -> None:
        """Take one accepted step, not beyond a time: fixed steps end at the end of the run alone."""
        if self._fixed:
            target = self._stop
        while True:
            rest = target - self.t
            # two even steps to the target are better than one full and one sliver
            is_long = self._h > 0.5 * rest and not self._fixed
            h = rest if self._h >= rest * (1 - 1e-9) else min(self._h, 0.5 * rest) if is_long else self._h
            trial = None
            try:
                self._begun = self._begin(h)
                trial = self._try(h)
            except KanefeError as problem:  # too far ahead: up to where the equations hold, there are smaller steps
                if self._fixed:
                    raise beyond(problem) from problem
                self._kept, self._no_answer = None, (self.t, problem)
            if trial is not None and (trial[0] <= 1.0 or self._fixed):
                break
            if self._fixed:
                reason = f"the Newton iteration of {self.name} does not converge with steps of {h:.3g} s"
                raise StepFailure(reason, "a smaller step, or rtol instead", self._worst)
            self._rejected += 1
            self._h = 0.25 * h if trial is None else h * max(0.2, 0.9 * trial[0] ** (-1 / 3))
            if self._h < self._smallest:
                if self._no_answer is not None and self.t - self._no_answer[0] < BESIDE * self._span:
                    raise self._no_answer[1]
                raise no_step(trial is not None, "loosen rtol, or use method='dop853'", self._worst)
        error, q, u, du, a, z = trial
        self._before, self._t_old = self._state, self.t
        self._move = self._formula.move(h, self._dynamics.parts(self._state)[1], self._begun, a)
        self._jerk, self._h_of_a = (a - self._begun) / h, h
        self._steps += 1
        self._states.keep(self._model.parts(self._state)[2], h)
        quadratures, y = self._state[-QUADRATURES:], np.concatenate((q, u, z))
        power = self._dynamics.powers(self.t + h, np.concatenate((y, quadratures)), du)
        quadratures = quadratures + 0.5 * h * (self._power + power)
        self._state = self._closed(self.t + h, np.concatenate((y, quadratures)), h)
        self._du, self._a, self._power = du, a, power
        self._t = target if h == rest else self.t + h
        if self._fixed:
            return
        grown = h * min(2.0, 0.9 * max(error, 1e-6) ** (-1 / 3))
        self._h = max(grown, self._h) if h < self._h and error < 1.0 else grown

    def _closed(self, t: float, y: Vector, h: float) -> Vector:
        """Return the nearest state with closed loops, in the metric of the iteration: stiff modes are not struck."""
        return self._dynamics.projected(t, y, self._formula.stiffness_share(h))

    def _begin(self, h: float) -> Vector:
        """Return the algorithmic acceleration at the start of a step of h: that of the last step if it was as long."""
        if h == self._h_of_a or not self._model.free_count:
            return self._a
        if self._jerk is None:
            self._jerk = self._filtered_jerk(h)
        return self._a + (self._formula.delay(h) - self._formula.delay(self._h_of_a)) * self._jerk

    def _filtered_jerk(self, h: float) -> Vector:
        """Return d(du)/dt at the start, without what the step does not resolve."""
        model, n, t, (q, u) = self._model, self._model.free_count, self.t, self._dynamics.parts(self._state)
        e, z = 1e-4 * h, model.parts(self._state)[2]
        moved = model.advance(q, e * u + 0.5 * e * e * self._du)
        z = z + e * state_rates(State(model, t, q, u, z)) if model.states_move else z
        ahead = State(model, t + e, moved, u + e * self._du, z)
        jerk = (accelerations(ahead) - self._du) / e
        state = State(model, t, q, u, z)
        mass = mass_matrix(state)[:n, :n]
        matrix = self._iteration_matrix(h, mass, state)
        self._factorisations += 1
        return KeptMatrices.factored(model, h, mass, matrix, self._rows(state)).correction(jerk)

    def _try(self, h: float) -> tuple[float, Vector, Vector, Vector, Vector, Vector] | None:
        """Return (error, q, u, du, a, z) after a step of h, or None if the iteration does not converge."""
        q0, u0 = self._dynamics.parts(self._state)
        if not self._model.free_count:  # driven all through: nothing to solve for
            return 0.0, q0, u0, self._du, self._a, self._followed(h, q0, u0)
        is_swept = not self._dynamics.route.lacks(Form.SWEEPS)
        correct = self._correct_by_rates if is_swept else self._correct_literally
        if self._kept is not None and self._kept.h != h:
            self._kept = None
        du, last, reach = self._du.copy(), np.inf, self._formula.stiffness_share(h)
        for iteration in range(LARGEST_ITERATIONS):
            q, u, _ = self._reached(h, du)
            correction = correct(h, q, u, du, self._followed(h, q, u))
            if correction is None:
                return None
            du = du - correction
            size = self._size(reach * correction)
            if size <= 1e-3:
                break
            if iteration > 1 and size > 0.9 * last:
                self._kept = None
                return None
            last = size
        else:
            self._kept = None
            return None
        q, u, a = self._reached(h, du)
        kept = self._kept
        if kept is None:
            raise TypeError("an iteration leaves its matrices behind")
        filtered = kept.filtered(self._formula.error(h, self._begun, a))
        if iteration >= KEPT_ITERATIONS or self._model.has_varying_tangents:
            self._kept = None
        return self._size(filtered), q, u, du, a, self._followed(h, q, u)

    def _size(self, move: Vector) -> float:
        """Return how large a move is against what is allowed, and remember which speed has the worst part."""
        sizes = np.abs(move) / self._scales
        self._worst = self._model.coordinate_count + int(np.argmax(sizes))
        return float(sizes[self._worst - self._model.coordinate_count])

    def _reached(self, h: float, du: Vector) -> tuple[Vector, Vector, Vector]:
        """Return q, u and the algorithmic acceleration at the end of a step with accelerations du there."""
        q0, u0 = self._dynamics.parts(self._state)
        a = self._formula.algorithmic(self._du, self._begun, du)
        return (
            self._model.advance(q0, self._formula.move(h, u0, self._begun, a)),
            self._formula.speeds(h, u0, self._begun, a),
            a,
        )

    def _literal(self, t: float, y: Vector) -> State:
        return State(self._model, t, *self._model.parts(y))

    def _followed(self, h: float, q: Vector, u: Vector) -> Vector:
        """Return the internal states of loads at the end of a step, with q and u there."""
        z = self._model.parts(self._state)[2]
        if not self._model.states_move:
            return z
        return self._states.reached(State(self._model, self.t + h, q, u, z), z, h)

    def _rows(self, state: State) -> Rates | None:
        """Return the rows that hold the loops of a state; None where nothing is constrained."""
        return constraint_rates(state).over(slice(self._model.free_count)) if self._model.constraints else None

    def _iteration_matrix(self, h: float, M: Matrix, state: State) -> Matrix:
        K, C = current_tangents(state, self._stiffness, self._damping)
        return np.asarray(M + self._formula.damping_share(h) * C + self._formula.stiffness_share(h) * K)

    def _correct_by_rates(self, h: float, q: Vector, u: Vector, du: Vector, z: Vector) -> Vector | None:
        """Return a Newton step from one sweep.

        ``M (du - M^-1 F)`` vanishes where ``M du - F`` does, also with the M of some steps ago: the matrices are made
        anew only when the step changes or the iteration slows down.
        """
        n, t = self._model.free_count, self.t + h
        y = np.concatenate((q, u, z, self._state[-QUADRATURES:]))
        needed = self._dynamics.rate(t, y)[len(q) : len(q) + n]
        if not np.all(np.isfinite(needed)):
            return None
        if self._kept is None:
            state = self._literal(t, y)
            mass = mass_matrix(state)[:n, :n]
            self._factorisations += 1
            matrix = self._iteration_matrix(h, mass, state)
            self._kept = KeptMatrices.factored(self._model, h, mass, matrix, self._rows(state))
        return self._kept.correction(du - needed)

    def _correct_literally(self, h: float, q: Vector, u: Vector, du: Vector, z: Vector) -> Vector | None:
        """Return a Newton step from the assembled equations, with the loops held."""
        model, n = self._model, self._model.free_count
        t = self.t + h
        self._dynamics.evaluations += 1
        state = State(model, t, q, u, z)
        M, F = equations(state)
        rates = np.concatenate((du, state.driven_rates))
        residual = M[:n] @ rates - F[:n]
        if not np.all(np.isfinite(residual)):
            return None
        mass = M[:n, :n]
        rows = self._rows(state)
        if self._kept is None or rows is not None or model.has_varying_tangents:
            self._factorisations += 1
            self._kept = KeptMatrices.factored(model, h, mass, self._iteration_matrix(h, mass, state), rows)
        held = constraint_rates(state) if rows is not None else None
        opening = np.zeros(0) if held is None else held.J @ rates + held.remainder
        return self._kept.solve(residual, opening)


def stiffest_rate(model: Model, start: float) -> float:
    """Return the highest natural frequency or decay rate of the scene as it starts, in rad/s; zero without elasticity.

    Of K and C of flexible bodies and springs with the mass of the whole scene: a body on a hinge, or a light
    one on a stiff spring, vibrates faster than its own modes say.
    """
    state = State(model, start, model.initial_coordinates, model.initial_speeds)
    return highest_rate(model, start, *current_tangents(state, *constant_tangents(model)))


def highest_rate(model: Model, start: float, K: Matrix, C: Matrix) -> float:
    """Return the same for given matrices over the free speeds, with the mass of the scene as it starts."""
    if not (np.any(K) or np.any(C)):
        return 0.0
    M, n = mass_at_start(model, start), model.free_count
    try:
        squares, rates = (
            scipy.linalg.eigh(X, M, eigvals_only=True, subset_by_index=(n - 1, n - 1))[0] if np.any(X) else 0.0
            for X in (K, C)
        )
    except np.linalg.LinAlgError:
        accelerations(State(model, start, model.initial_coordinates, model.initial_speeds))  # names what has no inertia
        raise
    return float(max(np.sqrt(max(squares, 0.0)), rates))


METHOD = Method(
    name="generalised-alpha",
    about="damps vibrations that steps do not resolve: for all stiff scenes",
    stepper=GeneralisedAlphaStepper,
    order=2,
    has_fixed_steps=True,
    serves=no_reactions_or_rigid_contacts,
)
