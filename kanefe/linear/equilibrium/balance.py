"""The search for a balance: Newton's method, from afar with a stiffness that is shifted to be positive definite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.frames import Vector
from kanefe.linear.equilibrium.overflow import check_accelerations
from kanefe.linear.equilibrium.stiffness import (
    along_neutral,
    lowest,
    metric,
    rank_of,
    share,
    solved,
    stiffness_of,
    unit_mass,
)
from kanefe.linear.imbalance import BALANCED, Imbalance, imbalance_of, slipping_friction, worst_imbalance
from kanefe.linear.small_motions import SmallMotions
from kanefe.linear.tangents import DIFFERENCE_STEP, large_tangents, tangent_steps
from kanefe.linear.unsettled import REPORTED
from kanefe.tree.scales import own_length

LARGEST_ITERATIONS, LARGEST_HALVINGS = 200, 12
"""Largest numbers of iterations, and of halvings of one step."""

PATIENCE = {True: 80, False: 20}
"""Number of iterations without improvement after which a search ends, with and without the
shift: a shifted search may pass through worse states."""

AS_IN_STATICS = 1.0
"""Share of the stiffness in the metric in which loops are closed, s2: stiff coordinates, whose mass resists least, then
stay where they are, and a step is not undone by the forces of a wrong closing."""

STILL = 1e-14
"""Step, in rad or scene lengths, that is round-off of positions; it may still improve small loads of stiff directions.
"""

ROUNDED = 1e-8
"""Step, in rad or scene lengths, up to which it may be round-off of forces over the stiffness: the root of that of
positions."""

NOISE, EPS = 10.0, float(np.finfo(float).eps)
"""Step relative to the difference of those of states that differ by round-off, up to which it is round-off itself, and
this difference, rad or scene lengths."""

LAST_DIGITS = 3
"""Number of steps up to that size without improvement after which a search ends, largest number of steps to the size of
round-off, and number of states that differ by it."""

LARGEST_STEP = 0.3
"""Largest step of one iteration, rad or scene lengths."""

UNHELD = 0.5
"""Forces that meet no stiffness, relative to all of them in the metric of masses, above which a scene is not held."""

MOST_UNBOWED, UNBOWED = 12, 1e-9
"""Largest number of iterations to a state without the bow due to unbalance, and the step at which it is reached."""

POLISHED = 1e-13
"""Imbalance below which iterations continue only while they improve it."""


class _Step(NamedTuple):
    """One iteration: the tangent z, the change of u, the forces that meet no stiffness, and their share of all.

    Forces are those along motions of unit mass.
    """

    z: Vector
    du: Vector
    unmet: Vector
    unmet_share: float


def closed(model: Model, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return coordinates and speeds with closed loops; those with little stiffness move most."""
    return model.parts(model.route.projected(t, np.concatenate((q, u, model.initial_states)), AS_IN_STATICS))[:2]


class BalanceSearch:
    """Newton's method for a state without accelerations.

    The unknowns are the independent tangents p and the speeds to be found; the equations are that the leading
    accelerations vanish. In the metric of the mass matrix their Jacobian is minus a stiffness over mass. No step is
    longer than `longest`, in rad or scene lengths; iterations end at an imbalance of `enough`. Directions with a
    stiffness over mass below `slack` (1/s2) are left unchanged if the imbalance there is small: see `unbowed`.
    """

    def __init__(
        self,
        model: Model,
        t: float,
        q: Vector,
        u: Vector,
        found: np.ndarray,
        held: Sequence[str],
        longest: float = LARGEST_STEP,
        slack: float = 0.0,
        enough: float = POLISHED,
    ) -> None:
        self.model, self.t, self.q, self.u, self.found = model, t, q, u, found
        self.iterations, self._slack = 0, slack
        self._longest = longest if own_length(model) else np.inf  # nothing has a size that a step could exceed
        self._enough, self._accepted = enough, max(enough, BALANCED)
        self._is_shifted = False
        self._last: SmallMotions | None = None
        self._left: tuple[SmallMotions, Imbalance] | None = None
        self._held = np.zeros(model.free_count, dtype=bool)
        self._held[found] = True
        for name in held:
            at = model.bodies[model.index(name)].speeds
            self._held[at[at < model.free_count]] = True

    def run(self) -> tuple[Vector, Vector]:
        """Return q and u in balance."""
        start = self._closed(self.q, self.u)
        state, imbalance = self._iterate(start, settles=not len(self.found))
        if imbalance.ratio > self._accepted:
            other, again = self._iterate(start, settles=False)
            if again.ratio < imbalance.ratio:
                state, imbalance = other, again
        if imbalance.ratio <= self._accepted:
            return state
        settled = self._to_round_off(*state)
        if settled is None:
            raise SimulationError(self._advice(imbalance, *state))
        return settled

    def polished(self) -> tuple[Vector, Vector]:
        """Return the balance next to where the search begins, stable or not; that of `run` if it is not so near."""
        state, imbalance = self._iterate(self._closed(self.q, self.u), settles=False)
        return state if imbalance.ratio <= self._accepted else self.run()

    def unbowed(self) -> tuple[Vector, Vector] | None:
        """Return q and u in balance except for the unbalance of a rotor near a critical speed, whose bow is unbounded.

        None without `slack`, if no direction is below it, or if the imbalance is larger than that of an unbalance.
        """
        small = self._off_balance()
        if not self._slack or small is None:
            return None
        q, u = small.q, small.u
        for _ in range(MOST_UNBOWED):
            H, inverse, weight = stiffness_of(small)
            squares, shapes = np.linalg.eigh(0.5 * (H + H.T))
            shapes = shapes[:, np.abs(squares) >= self._slack]
            if shapes.shape[1] == len(H):
                return None
            x = shapes @ np.linalg.solve(shapes.T @ H @ shapes, shapes.T @ weight @ small.du[small.speeds.leading])
            z = small.along_positions.z @ inverse.T @ x
            q, u = self._closed(self.model.advance(q, z), u)
            if step_length(self.model, z) <= UNBOWED:
                return (q, u) if self.imbalance(q, u).ratio <= REPORTED else None
            small = self.small(q, u)
        return None

    def beside(self) -> tuple[Vector, Vector] | None:
        """Return q and u in a balance near the start that only gyroscopic forces can stabilise, in a scene that spins.

        None if the start is in balance or statically stable, or if there is no such balance, or a statically stable
        one.
        """
        small = self._off_balance()
        if small is None or lowest(stiffness_of(small)[0]) >= 0.0:
            return None
        state, imbalance = self._iterate((small.q, small.u), settles=False)
        runs_away = lowest(stiffness_of(self.small(*state))[0]) < 0.0
        return state if imbalance.ratio <= BALANCED and runs_away else None

    def _off_balance(self) -> SmallMotions | None:
        """Return the small motions about a start that spins and is not in balance; else, and with rolling, None."""
        start = self._closed(self.q, self.u)
        if len(self.found) or not self._is_driven or self.imbalance(*start).ratio <= BALANCED:
            return None
        small = self.small(*start)
        return small if small.is_holonomic else None

    @property
    def _is_driven(self) -> bool:
        return bool(self.u.any() or (self.model.driven_count and self.model.driven_speeds(self.t)[0].any()))

    @property
    def is_held(self) -> bool:
        """Whether there is a stiffness against most of the remaining forces where the search begins."""
        state = self._closed(self.q, self.u)
        return self.imbalance(*state).ratio <= BALANCED or self._step(*state, False).unmet_share <= UNHELD

    def is_stiff(self, q: Vector) -> bool:
        """Return whether every motion about a rest at coordinates q has a stiffness, by its rank; not with rolling."""
        small = self.small(q, np.zeros(self.model.free_count))
        if not small.is_holonomic:
            return False
        H = stiffness_of(small)[0]
        return rank_of(H) == len(H)

    def refusal(self) -> SimulationError:
        """Return the error for a start from which a search is useless."""
        state = self._closed(self.q, self.u)
        return SimulationError(self._advice(self.imbalance(*state), *state))

    def imbalance(self, q: Vector, u: Vector) -> Imbalance:
        """Return the worst imbalance of a state."""
        small = self.small(q, u)
        if self._left is None or self._left[0] is not small:
            self._left = small, imbalance_of(small)
        return self._left[1]

    def small(self, q: Vector, u: Vector) -> SmallMotions:
        """Return the small motions about a state; those of the last state are cached."""
        last = self._last
        if last is None or last.t != self.t or not (np.array_equal(last.q, q) and np.array_equal(last.u, u)):
            last = self._last = SmallMotions(self.model, self.t, q, u)
            check_accelerations(last)
        return last

    def _closed(self, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        if not self.model.is_constrained:
            return q, u
        if self.model.rigid_contacts:  # the compiled route closes loops alone
            return self.model.literal.closed(self.t, q, u)
        return closed(self.model, self.t, q, u)

    def _iterate(self, start: tuple[Vector, Vector], settles: bool) -> tuple[tuple[Vector, Vector], Imbalance]:
        """Return the best state on the way from the start, and its imbalance."""
        (q, u), best = start, self.imbalance(*start)
        state, improved = start, 0
        for count in range(LARGEST_ITERATIONS):
            if best.ratio <= self._enough or count - improved > PATIENCE[settles]:
                break
            z, du = self._step(q, u, settles)[:2]
            if not (z.any() or du.any()):
                break
            most = STILL if self._is_shifted else ROUNDED
            if step_length(self.model, z) < most and not du.any() and count - improved > LAST_DIGITS:
                break
            self.iterations += 1
            q_new, u_new, now = self._advanced(q, u, z, du, settles)
            if not np.isfinite(now.ratio) or (best.ratio <= BALANCED and not now.ratio < 0.5 * best.ratio):
                break
            q, u = q_new, u_new
            if now.ratio < 0.99 * best.ratio:
                improved = count
            if now.ratio < best.ratio:
                state, best = (q, u), now
        return state, best

    def _to_round_off(self, q: Vector, u: Vector) -> tuple[Vector, Vector] | None:
        """Return the end of the last steps if the remaining imbalance is round-off; None if it is more.

        Stiff springs turn the last digit of positions into forces, which may be larger at more accurate positions.
        """
        for _ in range(LAST_DIGITS):
            step = self._step(q, u, False)
            z = step.z
            if step.du.any() or step.unmet_share > BALANCED:
                return None
            if step_length(self.model, z) < STILL or self._is_noise(q, u, z):
                return q, u
            q, u = self._closed(self.model.advance(q, z), u)
        return None

    def _is_noise(self, q: Vector, u: Vector, z: Vector) -> bool:
        """Return whether the step z of a state is no larger than what the last digits of its coordinates change of it.

        Steps and not forces are compared, so that noise of stiff directions does not hide a force along a soft one.
        """
        if (length := step_length(self.model, z)) > ROUNDED:
            return False
        drawn, others = np.random.default_rng(0), []
        for _ in range(LAST_DIGITS):
            signs = drawn.choice((-EPS, EPS), len(z))
            beside = self._closed(self.model.advance(q, signs * large_tangents(self.model)), u)
            others.append(step_length(self.model, self._step(*beside, False)[0] - z))
        return length <= NOISE * max(others)

    def _step(self, q: Vector, u: Vector, settles: bool) -> _Step:
        """Return one iteration from a state.

        Newton's method itself needs no metric; the mass metric makes its directions comparable.
        """
        small = self.small(q, u)
        P, lead = small.along_positions, small.speeds.leading
        kept = np.flatnonzero(~self._held[small.positions.leading])
        inverse, weight = unit_mass(small)
        residual = weight @ small.du[lead]
        if small.is_holonomic and not len(self.found) and len(kept) == len(lead):
            H = stiffness_of(small)[0]
            least = lowest(H) if settles else 0.0
            self._is_shifted = least < 0.0
            H = H - 1.5 * least * np.eye(len(H))
            x, unmet = solved(H, residual)
            if settles and (along := float(residual @ x)) < 0.0:
                # a step against the forces: a negative curvature that is too small next to stiff modes to be found
                # above
                self._is_shifted = True
                H = H - 2.0 * along / float(x @ x) * np.eye(len(H))
                x, unmet = solved(H, residual)
            if settles and share(unmet, residual) > UNHELD and (slope := along_neutral(H, residual)).any():
                # no stiffness is met: as far as a step may go
                x = x + min(self._longest, LARGEST_STEP) / step_length(self.model, P.z @ inverse.T @ slope) * slope
            p = inverse.T @ x
            return _Step(P.z @ p, P.du @ p, unmet, share(unmet, residual))
        columns = P.ddu[np.ix_(lead, kept)]
        if len(self.found):
            columns = np.hstack((columns, small.along_speeds.ddu[np.ix_(lead, self.found)]))
        H = -weight @ columns
        x, unmet = solved(H, residual)
        z, du = P.z[:, kept] @ x[: len(kept)], P.du[:, kept] @ x[: len(kept)]
        du[self.found] += x[len(kept) :]
        return _Step(z, du, unmet, share(unmet, residual))

    def _advanced(self, q: Vector, u: Vector, z: Vector, du: Vector, settles: bool) -> tuple[Vector, Vector, Imbalance]:
        """Return the state after the step, which is limited to `longest` and halved while it goes too far.

        Too far means: with the shift, that the forces push back more than they pushed on; else, that accelerations
        grow. A position at which the loops are singular is left out.
        """
        share = min(1.0, self._longest / max(step_length(self.model, z), 1e-300))
        here = self.small(q, u)
        before, force = self._size(here) if not settles else 0.0, self._force(here, z)
        for _ in range(LARGEST_HALVINGS):
            q_new, u_new = self._closed(self.model.advance(q, share * z), u + share * du)
            there = self.small(q_new, u_new)
            if not there.is_singular and (
                self._force(there, z) >= -0.9 * force if settles else self._size(there) < before
            ):
                break
            share *= 0.5
        return q_new, u_new, self.imbalance(q_new, u_new)

    def _unheld(self, q: Vector, u: Vector) -> Imbalance | None:
        """Return the worst of the remaining forces that no stiffness meets, by its rank; None if they are round-off."""
        small, unmet = self.small(q, u), self._step(q, u, False).unmet
        N = small.speeds.N
        found = worst_imbalance(small.here, small.mass, N @ unit_mass(small)[0].T @ unmet, N, small.speeds.leading)
        return found if found.ratio > self._accepted else None

    @staticmethod
    def _size(small: SmallMotions) -> float:
        """Return the size of the accelerations of a state, in the metric of masses."""
        pulled = metric(small.mass).T @ small.du
        return float(pulled @ pulled)

    @staticmethod
    def _force(small: SmallMotions, z: Vector) -> float:
        """Return the force along a tangent."""
        return float(z @ small.mass @ small.du)

    def _advice(self, imbalance: Imbalance, q: Vector, u: Vector) -> str:
        lost = f"no equilibrium of the scene was found at t = {self.t:.6g} s:"
        text = f"{lost} {imbalance} remains"
        if slipping := slipping_friction(self.model, self.t, q, u, imbalance):
            return (
                f"{text}, and {slipping}. Remedy: more friction, or a spring, a support or a drive there; if the "
                "scene can rest elsewhere, start=..., a state nearer to it"
            )
        if (unheld := self._unheld(q, u)) is not None:
            return (
                f"{lost} {unheld} remains, and nothing holds it. Remedy: a spring, a support or a drive there; for a "
                "falling body, gravity=False; for one that spins or moves steadily, its speed in speeds={...}"
            )
        return (
            f"{text} after {self.iterations} iterations. Remedy: start=..., a state nearer to equilibrium (such as "
            "the end of a damped run), or loads and speeds raised in steps, each from the last state"
        )


def step_length(model: Model, z: Vector) -> float:
    """Return the largest displacement along a tangent, in rad or scene lengths."""
    return DIFFERENCE_STEP / float(tangent_steps(model, z[:, None])[0]) if z.any() else 0.0
