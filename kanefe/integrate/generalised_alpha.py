"""Generalised-alpha on the rotation group, order 2 (Chung & Hulbert 1993; Bruels, Cardona & Arnold 2012).

Stable for elastic modes of any frequency, which are damped where the step does not resolve them. The Newton matrix is
``M + gamma' h C + beta' h^2 K`` with C and K of the flexible bodies; all else is left to the iteration, whose
residual is exact. Rotations advance by the exponential map. The step follows the third-order part of the
displacement, filtered by the same matrix so that unresolved modes do not hold it down.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.kane.assemble import accelerations, assemble
from kanefe.model import Model

SPECTRAL_RADIUS = 0.8
"""Share of an unresolved mode that a step keeps: 1 keeps all, 0 kills it in one step."""

LARGEST_ITERATIONS = 8


class GeneralisedAlphaStepper:
    """Steps of the generalised-alpha method, landing on the wanted times.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    rtol : float
        Error of a step relative to 1 rad, to the size of the bodies (m), and for modal coordinates to the amplitude
        that moves a body by its own size.
    atol : float
        Not used by this method, whose scales are those above: it must be None at the entry.
    outputs : ndarray
        Times at which steps end.
    """

    name = "generalised-alpha"

    def __init__(
        self, dynamics: Dynamics, start: float, stop: float, rtol: float, atol: float, outputs: np.ndarray
    ) -> None:
        r = SPECTRAL_RADIUS
        self._alpha_m, self._alpha_f = (2 * r - 1) / (r + 1), r / (r + 1)
        self._gamma = 0.5 + self._alpha_f - self._alpha_m
        self._beta = 0.25 * (0.5 + self._gamma) ** 2
        self._dynamics, self._model = dynamics, dynamics.model
        self._scales = rtol * displacement_scales(self._model)
        self._stiffness, self._damping = iteration_matrices(self._model)
        self._stops = np.append(outputs[outputs > start], stop)
        self.t = start
        self._state = dynamics.initial_state()
        q, u = dynamics.parts(self._state)
        self._du = accelerations(self._model, start, q, u)
        self._a = self._du.copy()
        self._power = dynamics.powers(start, q, u, self._du)
        self._h = 1e-4 * (stop - start)
        self._smallest = 1e-12 * (stop - start)
        self.rejected = 0

    def initial_state(self) -> Vector:
        """Return the state at the start."""
        return self._state.copy()

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state): the end of the step, where they lie."""
        return np.tile(self._state, (len(times), 1))

    def step(self) -> None:
        """Take one accepted step.

        Raises
        ------
        SimulationError
            If no step is small enough.
        """
        while True:
            target = self._stops[np.searchsorted(self._stops, self.t + self._smallest)]
            rest = target - self.t
            # two even steps to the target are better than one full and one sliver
            h = rest if self._h >= rest * (1 - 1e-9) else min(self._h, 0.5 * rest) if self._h > 0.5 * rest else self._h
            trial = self._try(h)
            if trial is not None and trial[0] <= 1.0:
                break
            self.rejected += 1
            self._h = 0.25 * h if trial is None else h * max(0.2, 0.9 * trial[0] ** (-1 / 3))
            if self._h < self._smallest:
                raise SimulationError(
                    f"the implicit method found no step at t = {self.t:.6g} s "
                    f"({'its iteration does not converge' if trial is None else 'the error stays too large'}). "
                    "Remedy: check loads for jumps or growth without bound there, loosen rtol, or use method='dop853'"
                )
        error, q, u, du, a = trial
        power = self._dynamics.powers(self.t + h, q, u, du)
        works = self._state[-len(power) :] + 0.5 * h * (self._power + power)
        self._state = np.concatenate((q, u, works))
        self._du, self._a, self._power = du, a, power
        self.t = float(target) if h == rest else self.t + h
        grown = h * min(2.0, 0.9 * max(error, 1e-6) ** (-1 / 3))
        self._h = max(grown, self._h) if h < self._h and error < 1.0 else grown

    def _try(self, h: float) -> tuple[float, Vector, Vector, Vector, Vector] | None:
        """Return (error, q, u, du, a) after a step of h, or None if the iteration does not converge."""
        model, dynamics = self._model, self._dynamics
        q0, u0 = dynamics.parts(self._state)
        if not model.free_count:  # driven all through: nothing to solve for
            return 0.0, q0, u0, self._du, self._a
        alpha_m, alpha_f, beta, gamma = self._alpha_m, self._alpha_f, self._beta, self._gamma
        ratio = (1 - alpha_f) / (1 - alpha_m)
        t = self.t + h
        du = self._du.copy()
        factors = mass = None
        last = np.inf
        for iteration in range(LARGEST_ITERATIONS):
            a = ratio * du + (alpha_f * self._du - alpha_m * self._a) / (1 - alpha_m)
            u = u0 + h * ((1 - gamma) * self._a + gamma * a)
            q = model.advance(q0, h * u0 + h * h * ((0.5 - beta) * self._a + beta * a))
            dynamics.evaluations += 1
            M, F = assemble(model, t, q, u)
            n = model.free_count
            residual = M[:n, :n] @ du - F[:n]
            if model.driven_count:
                residual += M[:n, n:] @ model.driven_speeds(t)[1]
            if not np.all(np.isfinite(residual)):
                return None
            if factors is None:
                mass = M[:n, :n]
                iteration_matrix = mass + (gamma * ratio * h) * self._damping + (beta * ratio * h * h) * self._stiffness
                factors = scipy.linalg.lu_factor(iteration_matrix, check_finite=False)
            correction = scipy.linalg.lu_solve(factors, residual, check_finite=False)
            du = du - correction
            size = float(np.max(np.abs(beta * ratio * h * h * correction) / self._scales, initial=0.0))
            if size <= 1e-3:
                break
            if iteration > 1 and size > 0.9 * last:
                return None
            last = size
        else:
            return None
        a = ratio * du + (alpha_f * self._du - alpha_m * self._a) / (1 - alpha_m)
        u = u0 + h * ((1 - gamma) * self._a + gamma * a)
        q = model.advance(q0, h * u0 + h * h * ((0.5 - beta) * self._a + beta * a))
        local = (beta - 1 / 6) * h * h * (a - self._a)
        filtered = scipy.linalg.lu_solve(factors, mass @ local, check_finite=False)
        return float(np.max(np.abs(filtered) / self._scales, initial=0.0)), q, u, du, a


def displacement_scales(model: Model) -> np.ndarray:
    """Return the size of a large displacement along every free speed, shape (free,): rad, m, or modal units."""
    length = scene_length(model)
    scales = np.empty(model.free_count)
    for body in model.bodies:
        if not body.is_driven:
            for i, name in enumerate(body.joint.speed_names):
                scales[body.speeds.start + i] = 1.0 if "rad" in name else length
        if body.flexible:
            flexible = body.flexible.body
            extent = float(np.ptp(flexible.nodes, axis=0).max()) or length
            # kinetic energy 1/2 m_i deta^2: eta = sqrt(m / m_i) L moves the body by about its length
            modal = np.diag(flexible.moments.elastic_mass)[: flexible.free_count]
            scales[body.flexible.speeds] = extent * np.sqrt(flexible.mass / np.maximum(modal, 1e-300))
    return scales


def scene_length(model: Model) -> float:
    """Return a length of the scene in m: its flexible bodies and the offsets of its joints; 1 m if it has none."""
    lengths = [float(np.ptp(b.flexible.body.nodes, axis=0).max()) for b in model.bodies if b.flexible]
    lengths += [float(np.linalg.norm(b.p_PoFo_P)) for b in model.bodies]
    lengths += [float(np.linalg.norm(b.rigid.com)) for b in model.bodies if b.rigid]
    return max([x for x in lengths if x > 0], default=1.0)


def iteration_matrices(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Return K and C of flexible bodies and joint springs over the free speeds, each (free, free)."""
    K, C = np.zeros((model.free_count, model.free_count)), np.zeros((model.free_count, model.free_count))
    for body in model.bodies:
        if body.has_spring and not body.is_driven:
            K[body.speeds, body.speeds], C[body.speeds, body.speeds] = body.joint.stiffness_and_damping
        if body.flexible:
            k, at = body.flexible.body.free_count, body.flexible.speeds
            K[at, at] = body.flexible.body.stiffness[:k, :k]
            if body.flexible.damping is not None:
                C[at, at] = body.flexible.damping[:k]
    return K, C


def stiffest_rate(model: Model, start: float) -> float:
    """Return the highest natural frequency or decay rate of the scene as it starts, in rad/s; zero without elasticity.

    Of K and C of flexible bodies and joint springs with the mass of the whole scene: a body on a hinge, or a light
    one on a stiff spring, vibrates faster than its own modes say.
    """
    K, C = iteration_matrices(model)
    if not (np.any(K) or np.any(C)):
        return 0.0
    M, _ = assemble(model, start, model.initial_coordinates, model.initial_speeds)
    n = model.free_count
    try:
        squares, rates = (
            scipy.linalg.eigh(X, M[:n, :n], eigvals_only=True, subset_by_index=(n - 1, n - 1))[0] for X in (K, C)
        )
    except np.linalg.LinAlgError:
        accelerations(model, start, model.initial_coordinates, model.initial_speeds)  # names what has no inertia
        raise
    return float(max(np.sqrt(max(squares, 0.0)), rates))
