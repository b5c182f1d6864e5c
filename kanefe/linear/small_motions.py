"""Small motions of a scene about a state: the independent directions, and the accelerations along them.

With loops the tangents z and speeds du of the tree are functions of independent ones, p and r:

    z = N_h p,    du = N r + B p

The columns of N_h satisfy the holonomic rows and those of N all rows. B keeps the rates of the rows closed while the
mechanism moves, ``J du + D z = 0``, because J changes with the position. For holonomic rows ``2 D = J G - J f_u``,
which follows from the second derivative of the residual being symmetric. (Schiehlen & Eberhard, "Applied Dynamics", for
the tree; Peterson, Gede & Hubbard, "Symbolic linearization of equations of motion of constrained multibody systems",
Multibody Syst. Dyn. 33 (2015) 143-161, for rows that are not holonomic.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.linear.displaced_drives import Drive, Shift, shifted
from kanefe.linear.independent import Independent, all_of, independent
from kanefe.linear.losses import Arms, arms_of, structural_forces
from kanefe.linear.overflow import refuse_overflow
from kanefe.linear.tangents import Derivatives, difference, tangent_steps, turning
from kanefe.states.constraints import constraint_rates, place_rows
from kanefe.states.state import State


class Moved(NamedTuple):
    """A state near the one of the analysis: model (with its drives), q, u and du."""

    model: Model
    q: Vector
    u: Vector
    du: Vector


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of small motions, one per column: tangents, speeds and accelerations, free ones and then drives."""

    z: Matrix
    du: Matrix
    ddu: Matrix


class SmallMotions:
    """Independent small motions about a state.

    Parameters
    ----------
    model : Model
    t : float
        s.
    q, u : ndarray
        Coordinates and free speeds, consistent with the loops.
    drives : sequence of Drive
        Driven coordinates that are varied as well, after the free ones.
    checks : bool
        Whether singular positions of the loops are refused; `is_singular` tells of them.

    Attributes
    ----------
    G : ndarray, shape (n, n)
        Of ``dz/dt = G z + du``; n: free speeds and drives.
    columns : ndarray of int, shape (n,)
        Their numbers among all speeds.
    """

    def __init__(
        self, model: Model, t: float, q: Vector, u: Vector, drives: Sequence[Drive] = (), checks: bool = True
    ) -> None:
        self.model, self.t, self.q, self.u, self.drives, self._checks = model, t, q, u, tuple(drives), checks
        n = model.free_count
        self.size = n + len(drives)
        self.G = np.zeros((self.size, self.size))
        self.G[:n, :n] = turning(model, u)
        self.columns = np.concatenate(
            (np.arange(n), [model.bodies[d.body].speeds[d.coordinate] for d in drives])
        ).astype(int)

    @cached_property
    def y(self) -> Vector:
        """The state (q, u, z)."""
        return np.concatenate((self.q, self.u, self.model.initial_states))

    @cached_property
    def du(self) -> Vector:
        """The accelerations of the state, (free,)."""
        return self.model.parts(self.model.rhs(self.t, self.y))[1]

    @cached_property
    def derivatives(self) -> Derivatives:
        """The derivatives of the accelerations."""
        return Derivatives(self.model, self.t, self.q, self.u)

    @property
    def positions(self) -> Independent:
        """The independent tangents.

        Raises
        ------
        ModelError
            At a singular position of the loops, where the motion is not unique.
        """
        return self._divided.positions

    @property
    def speeds(self) -> Independent:
        """The independent speeds; without rolling they are led by the same entries as the tangents."""
        return self._divided.speeds

    @property
    def is_holonomic(self) -> bool:
        """Whether no row is of speeds alone, as those of rolling are."""
        return self._divided.is_holonomic

    @cached_property
    def _divided(self) -> _Divided:
        n = self.model.free_count
        if not self.model.is_constrained:
            every = all_of(self.size)
            return _Divided(every, every, np.zeros((0, self.size)), True)
        given = np.arange(self.size) >= n
        rates, of_places = constraint_rates(self.here).over(self.columns), place_rows(self.here)
        masses = np.diag(self.mass) if len(rates.J) else np.ones(self.size)  # to make columns of rows comparable
        joints = np.zeros(self.size, dtype=bool)
        for body in self.model.bodies:
            joints[body.speeds[body.speeds < n]] = True
        positions = independent(rates.over(slice(None), of_places), masses, joints, given)
        is_holonomic = len(of_places) == len(rates.J)
        speeds = positions if is_holonomic else independent(rates, masses, joints, given, positions.following)
        self._check_singular()
        return _Divided(positions, speeds, rates.J, is_holonomic)

    @property
    def is_moving(self) -> bool:
        """Whether anything has a speed, drives included."""
        return bool(self.u.any()) or bool(self.model.driven_count and self.model.driven_speeds(self.t)[0].any())

    @cached_property
    def coordinate_map(self) -> Matrix:
        """The map from free tangents to changes of q, (coordinates, free)."""
        return self.model.coordinate_map(self.q)

    @cached_property
    def here(self) -> State:
        """The state itself."""
        return State(self.model, self.t, self.q, self.u)

    @cached_property
    def mass(self) -> Matrix:
        """M_sys over free speeds and drives."""
        return self.model.route.mass_matrix(self.t, self.y)[np.ix_(self.columns, self.columns)]

    def moved(self, along: Directions, column: int, h: float) -> Moved:
        """Return the state displaced by h along a direction."""
        n = self.model.free_count
        z, du, ddu = along.z[:, column], along.du[:, column], along.ddu[:, column]
        shifts = {drive: Shift(h * z[n + i], h * du[n + i], h * ddu[n + i]) for i, drive in enumerate(self.drives)}
        model = shifted(self.model, self.t, shifts)
        return Moved(model, self.model.advance(self.q, h * z[:n]), self.u + h * du[:n], self.du + h * ddu[:n])

    def steps(self, along: Directions) -> Vector:
        """Return the steps of differences along each direction."""
        n = self.model.free_count
        sizes = np.minimum(tangent_steps(self.model, along.z[:n]), tangent_steps(self.model, along.du[:n]))
        return np.where(np.abs(along.z[n:]).max(axis=0, initial=0.0) > 0.0, np.minimum(sizes, 1e-3), sizes)

    def _open_rates(self, state: Moved) -> Vector:
        """Return J u of all speeds, including those of all drives, at a displaced state."""
        beside = State(state.model, self.t, state.q, self.u)
        rates = constraint_rates(beside)
        return np.asarray(rates.J @ beside.full[: rates.J.shape[1]])

    def accelerations(self, z: Matrix, du: Matrix, ddu: Matrix) -> Matrix:
        """Return the accelerations along directions: exact for free speeds, by differences if drives move."""
        n, count = self.model.free_count, z.shape[1]
        found = np.zeros((self.size, count))
        found[n:] = ddu[n:]
        of_drives = (np.abs(z[n:]) + np.abs(du[n:]) + np.abs(ddu[n:])).sum(axis=0) > 0.0
        free = np.flatnonzero(~of_drives)
        found[:n, free] = self.derivatives.along(z[:n, free], du[:n, free])
        if not of_drives.any():
            return found
        along = Directions(z, du, ddu)
        steps = self.steps(along)
        for i in np.flatnonzero(of_drives):

            def rate(h: float, column: int = int(i)) -> Vector:
                state = self.moved(along, column, h)
                return self.model.literal.accelerations_at(State(state.model, self.t, state.q, state.u))

            found[:n, i] = difference(rate, steps[i])
        return found

    def state_matrix(self) -> Matrix:
        """Return A of ``dx/dt = A x`` over independent tangents and speeds, and states of arms, x = (p, r, s)."""
        P, R, S = self.with_arms, self.along_speeds, self.along_arms
        lead_p, lead_r = self.positions.leading, self.speeds.leading
        rows = [[(self.G @ P.z + P.du)[lead_p], R.du[lead_p]], [P.ddu[lead_r], R.ddu[lead_r]]]
        if arms := len(self.arms):
            pulled = self.arms.rates[:, None] * (self.arms.factors.T @ P.z[: self.model.free_count])
            rows[0].append(np.zeros((len(lead_p), arms)))
            rows[1].append(S.ddu[lead_r])
            rows.append([pulled, np.zeros((arms, len(lead_r))), -np.diag(self.arms.rates)])
        A = np.block(rows)
        refuse_overflow("the state matrix", A)
        return A

    @cached_property
    def arms(self) -> Arms:
        """The arms of viscoelastic bodies; the derivatives here are those of a scene whose arms follow at once."""
        return arms_of(self.model)

    @cached_property
    def along_arms(self) -> Directions:
        """Unit states of the arms, with the accelerations that they bring."""
        none = np.zeros((self.size, len(self.arms)))
        ddu = none.copy()
        if len(self.arms):
            ddu[: self.model.free_count] = self.model.literal.responses(self.here, self.arms.factors)
        return Directions(none, none, ddu)

    @property
    def with_arms(self) -> Directions:
        """`along_positions` with what the arms, whose states stay, add to the accelerations."""
        P = self.along_positions
        if not len(self.arms):
            return P
        return Directions(P.z, P.du, P.ddu - self.along_arms.ddu @ (self.arms.factors.T @ P.z[: self.model.free_count]))

    def structural_matrix(self) -> Matrix | None:
        """Return H of ``dx/dt = (A + i H) x`` in harmonic motions; None: no body has structural damping."""
        forces = structural_forces(self.model)
        if forces is None:
            return None
        n, p, r = self.model.free_count, len(self.positions.leading), len(self.speeds.leading)
        ddu = np.zeros((self.size, p))
        ddu[:n] = self.model.literal.responses(self.here, -forces @ self.along_positions.z[:n])
        found = np.zeros((p + r + len(self.arms),) * 2)
        found[p : p + r, :p] = ddu[self.speeds.leading]
        return found

    def rates_along(self, x: Vector) -> Vector:
        """Return A x for one direction; without loops A is not computed."""
        n = len(self.positions.leading)
        if self.model.is_constrained or self.drives or len(self.arms):
            return np.asarray(self.state_matrix() @ x)
        z, du = x[:n], x[n:]
        return np.concatenate((self.G @ z + du, self.derivatives.along(z[:, None], du[:, None])[:, 0]))

    @cached_property
    def along_speeds(self) -> Directions:
        """Unit motions of r, with their accelerations."""
        N = self.speeds.N
        none = np.zeros_like(N)
        return Directions(none, N, self.accelerations(none, N, none))

    @cached_property
    def along_positions(self) -> Directions:
        """Unit motions of p, with the speeds B that keep the loops closed, and their accelerations."""
        N_h = self.positions.N
        B = np.zeros_like(N_h)
        if self.model.is_constrained and self.is_moving:
            if self.is_holonomic:
                D = 0.5 * self._divided.J @ (self.G @ N_h - self.along_speeds.ddu)
            else:
                D = self._rates_by_differences(N_h)
            B = self.speeds.followed(D)
        return Directions(N_h, B, self.accelerations(N_h, B, np.zeros_like(N_h)))

    def _rates_by_differences(self, N_h: Matrix) -> Matrix:
        none = np.zeros_like(N_h)
        along = Directions(N_h, none, none)
        steps = self.steps(along)
        columns = [
            difference(lambda h, i=i: self._open_rates(self.moved(along, i, h)), steps[i])  # type: ignore[misc]
            for i in range(N_h.shape[1])
        ]
        return np.column_stack([np.zeros((len(self._divided.J), 0)), *columns])

    @property
    def is_singular(self) -> bool:
        """Whether the loops are singular here, where the motion is not unique."""
        return bool(self._singular_rows)

    @cached_property
    def _singular_rows(self) -> Sequence[str]:
        if not self.model.constraints:
            return ()
        from kanefe.equations.constraint_report import singular_rows

        return singular_rows(self.here, self.model.route)

    def _check_singular(self) -> None:
        """Raise a ModelError at a singular position of the loops."""
        if self._checks and self.is_singular:
            raise ModelError(
                f"the loops are singular at t = {self.t:.6g} s ({', '.join(self._singular_rows[:3])} are dependent "
                "there): the mechanism can continue in more than one way, and small motions are not linear. Remedy: a "
                "state beside this one"
            )


class _Divided(NamedTuple):
    """The independent tangents and speeds, the rows J over all speeds, and whether all rows are holonomic."""

    positions: Independent
    speeds: Independent
    J: Matrix
    is_holonomic: bool
