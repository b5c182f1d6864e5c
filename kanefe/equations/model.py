"""The model of a frozen scene, also for integrators and controllers of the user.

States are ``y = (q, u, z)``: coordinates, free speeds, internal states of loads if any, named by `Model.state_names`.
No method changes the model, so that several threads may call them.
"""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.model_outputs import FrameKinematics, MechanicalEnergy
from kanefe.tree.scales import length_of_parts

if TYPE_CHECKING:
    from kanefe.equations.constraint_report import ConstraintReport
    from kanefe.literal.route import LiteralRoute
    from kanefe.tree.route import Route


class Model(ModelData):
    """A frozen scene that can be evaluated, made by `kanefe.System.freeze`. For its data see `ModelData`.

    Examples
    --------
    Integration by scipy:

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
    def route(self) -> Route:
        """The way to evaluate the equations, chosen for the scene; see its `name` and `reason`."""
        from kanefe.equations.routes import route_of

        before: Route | None = self.of_scene.get("route")
        found = route_of(self) if before is None else before.started_otherwise(self)
        self.of_scene["route"] = found  # the next one has also what this one makes on demand
        return found

    def with_start(self, q: Vector, u: Vector, z: Vector) -> Model:
        """Return the model with another start; what does not depend on it is shared, as the tables of its route."""
        other = replace(self, initial_coordinates=q, initial_speeds=u, initial_states=z)
        if length_of_parts(self) > 0.0:  # else the size of the scene follows from its start
            vars(other)["of_scene"] = self.of_scene
        return other

    @cached_property
    def has_functions(self) -> bool:
        """Whether loads or motions are functions of the user, which may change from run to run."""
        own = (load for i, load in enumerate(self.loads) if i not in self.rigid_contacts)
        of_loads = not self.route.is_constant or any(load.kernel is None for load in own)
        return of_loads or any(motion.pieces is None for motion, _ in self.drives)

    @cached_property
    def set_ups(self) -> dict[tuple[object, ...], list[Any]]:
        """What runs had before their first step and nobody uses now, by their options: `integrate.set_up.SetUp`."""
        return {}

    @cached_property
    def literal(self) -> LiteralRoute:
        """The literal route of the same scene, for comparison."""
        from kanefe.literal.route import LiteralRoute

        return LiteralRoute(self)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the coordinates, of the free speeds, and of internal states of loads, with units in brackets."""
        return self.coordinate_names() + self.speed_names() + self.internal_names()

    @property
    def initial_state(self) -> Vector:
        """State at the start."""
        return np.concatenate((self.initial_coordinates, self.initial_speeds, self.initial_states))

    def rhs(self, t: float, y: Vector) -> Vector:
        """Return dy/dt.

        Parameters
        ----------
        t : float
            s.
        y : ndarray, shape (coordinates + free + states,)
            q, u and z; Euler parameters need not be of unit length.

        Raises
        ------
        ModelError
            If y has another shape.
        SimulationError
            If a speed has no inertia.
        """
        self._check(y)
        return self.route.rates(t, y)

    def jacobian(self, t: float, y: Vector) -> Matrix:
        """Return d(dy/dt)/dy by complex steps, exact to round-off, shape (state, state).

        Functions of the user that depend on the state are held constant, since their derivatives are not known.

        Raises
        ------
        ModelError
            If the scene needs the literal route (such as for matrices with rotations), which has no complex evaluation.
        """
        self._check(y)
        self.route.check_dense("the Jacobian")
        size = len(y)
        full = np.concatenate((y, np.zeros(QUADRATURES)))
        found = self.route.partial_derivatives(t, full, np.eye(size, size + QUADRATURES))
        if found is None:
            what = " and ".join(map(str, self.route.obstacles)) or "functions that take no complex numbers"
            raise ModelError(
                f"the exact Jacobian is not supported for scenes with {what}. Remedy: finite differences of rhs"
            )
        return found[:, :size].T

    def mass_matrix(self, t: float, y: Vector) -> Matrix:
        """Return M_sys over the free speeds, shape (free, free) (Eq. 18)."""
        self._check_dense(y, "the mass matrix")
        n = self.free_count
        return self.route.mass_matrix(t, y)[:n, :n]

    def forces(self, t: float, y: Vector) -> Vector:
        """Return F of ``mass_matrix du = forces``, shape (free,) (Eq. 18), without those of constraints."""
        self._check_dense(y, "the vector of forces")
        state, n = self.literal.view(t, y), self.free_count
        M, F = self.literal.system(state)
        return F[:n] - M[:n, n:] @ state.driven_rates

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        self._check(y)
        return self.route.energy(t, y)

    def constraint_report(self) -> ConstraintReport:
        """Return a report on redundant rows of loop joints and couplers, and on a singular start.

        Examples
        --------
        ``print(scene.freeze().constraint_report())``
        """
        from kanefe.equations.constraint_report import constraint_report

        return constraint_report(self.route)

    def joint_reactions(self, t: float, y: Vector) -> dict[str, Vector]:
        """Return force and moment of each joint on its body, by name, (6,), N and N m.

        About the origin of the body's frame, in its axes; motors and drives are included. They are computed only on
        request, for a controller or a sensor.
        """
        from kanefe.equations.state_forces import forces_of

        self._check(y)
        wrenches = forces_of(self.route, t, y).reactions[0]
        return {body.name: wrench for body, wrench in zip(self.bodies, wrenches, strict=True)}

    def driving_forces(self, t: float, y: Vector) -> dict[str, Vector]:
        """Return the forces (N) and torques (N m) on driven coordinates, by body, each (driven,)."""
        from kanefe.equations.state_forces import forces_of

        self._check(y)
        forces = forces_of(self.route, t, y).driving[0]
        return {b.name: forces[b.speeds[list(b.driven)] - self.free_count] for b in self.bodies if b.is_driven}

    def kinematics(self, body: str, t: float, y: Vector, interface: str = "") -> FrameKinematics:
        """Return position and motion of the frame of a body or of one of its interfaces.

        Raises
        ------
        ModelError
            If there is no such body or interface; the message lists possible ones.
        """
        self._check(y)
        state = self.route.view(t, y)
        seen, number = state.model, self.index(body)
        frame = state.motion(number, None)
        if interface:
            at = seen.flexible_terms(body).body.interface(interface)
            frame = state.motion(number, at).turned(at.axes)
        V, W = (self.route.widened(wide[:, : seen.free_count]) for wide in (frame.V, frame.W))
        return FrameKinematics(frame.p_NoFo_N, frame.A_NF, frame.v, frame.w, V, W)

    def _check_dense(self, y: Vector, what: str) -> None:
        self._check(y)
        self.route.check_dense(what)

    @cached_property
    def _shape_of_state(self) -> tuple[int]:
        return (self.coordinate_count + self.free_count + self.state_count,)

    def _check(self, y: Vector) -> None:
        """Raise a ModelError if a state has another shape."""
        if (y.shape if isinstance(y, np.ndarray) else np.shape(y)) != self._shape_of_state:
            n, m, k = self.coordinate_count, self.free_count, self.state_count
            more = f" and {k} internal states" if k else ""
            raise ModelError(f"a state of this model has {n} coordinates and {m} speeds{more}, not shape {np.shape(y)}")


def is_for_many(model: Model) -> bool:
    """Return whether the next run of a scene may have the model: nothing is otherwise then, or warned of again."""
    return not model.has_functions and not model.route.warns_at_start
