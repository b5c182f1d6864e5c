"""What a frozen scene offers to those who bring their own integrator or controller.

States are ``y = (q, u)``: the coordinates, then the free speeds, named by `Model.state_names`. No method changes
anything, so that several threads may call them.
"""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import all_speeds
from kanefe.kane.kinematics import sweep_outward
from kanefe.tree.model_data import WORKS, FrameKinematics, MechanicalEnergy, ModelData
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.kane.constraint_report import ConstraintReport
    from kanefe.order_n.route import Obstacle, OrderN
    from kanefe.unreduced.route import UnreducedScene


class Model(ModelData):
    """A frozen scene that can be evaluated; made by `kanefe.System.freeze`. Its data: see `ModelData`.

    Examples
    --------
    Driven by scipy's integrators:

    >>> import kanefe as kf
    >>> from scipy.integrate import solve_ivp
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> rod = scene.add_rigid_body("rod", 1.0, 1 / 12, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    >>> model = scene.freeze()
    >>> model.state_names
    ('rod: angle [rad]', 'rod: rate [rad/s]')
    >>> run = solve_ivp(model.rhs, (0.0, 1.0), model.initial_state, rtol=1e-8)
    """

    @classmethod
    def of(cls, data: ModelData) -> Model:
        """Return the model of frozen data."""
        return cls(**{field.name: getattr(data, field.name) for field in fields(data)})

    @cached_property
    def order_n(self) -> OrderN | None:
        """The order-n route, or None if the scene has what only the literal route offers."""
        from kanefe.order_n.route import OrderN

        return OrderN(self) if self.obstacle is None else None

    @cached_property
    def obstacle(self) -> Obstacle | None:
        """What keeps the scene from the order-n route; None: nothing does."""
        from kanefe.order_n.route import obstacle

        return obstacle(self)

    @cached_property
    def unreduced(self) -> UnreducedScene | None:
        """The equations in sparse matrices, or None if no body has all degrees of freedom of a large mesh."""
        if not self.has_unreduced:
            return None
        from kanefe.unreduced.route import UnreducedScene

        return UnreducedScene(self)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the coordinates, then of the free speeds, with units in brackets."""
        from kanefe.kane.assemble import speed_names

        return self.coordinate_names() + speed_names(self)

    @property
    def initial_state(self) -> Vector:
        """State at the start, as the scene was given."""
        return np.concatenate((self.initial_coordinates, self.initial_speeds))

    def rhs(self, t: float, y: Vector) -> Vector:
        """Return dy/dt.

        Parameters
        ----------
        t : float
            s.
        y : ndarray, shape (coordinates + free,)
            q and u; Euler parameters need not be of unit length.

        Raises
        ------
        ModelError
            If y has another shape.
        SimulationError
            If a joint has no inertia along it.
        """
        size = self.coordinate_count + self.free_count
        if np.shape(y) != (size,):
            self._parts(y)
        if self.order_n is not None:
            full = np.empty(size + WORKS)  # the quadratures have no part in the rates
            full[:size] = y
            rates, weakest = self.order_n.held_rates(t, full)
            if weakest > 0.0:
                return rates[:size]
        from kanefe.kane.assemble import accelerations

        q, u = self._parts(y)
        if self.unreduced is not None:
            return np.concatenate((self.coordinate_rates(q, u), self.unreduced.accelerations(t, q, u)))
        return np.concatenate((self.coordinate_rates(q, u), accelerations(self, t, q, u)))

    def jacobian(self, t: float, y: Vector) -> Matrix:
        """Return d(dy/dt)/dy by complex steps, exact to round-off, shape (state, state).

        Functions of the user that look at the state count as constant: their derivatives are not known.

        Raises
        ------
        ModelError
            If the scene needs the literal route (such as for matrices with rotations), which is not complex.
        """
        self._parts(y)
        self._refuse_dense("the Jacobian")
        if self.obstacle is not None or self.order_n is None:
            what = "" if self.obstacle is None else " for scenes with {} ({})".format(*self.obstacle)
            raise ModelError(f"the exact Jacobian is not offered{what}. Remedy: finite differences of rhs")
        size = len(y)
        full = np.concatenate((y, np.zeros(WORKS)))
        return self.order_n.derivatives(t, full, np.eye(size, size + WORKS))[:, :size].T

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free speeds, shape (free, free) (Eq. 18)."""
        from kanefe.kane.assemble import all_speeds, mass_matrix
        from kanefe.kane.kinematics import sweep_outward

        self._refuse_dense("the mass matrix")
        q, u = self._parts(y)
        n, full = self.free_count, all_speeds(self, t, u)
        return mass_matrix(self, sweep_outward(self, t, q, full), q, full)[:n, :n]

    def forces(self, t: float, y: Vector) -> Vector:
        """Return F of ``mass_matrix du = forces``, shape (free,) (Eq. 18), without those of constraints."""
        from kanefe.kane.assemble import assemble

        self._refuse_dense("the vector of forces")
        M, F = assemble(self, t, *self._parts(y))
        n = self.free_count
        return F[:n] - M[:n, n:] @ self.driven_speeds(t)[1]

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy

        q, u = self._parts(y)
        if self.unreduced is not None:
            return self.unreduced.energy(t, q, u)
        return MechanicalEnergy(kinetic_energy(self, t, q, u), elastic_energy(self, t, q), gravity_energy(self, t, q))

    def constraint_report(self) -> ConstraintReport:
        """Return which rows of loop joints and couplers are redundant, and whether the start is singular.

        Examples
        --------
        ``print(scene.freeze().constraint_report())``
        """
        from kanefe.kane.constraint_report import constraint_report

        return constraint_report(self)

    def joint_reactions(self, t: float, y: Vector) -> dict[str, Vector]:
        """Return what each joint exerts on its body, by name: force and moment (6,), N and N m.

        About the origin of the body's frame, in its axes; the part of motors and drives included. For a controller or
        a sensor: nothing of this is computed in a run that does not ask.
        """
        from kanefe.kane.reactions import joint_reactions

        wrenches = joint_reactions(*self._moving(t, y))
        return {body.name: wrench for body, wrench in zip(self.bodies, wrenches, strict=True)}

    def driving_forces(self, t: float, y: Vector) -> dict[str, Vector]:
        """Return the forces (N) and torques (N m) that driven coordinates need, by body, each (driven,)."""
        from kanefe.kane.coupling import recovered_forces

        forces, _ = recovered_forces(*self._moving(t, y))
        return {b.name: forces[b.speeds[list(b.driven)] - self.free_count] for b in self.bodies if b.is_driven}

    def _moving(self, t: float, y: Vector) -> tuple[ModelData, float, Vector, Vector, Vector]:
        """Return model, t, q, u and du; with unreduced bodies a twin that moves and is loaded in the same way."""
        q, u = self._parts(y)
        du = self.rhs(t, y)[self.coordinate_count :]
        if self.unreduced is None:
            return self, t, q, u, du
        twin, q_twin, u_twin, du_twin = self.unreduced.equivalent(t, q, u, du)
        return twin, t, q_twin, u_twin, du_twin

    def _refuse_dense(self, what: str) -> None:
        if self.has_unreduced:
            raise ModelError(
                f"{what} of a scene with unreduced bodies is not offered: it would be dense over {self.free_count} "
                "speeds. Remedy: rhs, or reduction=CraigBampton(modes=20)"
            )

    def kinematics(self, body: str, t: float, y: Vector, interface: str = "") -> FrameKinematics:
        """Return where the frame of a body, or of one of its interfaces, is and how it moves.

        Raises
        ------
        ModelError
            If there is no such body or interface; the message lists those there are.
        """
        from kanefe.kane.assemble import all_speeds
        from kanefe.kane.kinematics import interface_motion, sweep_outward

        q, u = self._parts(y)
        seen: ModelData = self
        twin = self.unreduced.complete if self.unreduced is not None else None
        if twin is not None:
            seen, q, u = twin.small, twin.coordinates(q), twin.speeds(u)
        number, full = self.index(body), all_speeds(seen, t, u)
        frame = sweep_outward(seen, t, q, full)[number]
        if interface:
            terms = seen.flexible_terms(body)
            at = terms.body.interface(interface)
            frame = interface_motion(frame, at, terms, q, full, self.slopes).turned(at.axes)
        V, W = frame.V[:, : seen.free_count], frame.W[:, : seen.free_count]
        if twin is not None:
            V, W = twin.expanded(V), twin.expanded(W)
        return FrameKinematics(frame.p_NoFo_N, frame.A_NF, frame.v, frame.w, V, W)

    def _parts(self, y: Vector) -> tuple[Vector, Vector]:
        """Return q and u of a state."""
        n, m = self.coordinate_count, self.free_count
        if np.shape(y) != (n + m,):
            raise ModelError(f"a state of this model has {n} coordinates and {m} speeds, not shape {np.shape(y)}")
        return y[:n], y[n:]


def scene_state(model: Model, t: float, y: Vector) -> SceneState:
    """Return what a function ``f(t, state)`` is given at time t (s) and a state that begins with q and u."""
    n, m = model.coordinate_count, model.free_count
    q, u = y[:n], y[n : n + m]
    seen: ModelData = model
    if model.unreduced is not None:
        twin = model.unreduced.complete
        q, u, seen = twin.coordinates(q), twin.speeds(u), twin.small
    full = all_speeds(seen, t, u)
    if seen is model and model.order_n is not None:
        return SceneState(model, t, q, full, model.order_n.frames(t, q, u))
    return SceneState(seen, t, q, full, sweep_outward(seen, t, q, full))
