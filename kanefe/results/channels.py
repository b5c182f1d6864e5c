"""Channels: what a run can tell, each computed when it is first read.

`Result` reads channels and nothing else, so that a run in memory and a saved one answer alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp

from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.equations.model import Model
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity
from kanefe.frames import euler_parameters_from_matrix
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.coupling import recovered_forces
from kanefe.kane.kinematics import FrameMotion
from kanefe.kane.reactions import carried_wrench, joint_reactions, loop_forces
from kanefe.kane.state import State
from kanefe.results.quantities import ENERGIES, MODES, MOMENTA, XYZ
from kanefe.tree.model_data import BodyTerms, FlexibleTerms, ModelData

Key = tuple[str, str, str]
"""Quantity, body ("" for the whole scene), interface ("" for the body's own frame)."""


@dataclass(frozen=True, eq=False)
class BodyShape:
    """What is known of a body besides its motion: names, mass and, of a flexible one, its mesh and modes.

    Attributes
    ----------
    name, parent, parent_interface : str
        "" for the inertial frame, and for a parent's own frame.
    joint : str
        Kind of the joint.
    driven_names : tuple of str
        Coordinates of the joint that are given functions of time, with units in brackets.
    coordinate_names, speed_names : tuple of str
        Of the joint, with units in brackets.
    mass : float
        kg.
    com : ndarray, shape (3,)
        Undeformed centre of mass in the body's frame, m.
    inertia : ndarray, shape (3, 3)
        Undeformed, about the centre of mass, kg m2.
    interfaces : tuple of str
        Of a flexible body.
    components : tuple of str
        Degrees of freedom of the mesh's nodes.
    nodes : ndarray, shape (n, 3)
        In m; no rows for a rigid body.
    basis : ndarray, shape (n * components, k)
        Motion of the nodes from the modal coordinates.
    cells : tuple of Cells
    is_orthonormal : bool
        Whether the modes have unit modal mass, so that their coordinates are in kg^1/2 m.
    provenance : mapping
    elasticity : Elasticity or None
        What stresses and section forces are recovered with.
    flexible : FlexibleBody or None
        The body itself, of a run in memory.
    """

    name: str
    parent: str
    parent_interface: str
    joint: str
    driven_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    mass: float
    com: np.ndarray
    inertia: np.ndarray
    interfaces: tuple[str, ...]
    components: tuple[str, ...]
    nodes: np.ndarray
    basis: np.ndarray
    cells: tuple[Cells, ...]
    is_orthonormal: bool
    provenance: Mapping[str, Any]
    elasticity: Elasticity | None = None
    flexible: FlexibleBody | None = None

    @property
    def is_driven(self) -> bool:
        """Whether a coordinate of the joint is a given function of time."""
        return len(self.driven_names) > 0

    @property
    def is_flexible(self) -> bool:
        """Whether the body has a mesh."""
        return len(self.nodes) > 0

    def displacements(self, eta: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        """Return the displacements of some nodes in G, (T, len(nodes), 3) in m, from eta (T, k); or without T."""
        if not sp.issparse(self.basis):
            return np.asarray(np.tensordot(eta, self.translations(nodes), axes=(-1, -1)))
        width = len(self.components)
        rows = self.basis[(nodes[:, None] * width + np.arange(width)).ravel()]
        motion = (rows @ np.atleast_2d(eta).T).T.reshape(-1, len(nodes), width)
        found = np.zeros((*motion.shape[:2], 3))
        for column, component in enumerate(self.components):
            if component in XYZ:
                found[:, :, COMPONENTS.index(component)] = motion[:, :, column]
        return found if np.ndim(eta) == 2 else found[0]

    def translations(self, nodes: np.ndarray) -> np.ndarray:
        """Return the rows of the basis that move some nodes along x, y and z, shape (len(nodes), 3, k)."""
        motion = self.basis.reshape(len(self.nodes), len(self.components), -1)[nodes]
        rows = np.zeros((len(nodes), 3, motion.shape[2]))
        for column, component in enumerate(self.components):
            if component in XYZ:
                rows[:, COMPONENTS.index(component)] = motion[:, column]
        return rows


class Channels(Protocol):
    """Where a result reads from.

    `has_forces`: whether accelerations and all forces can be read; `loops`: the names of loop joints and other
    constraints with two ends; `loads`: names of loads between frames, and of what each tells.
    """

    times: np.ndarray
    statistics: dict[str, Any]
    status: RunStatus
    events: Mapping[str, np.ndarray]
    bodies: tuple[BodyShape, ...]
    loops: tuple[str, ...]
    loads: Mapping[str, tuple[str, ...]]
    has_forces: bool

    def read(self, quantity: str, body: str = "", interface: str = "") -> np.ndarray:
        """Return a channel, time first; names are known to exist."""
        ...


def _is_orthonormal(terms: FlexibleTerms) -> bool:
    if sp.issparse(terms.body.basis):
        return False
    return bool(np.allclose(terms.free_moments.elastic_mass, np.eye(terms.body.free_count)))


def body_shape(model: ModelData, body: BodyTerms) -> BodyShape:
    """Return the shape of a body of a model."""
    mesh: dict[str, Any] = {"interfaces": (), "components": (), "cells": (), "is_orthonormal": False, "provenance": {}}
    mesh |= {"nodes": np.zeros((0, 3)), "basis": np.zeros((0, 0))}
    mass, com, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    if body.rigid is not None:
        mass, com, inertia = body.rigid.mass, body.rigid.com, body.rigid.inertia
    elif body.flexible is not None:
        flexible = body.flexible.body
        mass, com = flexible.mass, flexible.center_of_mass
        inertia = flexible.inertia - mass * (com @ com * np.eye(3) - np.outer(com, com))
        mesh = {
            "interfaces": tuple(frame.name for frame in flexible.interfaces),
            "components": flexible.components,
            "nodes": flexible.nodes,
            "basis": flexible.basis[:, : flexible.free_count],
            "cells": flexible.cells,
            "is_orthonormal": _is_orthonormal(body.flexible),
            "provenance": flexible.provenance,
            "elasticity": flexible.elasticity,
            "flexible": flexible,
        }
    return BodyShape(
        name=body.name,
        parent=model.bodies[body.parent].name if body.parent >= 0 else "",
        parent_interface=body.parent_interface.name if body.parent_interface is not None else "",
        joint=body.joint.kind,
        driven_names=tuple(body.joint.coordinate_names[i] for i in body.driven),
        coordinate_names=body.joint.coordinate_names,
        speed_names=body.joint.speed_names,
        mass=mass,
        com=com,
        inertia=inertia,
        **mesh,
    )


class RunChannels:
    """Channels of a run in memory. Quantities that come out of one sweep are computed together, and kept.

    Parameters
    ----------
    model : Model
    trajectory : Trajectory
    """

    def __init__(self, model: Model, trajectory: Trajectory) -> None:
        self.model = model
        self.trajectory = trajectory
        self.times = trajectory.times
        self.statistics = trajectory.statistics
        self.status = trajectory.status or RunStatus("finished", float(trajectory.times[-1]))
        self.events = trajectory.events
        self.bodies = tuple(body_shape(model, body) for body in model.bodies)
        self.loops = tuple(constraint.name for constraint in model.constraints if constraint.b is not None)
        self.loads: Mapping[str, tuple[str, ...]] = {load.name: load.columns for load in model.loads}
        self.has_forces = True
        self._kept: dict[Key, np.ndarray] = {}
        self._du = trajectory.accelerations

    def read(self, quantity: str, body: str = "", interface: str = "") -> np.ndarray:
        """Return a channel, time first."""
        key = (quantity, body, interface)
        if key not in self._kept:
            for new, array in getattr(self, _COMPUTE[quantity].__name__)(body, interface).items():
                array.flags.writeable = False
                self._kept[new] = array
        return self._kept[key]

    def _accelerations(self) -> np.ndarray:
        """Return du of the free speeds at all times, (T, free)."""
        if self._du is None:
            route, parts = self.model.route, self.model.parts
            self._du = np.array([parts(route.evaluate(t, y).rates)[1] for t, y in self._states()])
        return self._du

    @property
    def states(self) -> np.ndarray:
        """States ``y = (q, u, z)`` at the output times, (T, state)."""
        run = self.trajectory
        return np.hstack((run.coordinates, run.speeds, run.internal))

    def _states(self) -> list[tuple[float, np.ndarray]]:
        """Return times and states."""
        return list(zip(self.times, self.states, strict=True))

    def _views(self) -> Iterator[State]:
        """Yield a literal state at each time, in which all frames move as in the run."""
        return (self.model.route.view(t, y) for t, y in self._states())

    def _acting(self) -> Iterator[tuple[State, np.ndarray]]:
        """Yield a literal state at each time that is loaded as in the run too, and its accelerations."""
        return (
            self.model.route.acting(t, y, du) for (t, y), du in zip(self._states(), self._accelerations(), strict=True)
        )

    def _sweeps(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        """Return position, rotation and speeds of every frame of the scene."""
        names = ("position", "rotation", "velocity", "angular_velocity")
        frames = self._frames()
        width = {"rotation": 4}
        kept = {(name, *frame): np.empty((len(self.times), width.get(name, 3))) for name in names for frame in frames}
        for i, state in enumerate(self._views()):
            for frame, motion in zip(frames, _motions(state), strict=True):
                kept["position", *frame][i] = motion.p_NoFo_N
                kept["rotation", *frame][i] = euler_parameters_from_matrix(motion.A_NF)
                kept["velocity", *frame][i] = motion.A_NF @ motion.v
                kept["angular_velocity", *frame][i] = motion.w
        for frame in frames:
            e = kept["rotation", *frame]
            turns = np.where(np.einsum("ti,ti->t", e[1:], e[:-1]) < 0, -1.0, 1.0)  # e and -e are one rotation
            e[1:] *= np.cumprod(turns)[:, None]
        return kept

    def _sweeps_of_rates(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        """Return the accelerations of every frame: a = V du + Z, alpha = W du + Y (Eq. 15, 16)."""
        frames = self._frames()
        names = ("acceleration", "angular_acceleration")
        kept = {(name, *frame): np.empty((len(self.times), 3)) for name in names for frame in frames}
        for i, (state, du) in enumerate(self._acting()):
            rates = np.concatenate((du, state.driven_rates))
            for frame, motion in zip(frames, _motions(state), strict=True):
                kept["acceleration", *frame][i] = motion.A_NF @ (motion.V @ rates + motion.Z)
                kept["angular_acceleration", *frame][i] = motion.W @ rates + motion.Y
        return kept

    def _frames(self) -> list[tuple[str, str]]:
        """Return body and interface of every frame, in the order of their motions."""
        return [(shape.name, interface) for shape in self.bodies for interface in ("", *shape.interfaces)]

    def _joint(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self.model.bodies[self.model.index(body)]
        run, model = self.trajectory, self.model
        q = np.array([terms.joint_coordinates(t, q) for t, q in zip(run.times, run.coordinates, strict=True)])
        u = np.array([model.all_speeds(t, u)[terms.speeds] for t, u in zip(run.times, run.speeds, strict=True)])
        q = q.reshape(len(self.times), -1)
        return {("joint_coordinates", body, ""): q, ("joint_speeds", body, ""): u}

    def _modes(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self.model.flexible_terms(body)
        return {
            ("modal_coordinates", body, ""): np.array(self.trajectory.coordinates[:, terms.eta]),
            ("modal_speeds", body, ""): np.array(self.trajectory.speeds[:, terms.speeds]),
        }

    def _deflection(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self.model.flexible_terms(body)
        frame = terms.body.interface(interface)
        eta = self.trajectory.coordinates[:, terms.eta]
        return {("deflection", body, interface): frame.displacements(eta)}

    def _energies(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        run, route = self.trajectory, self.model.route
        kinetic, elastic, gravity = zip(*(route.energy(t, y) for t, y in self._states()), strict=True)
        return {
            ("kinetic_energy", "", ""): np.array(kinetic),
            ("elastic_energy", "", ""): np.array(elastic),
            ("gravity_energy", "", ""): np.array(gravity),
            ("dissipated_energy", "", ""): np.array(run.dissipated),
            ("work", "", ""): np.array(run.work),
        }

    def _momenta(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        linear, angular = zip(*(self.model.route.momenta(t, y) for t, y in self._states()), strict=True)
        return {("linear_momentum", "", ""): np.array(linear), ("angular_momentum", "", ""): np.array(angular)}

    def _reactions(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        wrenches = np.array([joint_reactions(state, du) for state, du in self._acting()])
        return {("joint_reaction", b.name, ""): wrenches[:, i].copy() for i, b in enumerate(self.bodies)}

    def _residuals(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        """Return all driving forces, and the coupling forces of all interfaces with components fixed in G."""
        forces = np.array([np.concatenate(recovered_forces(state, du)) for state, du in self._acting()])
        kept: dict[Key, np.ndarray] = {}
        start = self.model.free_count
        for terms in self.model.bodies:
            if terms.is_driven:
                driving = forces[:, terms.speeds[list(terms.driven)] - start]
                kept["driving_force", terms.name, ""] = driving[:, 0].copy() if driving.shape[1] == 1 else driving
            if terms.flexible is None:
                continue
            for frame in terms.flexible.body.interfaces:
                if frame.fixed_components:
                    first = terms.flexible.fixed.start - terms.flexible.body.free_count - start
                    along = np.kron(np.eye(2), frame.axes)  # F_u are along the axes of the interface
                    wrench = self._carried(terms, frame) @ along
                    wrench[:, frame.fixed_components] = forces[:, [first + column for column in frame.fixed_columns]]
                    kept["coupling_force", terms.name, frame.name] = wrench @ along.T
        return kept

    def _loop_forces(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        forces = [loop_forces(state) for state, _ in self._acting()]
        return {("loop_force", name, ""): np.array([force[name] for force in forces]) for name in self.loops}

    def _coupling(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self.model.bodies[self.model.index(body)]
        frame = self.model.flexible_terms(body).body.interface(interface)
        if frame.fixed_components:
            return self._residuals(body, interface)
        return {("coupling_force", body, interface): self._carried(terms, frame)}

    def _carried(self, terms: BodyTerms, frame: InterfaceFrame) -> np.ndarray:
        """Return the wrench of what an interface carries (T, 6); nothing carried, nothing computed."""
        number = self.model.index(terms.name)
        held = [(b.parent, b.parent_interface) for b in self.model.bodies]
        held += [(m.body, m.interface) for c in self.model.constraints for m in (c.a, c.b) if m is not None]
        is_held = any(body == number and n is not None and n.name == frame.name for body, n in held)
        if len(frame.fixed_components) == 6 or not is_held:
            return np.zeros((len(self.times), 6))
        return np.array([self._carried_at(state, number, frame.name, du) for state, du in self._acting()])

    def _carried_at(self, state: State, number: int, interface: str, du: np.ndarray) -> np.ndarray:
        terms = state.model.bodies[number].flexible
        if terms is None:
            raise TypeError("an interface belongs to a flexible body")
        return carried_wrench(state, number, terms.body.interface(interface), du)

    def _loads(self, name: str, interface: str) -> dict[Key, np.ndarray]:
        """Return what loads between frames tell."""
        loads = self.model.loads
        kept = {("load", load.name, ""): np.empty((len(self.times), len(load.columns))) for load in loads}
        for row, state in enumerate(self._views()):
            for i, load in enumerate(state.model.loads):
                told = load.tell(state.t, state.load_ends(i), state.load_states(i))
                kept["load", load.name, ""][row] = told
        return kept


def _motions(state: State) -> list[FrameMotion]:
    """Return the motion of every frame: of each body, and of its interfaces in their own axes."""
    motions: list[FrameMotion] = []
    for number, body in enumerate(state.model.bodies):
        motions.append(state.motions[number])
        if body.flexible is not None:
            motions += [state.motion(number, n).turned(n.axes) for n in body.flexible.body.interfaces]
    return motions


_COMPUTE: dict[str, Callable[[RunChannels, str, str], dict[Key, np.ndarray]]] = {
    **dict.fromkeys(("position", "rotation", "velocity", "angular_velocity"), RunChannels._sweeps),
    **dict.fromkeys(("acceleration", "angular_acceleration"), RunChannels._sweeps_of_rates),
    **dict.fromkeys(("joint_coordinates", "joint_speeds"), RunChannels._joint),
    **dict.fromkeys(MODES, RunChannels._modes),
    **dict.fromkeys(MOMENTA, RunChannels._momenta),
    **dict.fromkeys(ENERGIES, RunChannels._energies),
    "deflection": RunChannels._deflection,
    "joint_reaction": RunChannels._reactions,
    "driving_force": RunChannels._residuals,
    "loop_force": RunChannels._loop_forces,
    "coupling_force": RunChannels._coupling,
    "load": RunChannels._loads,
}
