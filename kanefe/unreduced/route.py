"""Equations of scenes with unreduced bodies: residuals, linear systems, accelerations, energies and powers.

The condensed twin contributes all that is outside the bodies; each body adds one evaluation of its inertia field and
one product with K. No dense matrix has the size of a mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import assemble
from kanefe.kane.energy import dissipated_power, drive_power, elastic_energy, gravity_energy, kinetic_energy, load_power
from kanefe.kane.energy import momenta as twin_momenta
from kanefe.literal.route import LiteralRoute, state_rates
from kanefe.loads.base import Load
from kanefe.states.constraints import constraint_rates
from kanefe.states.state import State
from kanefe.tree.model_data import ModelData
from kanefe.tree.model_outputs import MechanicalEnergy
from kanefe.tree.route import Evaluation, Form
from kanefe.tree.scene_state import SceneState
from kanefe.unreduced.bordered import BodyBorder, Bordered, border
from kanefe.unreduced.closing import closed_start
from kanefe.unreduced.condensed import Condensed, condensed_inertia, is_unreduced
from kanefe.unreduced.demand import demand, equivalent_moments
from kanefe.unreduced.mass_solver import mass_solver

if TYPE_CHECKING:
    from kanefe.fe_model.factorise import Factorisation

LARGEST_STORE = 2**32
"""Size of states and accelerations above which a run requires fewer outputs, bytes."""


class Residual(NamedTuple):
    """The residual of the equations at a state with given accelerations.

    Attributes
    ----------
    twin : ndarray, shape (free of the twin,)
        Residual of the twin; zero for carried coordinates, whose residual is in `parts`.
    parts : list of ndarray, each (k,)
        Residuals of the substructures.
    state : State
        State of the twin.
    mass : ndarray
        Its mass matrix, without substructures, over free and driven speeds.
    rates : ndarray
        Rates of its free and driven speeds.
    """

    twin: Vector
    parts: list[Vector]
    state: State
    mass: Matrix
    rates: Vector


class UnreducedRoute(LiteralRoute):
    """The equations of a scene with unreduced bodies.

    Parameters
    ----------
    model : ModelData

    Attributes
    ----------
    condensed : Condensed
    factorisations : int
        Number of factorisations of S of all bodies.
    evaluations : int
        Number of evaluations of the residual.
    """

    name = "unreduced"

    def __init__(self, model: ModelData) -> None:
        names = [repr(body.name) for body in model.bodies if is_unreduced(body)]
        switched = [c.title for c in model.constraints if c.starts_on is not None]
        if switched:
            raise ModelError(
                f"{switched[0]} is switched in a run, which is not supported beside the unreduced body {names[0]}. "
                "Remedy: reduction=CraigBampton(), or leave out starts_on"
            )
        if model.rigid_contacts:
            raise ModelError(
                f"{model.loads[model.rigid_contacts[0]].name!r} is a rigid contact, which is not supported beside the "
                f"unreduced body {names[0]}. Remedy: reduction=CraigBampton(), or kanefe.HuntCrossley(...)"
            )
        super().__init__(model)
        self.reason = f"{', '.join(names)} with all degrees of freedom of the mesh"
        self.condensed = Condensed(model)
        self.small = self.condensed.small
        self.factorisations = 0
        self.evaluations = 0

    def started_otherwise(self, model: ModelData) -> Self:
        """Return a route of its own: the condensed twin begins where the model does."""
        return type(self)(model)

    def lacks(self, form: Form) -> str:
        """Return why only the form of substructures is available."""
        if form is Form.SUBSTRUCTURES:
            return ""
        return (
            "would need a step for the highest mode of the mesh: an unreduced body is run by 'generalised-alpha' or "
            "'hht'. Remedy: one of these, or reduction=CraigBampton()"
        )

    def check_dense(self, what: str) -> None:
        """Raise a ModelError: matrices over all speeds are not available."""
        raise ModelError(
            f"{what} of a scene with unreduced bodies is not supported: it would be dense over {self.model.free_count} "
            "speeds. Remedy: reduction=CraigBampton()"
        )

    def check_outputs(self, count: int) -> None:
        """Refuse states and accelerations that take more than `LARGEST_STORE`."""
        free = self.model.free_count
        if 24 * free * count > LARGEST_STORE:
            raise ModelError(
                f"{count} states of {free} speeds take {24 * free * count / 2**30:.1f} GiB. Remedy: a larger "
                f"output_step, which leaves at most {LARGEST_STORE // (24 * free)} of them"
            )

    @cached_property
    def complete(self) -> Condensed:
        """The twin with all interfaces, for results of a run."""
        return Condensed(self.model, is_complete=True)

    def residual(self, t: float, q: Vector, u: Vector, du: Vector, z: Vector | None = None) -> Residual:
        """Return the residual M du - F at a state of the scene, without constraints."""
        self.evaluations += 1
        condensed, small = self.condensed, self.small
        state = self.condensed.state(t, q, u, z)
        rates = np.concatenate((condensed.speeds(du), state.driven_rates))
        M, F = assemble(state, condensed_inertia)
        twin = M @ rates - F
        parts = []
        for substructure in condensed.substructures:
            G = state.motions[substructure.number]
            a, alpha = G.V @ rates + G.Z, G.W @ rates + G.Y
            if substructure.has_gravity:
                a = a - G.A_NF.T @ small.gravity
            own = (q[substructure.eta], u[substructure.speeds], du[substructure.speeds])
            force, moment, elastic = demand(substructure, own, a, alpha, G, t, state)
            twin += force @ G.V + moment @ G.W
            parts.append(elastic)
        self._move_carried(twin, parts)
        return Residual(twin[: small.free_count], parts, state, M, rates)

    def _move_carried(self, twin: Vector, parts: list[Vector]) -> None:
        """Move forces on carried coordinates from the twin to the substructures, in place."""
        for i, substructure in enumerate(self.condensed.substructures):
            if substructure.carried_count:
                parts[i] = parts[i] + twin[substructure.rates] @ substructure.carried
            twin[substructure.rates] = 0.0

    def borders(self, q: Vector, factors: Sequence[Factorisation]) -> list[BodyBorder]:
        """Return the borders of all substructures at coordinates q of the scene."""
        return [border(m, q[m.eta], own) for m, own in zip(self.condensed.substructures, factors, strict=True)]

    def factored(self, damping_share: float, stiffness_share: float) -> list[Factorisation]:
        """Return factors of ``M + damping_share C + stiffness_share K`` of all substructures."""
        self.factorisations += 1
        found = []
        for substructure in self.condensed.substructures:
            body = substructure.body
            of_mass, of_stiffness = body.damping_factors
            S = (1.0 + damping_share * of_mass) * body.free_mass
            S = S + (stiffness_share + damping_share * of_stiffness) * body.free_stiffness
            if body.damping.nnz:
                S = S + damping_share * body.damping
            found.append(body.factorise(S.tocsc()))
        return found

    def state(self, t: float, y: Vector) -> SceneState:
        """Return the state of the complete twin, for functions of the user."""
        return self.view(t, y)

    def view(self, t: float, y: Vector) -> State:
        """Return the state of the complete twin."""
        q, u, z = self.parts(y)
        return self.complete.state(t, q, u, z)

    def widened(self, partial: Matrix) -> Matrix:
        """Return partial velocities over the free speeds of the scene from those over the twin's."""
        return self.complete.expanded(partial)

    def start(self, t: float) -> Vector:
        """Return (q, u, z) at the start; unreduced bodies keep their shape."""
        if not self.model.constraints:
            return super().start(t)
        return np.concatenate((*closed_start(self.model, t), self.model.initial_states))

    def started(self, t: float, loads: Sequence[Load]) -> tuple[Load, ...]:
        """Return loads between frames in their state at the start."""
        model = self.model.with_loads(loads)
        state = Condensed(model).state(t, model.initial_coordinates, model.initial_speeds)
        return tuple(load.started(t, state.load_ends(i)) for i, load in enumerate(loads))

    def evaluate(self, t: float, y: Vector) -> Evaluation:
        """Return the rates at a state."""
        q, u, z = self.parts(y)
        du = self.accelerations(t, q, u, z)
        z_rates = state_rates(self.view(t, y))
        rates = self.model.coordinate_rates(q, u), du, z_rates, self.powers(t, y, du)
        return Evaluation(np.concatenate(rates), 1.0)

    def projected(self, t: float, y: Vector, share: float = 0.0) -> Vector:
        """Return the state itself: the integration method closes the loops, with its own matrices."""
        return y

    def accelerations(self, t: float, q: Vector, u: Vector, z: Vector | None = None) -> Vector:
        """Return du of the free speeds, with loops closed."""
        zero = np.zeros(self.model.free_count)
        at_rest = self.residual(t, q, u, zero, z)
        solvers = [mass_solver(substructure.body) for substructure in self.condensed.substructures]
        small, n = self.small, self.small.free_count
        rows = constraint_rates(at_rest.state) if small.constraints else None
        bordered = Bordered(self.condensed, self.borders(q, solvers), at_rest.mass[:n, :n], at_rest.state.motions, rows)
        known = None if rows is None else rows.remainder + rows.J[:, n:] @ at_rest.rates[n:]
        solution = bordered.solve(-at_rest.twin, [-part for part in at_rest.parts], known)
        return self.condensed.joined(solution.z, solution.parts)

    def inertia_of(self, step: Vector, at: Residual, q: Vector) -> tuple[Vector, list[Vector]]:
        """Return M times a vector over the free speeds, as twin and substructures, with the M of a residual."""
        condensed, n = self.condensed, self.small.free_count
        z = condensed.speeds(step)
        twin = at.mass[:n, :n] @ z
        parts, none = [], np.zeros(3)
        for substructure in condensed.substructures:
            G, still = at.state.motions[substructure.number], np.zeros(substructure.body.free_count)
            a, alpha = G.V[:, :n] @ z, G.W[:, :n] @ z
            field = substructure.body.inertia_field
            force, moment, elastic = field.forces(q[substructure.eta], still, step[substructure.speeds], a, alpha, none)
            twin += (force @ G.V + moment @ G.W)[:n]
            parts.append(elastic)
        self._move_carried(twin, parts)
        return twin, parts

    def energy(self, t: float, y: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        condensed, small = self.condensed, self.small
        q, u, z = self.parts(y)
        state = condensed.state(t, q, u, z)
        kinetic, elastic, gravity = kinetic_energy(state), elastic_energy(state), gravity_energy(state)
        for substructure in condensed.substructures:
            eta, deta, G = q[substructure.eta], u[substructure.speeds], state.motions[substructure.number]
            force, moment, part = substructure.body.inertia_field.momenta(eta, deta, G.v, G.w)
            kinetic += 0.5 * float(force @ G.v + moment @ G.w + part @ deta)
            elastic += 0.5 * float(eta @ (substructure.body.free_stiffness @ eta))
            if substructure.has_gravity:
                first = substructure.body.inertia_field.first_moment(eta)
                gravity -= float(small.gravity @ (substructure.body.mass * G.p_NoFo_N + G.A_NF @ first))
        return MechanicalEnergy(kinetic, elastic, gravity)

    def momenta(self, t: float, y: Vector) -> tuple[Vector, Vector]:
        """Return linear and angular momentum about N's origin, in N."""
        q, u, z = self.parts(y)
        state = self.condensed.state(t, q, u, z)
        linear, angular = twin_momenta(state)
        for substructure in self.condensed.substructures:
            G = state.motions[substructure.number]
            force, moment, _ = substructure.body.inertia_field.momenta(
                q[substructure.eta], u[substructure.speeds], G.v, G.w
            )
            linear = linear + G.A_NF @ force
            angular = angular + G.A_NF @ moment + np.cross(G.p_NoFo_N, G.A_NF @ force)
        return linear, angular

    def powers(self, t: float, y: Vector, du: Vector) -> Vector:
        """Return the power dissipated by damping and the power of loads and drives, W, shape (2,)."""
        condensed, small = self.condensed, self.small
        if not self.model.has_power:
            return np.zeros(2)
        q, u, z = self.parts(y)
        state = condensed.state(t, q, u, z)
        taken, given = dissipated_power(state), load_power(state)
        for substructure in condensed.substructures:
            eta, deta, G = q[substructure.eta], u[substructure.speeds], state.motions[substructure.number]
            if substructure.body.is_damped:
                taken += float(deta @ substructure.body.damping_force(deta))
            for load in substructure.field_loads:
                force, moment, elastic = load.forces(t, G.A_NF, eta, state)
                given += float(force @ G.v + moment @ G.w + elastic @ deta)
        if small.driven_count:
            given += drive_power(*self.acting(t, y, du))
        return np.array((taken, given))

    def acting(self, t: float, y: Vector, du: Vector) -> tuple[State, Vector]:
        """Return a state of a twin of ordinary bodies with the same motion at one state, and its accelerations.

        Its bodies have the rigid inertia of the deformed bodies, some inertia of the carried coordinates, and a bias
        with the remaining forces at du, so that the literal route finds the same accelerations, constraint forces, and
        forces of every joint and interface.
        """
        twin = self.complete
        q, u, z = self.parts(y)
        state, du_s = twin.state(t, q, u, z), twin.speeds(du)
        rates = np.concatenate((du_s, state.driven_rates))
        moments = []
        for substructure in twin.substructures:
            G = state.motions[substructure.number]
            a, alpha = G.V @ rates + G.Z, G.W @ rates + G.Y
            if substructure.has_gravity:
                a = a - G.A_NF.T @ twin.small.gravity
            own = (q[substructure.eta], u[substructure.speeds], du[substructure.speeds])
            moments.append(equivalent_moments(substructure, own, a, alpha, G, t, state))
        return State(twin.with_moments(moments), t, state.q, state.u, state.z), du_s
