"""Equations of scenes with unreduced bodies: residuals, linear systems, accelerations, energies and powers.

The condensed twin gives all that is outside the bodies; each body adds one evaluation of its inertia field and one
product with K. Nothing dense is as wide as a mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from kanefe.fe_model.factorise import Factorisation
from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import all_speeds, assemble
from kanefe.kane.constraints import constraint_rates
from kanefe.kane.energy import dissipated_power, drive_power, elastic_energy, gravity_energy, kinetic_energy, load_power
from kanefe.kane.energy import momenta as twin_momenta
from kanefe.kane.kinematics import FrameMotion, sweep_outward
from kanefe.tree.model_data import MechanicalEnergy, ModelData
from kanefe.tree.scene_state import SceneState
from kanefe.unreduced.bordered import Bordered, Edge, edge
from kanefe.unreduced.condensed import Condensed, Member, condensed_inertia
from kanefe.unreduced.demand import demand, equivalent_moments
from kanefe.unreduced.mass_solver import MassSolver


class Residual(NamedTuple):
    """What the equations leave at a state with given accelerations.

    Attributes
    ----------
    twin : ndarray, shape (free of the twin,)
        Zero for carried coordinates, whose share is in `parts`.
    parts : list of ndarray, each (k,)
        Of the members.
    q, full : ndarray
        Coordinates and all speeds of the twin.
    motions : list of FrameMotion
        Its outward sweep.
    mass : ndarray
        Its mass matrix, without members, over free and driven speeds.
    rates : ndarray
        Rates of its free and driven speeds.
    """

    twin: Vector
    parts: list[Vector]
    q: Vector
    full: Vector
    motions: list[FrameMotion]
    mass: Matrix
    rates: Vector


class UnreducedScene:
    """The equations of a scene with unreduced bodies.

    Parameters
    ----------
    model : ModelData

    Attributes
    ----------
    condensed : Condensed
    factorisations : int
        How often S of all bodies was factored.
    evaluations : int
        How often the residual was evaluated.
    """

    def __init__(self, model: ModelData) -> None:
        self.model = model
        self.condensed = Condensed(model)
        self.small = self.condensed.small
        self.factorisations = 0
        self.evaluations = 0
        self._complete: Condensed | None = None

    @property
    def complete(self) -> Condensed:
        """The twin with all interfaces, for questions about a run."""
        if self._complete is None:
            self._complete = Condensed(self.model, is_complete=True)
        return self._complete

    def residual(self, t: float, q: Vector, u: Vector, du: Vector) -> Residual:
        """Return what M du - F leaves at a state of the scene, constraints left out."""
        self.evaluations += 1
        condensed, small = self.condensed, self.small
        q_s, u_s, rates = condensed.coordinates(q), condensed.speeds(u), condensed.speeds(du)
        full = all_speeds(small, t, u_s)
        if small.driven_count:
            rates = np.concatenate((rates, small.driven_speeds(t)[1]))
        motions = sweep_outward(small, t, q_s, full)
        M, F = assemble(small, t, q_s, u_s, inertia=condensed_inertia, motions=motions)  # type: ignore[arg-type]
        twin = M @ rates - F
        parts = []
        state: SceneState | None = None
        for member in condensed.members:
            G = motions[member.number]
            a, alpha = G.V @ rates + G.Z, G.W @ rates + G.Y
            if member.has_gravity:
                a = a - G.A_NF.T @ small.gravity
            if member.field_loads and state is None:
                state = SceneState(small, t, q_s, full, motions)
            own = (q[member.eta], u[member.speeds], du[member.speeds])
            force, moment, elastic = demand(member, own, a, alpha, G, t, state)
            twin += force @ G.V + moment @ G.W
            parts.append(elastic)
        n = small.free_count
        for i, member in enumerate(condensed.members):
            if member.carried_count:
                parts[i] = parts[i] + twin[member.rates] @ member.carried
        for member in condensed.members:
            twin[member.rates] = 0.0
        return Residual(twin[:n], parts, q_s, full, motions, M, rates)

    def edges(self, q: Vector, factors: Sequence[Factorisation]) -> list[Edge]:
        """Return the borders of all members at coordinates q of the scene."""
        return [edge(m, q[m.eta], own) for m, own in zip(self.condensed.members, factors, strict=True)]

    def factored(self, damping_share: float, stiffness_share: float) -> list[Factorisation]:
        """Return factors of ``M + damping_share C + stiffness_share K`` of all members."""
        self.factorisations += 1
        found = []
        for member in self.condensed.members:
            body = member.body
            of_mass, of_stiffness = body.damping_factors
            S = (1.0 + damping_share * of_mass) * body.free_mass
            S = S + (stiffness_share + damping_share * of_stiffness) * body.free_stiffness
            if body.damping.nnz:
                S = S + damping_share * body.damping
            found.append(body.factorise(S.tocsc()))
        return found

    def accelerations(self, t: float, q: Vector, u: Vector) -> Vector:
        """Return du of the free speeds, loops held."""
        zero = np.zeros(self.model.free_count)
        at_rest = self.residual(t, q, u, zero)
        solvers = [MassSolver(member.body.free_mass) for member in self.condensed.members]
        small, n = self.small, self.small.free_count
        rows = constraint_rates(small, at_rest.motions, at_rest.q, at_rest.full) if small.constraints else None
        bordered = Bordered(self.condensed, self.edges(q, solvers), at_rest.mass[:n, :n], at_rest.motions, rows)
        known = None if rows is None else rows.remainder + rows.J[:, n:] @ at_rest.rates[n:]
        solution = bordered.solve(-at_rest.twin, [-part for part in at_rest.parts], known)
        return self.condensed.joined(solution.z, solution.parts)

    def inertia_of(self, step: Vector, at: Residual, q: Vector) -> tuple[Vector, list[Vector]]:
        """Return M times a vector over the free speeds, as twin and members, with the M of a residual."""
        condensed, n = self.condensed, self.small.free_count
        z = condensed.speeds(step)
        twin = at.mass[:n, :n] @ z
        parts, none = [], np.zeros(3)
        for member in condensed.members:
            G, still = at.motions[member.number], np.zeros(member.body.free_count)
            a, alpha = G.V[:, :n] @ z, G.W[:, :n] @ z
            field = member.body.inertia_field
            force, moment, elastic = field.forces(q[member.eta], still, step[member.speeds], a, alpha, none)
            twin += (force @ G.V + moment @ G.W)[:n]
            parts.append(elastic)
        for i, member in enumerate(condensed.members):
            if member.carried_count:
                parts[i] = parts[i] + twin[member.rates] @ member.carried
        for member in condensed.members:
            twin[member.rates] = 0.0
        return twin, parts

    def energy(self, t: float, q: Vector, u: Vector) -> MechanicalEnergy:
        """Return the energies of a state."""
        condensed, small = self.condensed, self.small
        q_s, u_s = condensed.coordinates(q), condensed.speeds(u)
        full = all_speeds(small, t, u_s)
        motions = sweep_outward(small, t, q_s, full)
        kinetic = kinetic_energy(small, t, q_s, u_s)
        elastic, gravity = elastic_energy(small, t, q_s), gravity_energy(small, t, q_s)
        for member in condensed.members:
            eta, deta, G = q[member.eta], u[member.speeds], motions[member.number]
            force, moment, part = member.body.inertia_field.momenta(eta, deta, G.v, G.w)
            kinetic += 0.5 * float(force @ G.v + moment @ G.w + part @ deta)
            elastic += 0.5 * float(eta @ (member.body.free_stiffness @ eta))
            if member.has_gravity:
                first = member.body.inertia_field.first_moment(eta)
                gravity -= float(small.gravity @ (member.body.mass * G.p_NoFo_N + G.A_NF @ first))
        return MechanicalEnergy(kinetic, elastic, gravity)

    def momenta(self, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
        """Return linear and angular momentum about N's origin, in N."""
        condensed, small = self.condensed, self.small
        q_s, u_s = condensed.coordinates(q), condensed.speeds(u)
        linear, angular = twin_momenta(small, t, q_s, u_s)
        for member, G in self._members(t, q_s, u_s):
            force, moment, _ = member.body.inertia_field.momenta(q[member.eta], u[member.speeds], G.v, G.w)
            linear = linear + G.A_NF @ force
            angular = angular + G.A_NF @ moment + np.cross(G.p_NoFo_N, G.A_NF @ force)
        return linear, angular

    def powers(self, t: float, q: Vector, u: Vector, du: Vector) -> Vector:
        """Return the power that dampers take and the power of loads and drives, W, shape (2,)."""
        condensed, small = self.condensed, self.small
        if not self.model.has_power:
            return np.zeros(2)
        q_s, u_s = condensed.coordinates(q), condensed.speeds(u)
        full = all_speeds(small, t, u_s)
        motions = sweep_outward(small, t, q_s, full)
        state = SceneState(small, t, q_s, full, motions)
        taken, given = dissipated_power(small, t, q_s, u_s), load_power(small, t, q_s, u_s)
        for member in condensed.members:
            eta, deta, G = q[member.eta], u[member.speeds], motions[member.number]
            if member.body.is_damped:
                taken += float(deta @ member.body.damping_force(deta))
            for load in member.field_loads:
                force, moment, elastic = load.forces(t, G.A_NF, eta, state)
                given += float(force @ G.v + moment @ G.w + elastic @ deta)
        if small.driven_count:
            twin, *state_s = self.equivalent(t, q, u, du)
            given += drive_power(twin, t, *state_s)
        return np.array((taken, given))

    def equivalent(self, t: float, q: Vector, u: Vector, du: Vector) -> tuple[ModelData, Vector, Vector, Vector]:
        """Return a twin of ordinary bodies that moves as the scene does at one state, with its q, u and du.

        Its bodies have the rigid inertia of the deformed members, some inertia of the carried coordinates, and as
        bias what the forces at du are beyond that: so the literal route finds the same accelerations and constraint
        forces in it, and the forces of every joint and interface.
        """
        twin = self.complete
        small = twin.small
        q_s, u_s, du_s = twin.coordinates(q), twin.speeds(u), twin.speeds(du)
        full = all_speeds(small, t, u_s)
        motions = sweep_outward(small, t, q_s, full)
        rates = np.concatenate((du_s, small.driven_speeds(t)[1]))
        state = SceneState(small, t, q_s, full, motions)
        moments = []
        for member in twin.members:
            G = motions[member.number]
            a, alpha = G.V @ rates + G.Z, G.W @ rates + G.Y
            if member.has_gravity:
                a = a - G.A_NF.T @ small.gravity
            own = (q[member.eta], u[member.speeds], du[member.speeds])
            moments.append(equivalent_moments(member, own, a, alpha, G, t, state))
        return twin.with_moments(moments), q_s, u_s, du_s

    def _members(self, t: float, q_s: Vector, u_s: Vector) -> list[tuple[Member, FrameMotion]]:
        motions = sweep_outward(self.small, t, q_s, all_speeds(self.small, t, u_s))
        return [(member, motions[member.number]) for member in self.condensed.members]
