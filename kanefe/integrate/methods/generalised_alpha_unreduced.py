"""Generalised-alpha for scenes with unreduced bodies: S factored once per step size, one solve for each iteration.

The matrices of an unreduced body are constant in its frame G. So S = M + gamma' h C + beta' h^2 K is factored when a
step size is met for the first time, and kept; what couples the bodies to the scene is a small border. Steps are the
span divided by powers of two: few sizes, each met again and again, and no slivers before an output, which is
interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

import numpy as np

from kanefe.errors import KanefeError
from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.followed_states import FollowedStates
from kanefe.integrate.methods.generalised_alpha import FIXED_RTOL, SPECTRAL_RADIUS
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha, Step, doublings, no_step, within
from kanefe.integrate.methods.method import Method
from kanefe.integrate.methods.python_stepper import PythonStepper
from kanefe.integrate.methods.unreduced_matrices import (
    IterationMatrices,
    MeasuredStep,
    NewtonStep,
    Reached,
    TriedEnd,
    large_displacements,
)
from kanefe.integrate.stepper import StepFailure, beyond
from kanefe.tree.model_data import QUADRATURES
from kanefe.tree.route import Form

if TYPE_CHECKING:
    from kanefe.integrate.stepper import StepControl
    from kanefe.unreduced.route import UnreducedRoute

LARGEST_ITERATIONS = 8

CONVERGED = 0.5
"""Error of the iteration relative to the permitted error of a step, times the number of steps in the span. It
accumulates in the speeds, and the error of the speeds in the coordinates: over N steps, to N^2 times its own size."""

STALLED = 1e-3
"""Error of the iteration relative to the permitted error of a step, of fixed steps `FIXED_RTOL`, that is accepted with
these, and where round-off prevents a smaller one."""

SLOW = 0.3
"""Convergence rate of the iteration from which the border is computed again."""

MEASURED_EVERY = 16
"""Number of steps after which the convergence rate and the error are measured again, with one more solve for each."""

CAUTION = 3.0
"""Safety factor on a measured rate for the next steps."""

QUIET = 0.4
"""Error of a step up to which the next steps are judged by the change of the accelerations, without a solve."""

FIRST_HALVINGS = 9
"""Number of halvings of the span that give the first trial step; it grows or shrinks from there."""

LEAST_HALVINGS, MOST_HALVINGS = 3, 40


class UnreducedStepper(PythonStepper):
    """Steps of the generalised-alpha method for scenes with unreduced bodies.

    Parameters
    ----------
    dynamics : Dynamics
    start, stop : float
        s.
    control : StepControl
        rtol: error of a step relative to the size of the bodies (m) and to 1 rad, for nodes and joints alike.
    name : str
        Of the method.
    """

    formula = GeneralisedAlpha(SPECTRAL_RADIUS)

    def __init__(self, dynamics: Dynamics, start: float, stop: float, control: StepControl, *, name: str) -> None:
        super().__init__(name, dynamics)
        self._model = dynamics.model
        self._scene = cast("UnreducedRoute", dynamics.route)  # its row is taken of no other
        self._formula = type(self).formula
        self._step = control.step
        self._reach = 1.0 / ((control.rtol if self._step is None else FIXED_RTOL) * large_displacements(self._scene))
        self._start, self._span, self._stop = start, stop - start, stop
        if self._step is not None:
            self._span = math.ldexp(self._step, FIRST_HALVINGS)
        self._halvings, self._states = FIRST_HALVINGS, FollowedStates()
        self._patience, self._calm, self._is_first = 1, 0, True
        self._matrices = IterationMatrices(self._scene, self._formula, self._span)
        self.iterations = self._unmeasured = 0
        self._worst: int | None = None
        self.restart(start, dynamics.initial_state(start))

    @property
    def t(self) -> float:
        """Time reached in s."""
        reached = self._start + self._span * math.ldexp(self._ticks, -MOST_HALVINGS)
        is_end = math.isclose(reached, self._stop, rel_tol=1e-15, abs_tol=1e-15 * self._span)
        return self._stop if is_end else reached

    @property
    def t_old(self) -> float:
        """Start of the last step in s."""
        return self._before[0]

    def state(self) -> Vector:
        """Return the state at t."""
        return np.concatenate((self._q, self._u, self._quadratures))

    def restart(self, t: float, y: Vector) -> None:
        """Continue from another state: with the same step sizes, counted from there, whose factors are kept."""
        self._start, self._ticks = t, 0
        self._begin(y)

    def _begin(self, y: Vector) -> None:
        t = self.t
        q, u = self._dynamics.parts(y)
        self._q, self._u, self._quadratures = q.copy(), u.copy(), y[len(q) + len(u) :].copy()
        self._du = self._scene.accelerations(t, self._q, self._u, self._z)
        self._a = self._du.copy()
        self._power = self._powers(t, self._q, self._u, self._du, self._z)
        self._states.forget()
        self._before = (t, self._q, self._u, self._du, self._quadratures)
        self._move = np.zeros_like(self._u)
        self._begun: tuple[float, Step] | None = None
        self._matrices.bordered = None
        self._rate, self._measured = 1.0, MeasuredStep(-1, 0.0, 0.0)

    def _powers(self, t: float, q: Vector, u: Vector, du: Vector, z: Vector) -> Vector:
        """Return the rates of the quadratures."""
        return self._scene.powers(t, np.concatenate((q, u, z)), du)

    @property
    def _z(self) -> Vector:
        """Internal states of loads."""
        return self._quadratures[:-QUADRATURES]

    def _followed(self, h: float, q: Vector, u: Vector) -> Vector:
        """Return the internal states of loads at the end of a step, with q and u there."""
        if not self._model.states_move:
            return self._z
        return self._states.reached(self._scene.condensed.state(self.t + h, q, u, self._z), self._z, h)

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return what is needed to continue; of factors and borders the states at which they were made."""
        arrays = {name: getattr(self, f"_{name}").copy() for name in ("q", "u", "du", "a", "power")}
        arrays["works"] = self._quadratures.copy()
        counters = self._halvings, self._ticks, self._patience, self._calm, self._is_first, self._unmeasured
        arrays["counters"] = np.array((*counters, self._measured.halvings), dtype=np.int64)
        arrays["numbers"] = np.array((self._start, self._span, self._rate, self._measured.error, self._measured.first))
        arrays |= self._matrices.snapshot() | self._bends.snapshot()
        return arrays

    def resume(self, snapshot: Mapping[str, np.ndarray]) -> None:
        """Continue from a snapshot: the matrices are factored again."""
        counters = snapshot["counters"].tolist()
        self._start, self._span, rate, error, first = snapshot["numbers"].tolist()
        self._halvings, self._ticks, self._patience, self._calm = counters[:4]
        self._begin(np.concatenate([snapshot[name] for name in ("q", "u", "works")]))
        self._is_first, self._unmeasured = bool(counters[4]), counters[5]
        self._rate, self._measured = rate, MeasuredStep(counters[6], error, first)
        self._du, self._a, self._power = (np.array(snapshot[name]) for name in ("du", "a", "power"))
        self._before = (self.t, self._q, self._u, self._du, self._quadratures)
        self._matrices.resume(snapshot, self._span)
        self._bends.resume(snapshot)

    def _counted(self) -> dict[str, int | float]:
        """Return evaluations, how often S was factored, and how many iterations were done, each with one solve."""
        return {
            "evaluations": self._scene.evaluations,
            "factorisations": self._scene.factorisations,
            "iterations": self.iterations,
        }

    def _advance(self, target: float) -> None:
        """Take one accepted step, whose size does not depend on the outputs."""
        if self._step is not None:
            return self._advance_fixed(self._step)
        while True:
            h = math.ldexp(self._span, -self._halvings)
            if self.t + h > self._stop + 1e-9 * h:  # only after a restart: what is left has sizes of its own
                self._span_anew(self._stop - self.t, LEAST_HALVINGS)
                continue
            end, no_answer = None, None
            try:
                end = self._try(h)
            except KanefeError as error:  # too far ahead: up to where the equations hold, there are smaller steps
                no_answer = error
            if end is not None and end.error <= 1.0:
                more = doublings(end.error)
                if self._is_first and more > 1:  # all sizes can begin at the start: no need to grow one by one
                    self._halvings, self._is_first = max(self._halvings - more, LEAST_HALVINGS), False
                    continue
                break
            self._rejected += 1
            self._patience, self._calm = min(2 * self._patience, 64), 0
            less = 2 if end is None else max(1, math.ceil(math.log2(1.1 * end.error) / 3))
            self._halvings += min(less, 4)
            if self._halvings > MOST_HALVINGS:
                if no_answer is not None:
                    raise no_answer
                raise no_step(end is not None, "or loosen rtol", self._worst)
        self._is_first = False
        self._accept(h, end)
        self._grow(end.error)

    def _advance_fixed(self, h: float) -> None:
        """Take a given step, or what is left of the way if that is shorter."""
        left = self._stop - self.t
        h = h if h <= left * (1.0 + 1e-9) else left
        if math.ldexp(self._span, -self._halvings) != h:
            self._span_anew(math.ldexp(h, FIRST_HALVINGS), FIRST_HALVINGS)
        for _ in range(2):  # a second time with a border of this state
            try:
                end = self._try(h)
            except KanefeError as error:
                raise beyond(error) from error
            if end is not None:
                return self._accept(h, end)
            self._rejected += 1
            self._matrices.renew(self._q)
        reason = f"the Newton iteration of {self.name} does not converge with steps of {h:g} s"
        raise StepFailure(reason, "a smaller step, or rtol instead", self._worst)

    def _span_anew(self, span: float, halvings: int) -> None:
        """Count steps from here, as parts of another span."""
        self._start, self._span, self._ticks = self.t, span, 0
        self._halvings, self._measured, self._begun = halvings, MeasuredStep(-1, 0.0, 0.0), None
        self._matrices.clear(span)

    def _accept(self, h: float, end: TriedEnd) -> None:
        t1 = self.t + h
        q, u = self._closed(t1, end.q, end.u)
        power = self._powers(t1, q, u, end.du, end.z)
        quadratures = np.concatenate((end.z, self._quadratures[-QUADRATURES:] + 0.5 * h * (self._power + power)))
        self._before = (self.t, self._q, self._u, self._du, self._quadratures)
        self._states.keep(self._z, h)
        self._move = self._formula.move(h, self._u, self._a, end.a)
        self._begun = None
        self._steps += 1
        self._ticks += 1 << (MOST_HALVINGS - self._halvings)
        self._q, self._u, self._du, self._a, self._power, self._quadratures = q, u, end.du, end.a, power, quadratures

    def _grow(self, error: float) -> None:
        """Take larger steps when the error has been small for some: only where the larger ones can begin."""
        wanted = doublings(error)
        self._calm = self._calm + 1 if wanted > 0 else 0
        if self._calm < self._patience:
            return
        while wanted > 0 and self._halvings > LEAST_HALVINGS:
            if self._ticks % (1 << (MOST_HALVINGS - self._halvings + 1)):
                return
            self._halvings, wanted, self._calm = self._halvings - 1, wanted - 1, 0

    def states(self, times: np.ndarray) -> np.ndarray:
        """Return the states at times of the last step, shape (times, state)."""
        t0, q0, u0, _, quadratures0 = self._before
        if t0 == self.t:
            return np.tile(self.state(), (len(times), 1))
        h = self.t - t0
        found = []
        for t in times:
            x = (t - t0) / h
            move, rates = within(x, h, u0, self._u, self._move)
            q = self._q if x == 1.0 else self._model.advance(q0, move)
            found.append(np.concatenate((q, rates, (1 - x) * quadratures0 + x * self._quadratures)))
        return np.array(found).reshape(len(times), -1)

    def accelerations(self, times: np.ndarray) -> np.ndarray:
        """Return du at times of the last step, shape (times, free)."""
        t0, du0 = self._before[0], self._before[3]
        if t0 == self.t:
            return np.tile(self._du, (len(times), 1))
        x = ((times - t0) / (self.t - t0))[:, None]
        return np.asarray((1 - x) * du0 + x * self._du)

    def _try(self, h: float) -> TriedEnd | None:
        """Return the end of a step of h, or None if the iteration does not converge."""
        if not self._model.free_count:
            return TriedEnd(0.0, self._q, self._u, self._du, self._a, self._followed(h, self._q, self._u))
        du, first = self._du.copy(), 0.0
        allowed = math.ldexp(CONVERGED, -self._halvings) if self._step is None else STALLED
        last, rate = 0.0, self._expected_rate()
        slowest = 0.0
        for iteration in range(LARGEST_ITERATIONS):
            done = self.iterate(h, du)
            if done is None:
                return None
            du -= done.correction
            size = self._formula.stiffness_share(h) * self._size(done.correction)
            if iteration:
                rate = size / last if last else 0.0
                # far from the end the iteration is slower than near it: what is expected of a first correction is that
                slowest = self._rate = max(slowest, rate)
            else:
                first = size
            if size <= allowed or (rate < 1.0 and size * rate / (1.0 - rate) <= allowed):
                break
            if iteration and rate > 0.9:
                if size > STALLED:
                    self._matrices.renew(self._q)
                    return None
                break
            last = size
        else:
            self._matrices.renew(self._q)
            return None
        if rate > SLOW:
            self._matrices.bordered = None
        self._dynamics.evaluations = self._scene.evaluations
        q, u, a = self._reached(h, du)
        error = self._expected_error(first) if self._step is None else 0.0
        if error is None:
            local = self._scene.inertia_of(self._formula.error(h, self._a, a), done.residual, q)
            filtered = done.bordered.solve(*local)
            error = self._size(self._scene.condensed.joined(filtered.z, filtered.parts))
            self._remember(error, first)
        return TriedEnd(error, q, u, du, a, self._followed(h, q, u))

    def _size(self, move: Vector) -> float:
        """Return how large a move is against what is allowed, and remember which speed has the worst part."""
        sizes = np.abs(move) * self._reach
        worst = int(np.argmax(sizes))
        self._worst = self._model.coordinate_count + worst
        return float(sizes[worst])

    def _remember(self, error: float, first: float) -> None:
        """Keep a measured error; of a step in which little changed, as it would be of one in which more does."""
        known, self._unmeasured = self._measured, 0
        usual = 0.5 * known.first if known.halvings == self._halvings else 0.0
        scale = usual / first if 0.0 < first < usual else 1.0
        self._measured = MeasuredStep(self._halvings, scale * error, scale * first)

    def _expected_error(self, first: float) -> float | None:
        """Return the error that the last measured one lets expect; None if it is time to measure it.

        The first Newton step is the change of the accelerations, whose part that steps resolve is the error.
        """
        known = self._measured
        if known.halvings != self._halvings or self._unmeasured > MEASURED_EVERY or first > 1.5 * known.first:
            return None
        error = known.error * first / known.first if known.first else 0.0
        return error if max(error, known.error) < QUIET else None

    def iterate(self, h: float, du: Vector) -> NewtonStep | None:
        """Return a Newton step for accelerations du at the end of a step of h; None if the residual is not finite.

        One residual and one solve with the factors of S.
        """
        q, u, _ = self._reached(h, du)
        at = Reached(self.t + h, q, u, du, self._followed(h, q, u))
        found = self._scene.residual(*at)
        if not all(np.isfinite(part @ part) for part in (found.twin, *found.parts)):
            return None
        bordered, known = self._matrices.equations(self._halvings, found, at, self._q)
        solution = bordered.solve(found.twin, found.parts, known)
        self.iterations += 1
        return NewtonStep(self._scene.condensed.joined(solution.z, solution.parts), found, bordered)

    def _reached(self, h: float, du: Vector) -> tuple[Vector, Vector, Vector]:
        """Return q, u and the algorithmic acceleration at the end of a step with accelerations du there."""
        if self._begun is None or self._begun[0] != h:
            self._begun = h, self._formula.from_start(h, self._u, self._du, self._a)
        move, u, a = self._begun[1].end(du)
        return self._model.advance(self._q, move), u, a

    def _expected_rate(self) -> float:
        """Return the rate of the iteration that the last steps let expect, on the safe side; 1 if it is not known."""
        self._unmeasured += 1
        bordered = self._matrices.bordered
        if self._unmeasured > MEASURED_EVERY or bordered is None or bordered[0] != self._halvings:
            return 1.0
        return min(CAUTION * self._rate, 1.0)

    def _closed(self, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return the state with its loops closed, in the metric of the iteration, so that stiff modes stay."""
        from kanefe.unreduced.closing import closed_state

        bordered = self._matrices.bordered
        if not self._model.constraints or bordered is None:
            return q, u
        return closed_state(self._scene.condensed, t, q, u, bordered[1])


METHOD = Method(
    name="generalised-alpha",
    about="for unreduced bodies, factored once per step size",
    stepper=UnreducedStepper,
    order=2,
    has_fixed_steps=True,
    form=Form.SUBSTRUCTURES,
)
