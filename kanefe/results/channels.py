"""Channels: the outputs of a run, each computed when it is first read.

`Result` reads nothing but channels, so that a run in memory and a saved one give the same results.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kanefe.bodies.exact.inertia import BeamInertia
from kanefe.bodies.mass_moments import MassMoments
from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.integrate.sampling import ControllerLog
from kanefe.integrate.status import RunStatus
from kanefe.integrate.trajectory import Trajectory
from kanefe.joints.motion import of_body
from kanefe.loads.base import Load
from kanefe.results.body_shape import BodyShape, body_shapes
from kanefe.results.contact_history import is_contact
from kanefe.results.contact_points import in_columns
from kanefe.results.interface_forces import coupling_force
from kanefe.results.load_lines import LoadLine, lines_of_run
from kanefe.results.placed_states import placed_states
from kanefe.results.quantities import ENERGIES, MODES, MOMENTA
from kanefe.results.recorded import Recorded
from kanefe.results.surface_outline import SurfaceOutline, outlines
from kanefe.tree.run_sweeps import OutputFunction, RunForces, RunSweeps
from kanefe.tree.scene_state import SceneState

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.constraints.rows import Constraint
    from kanefe.results.literal_sweeps import LiteralSweeps

Key = tuple[str, ...]
"""Quantity, body ("" for the whole scene), interface ("" for the body's own frame), and name of a part."""


class Channels(Protocol):
    """Where a result reads from.

    `has_forces`: whether accelerations and all forces can be read; `loops`: names of loop joints and other constraints
    with two ends; `gears`: names of couplers, and of the coordinates that each couples; `loads`: names of loads between
    frames, and of their outputs; `points`: number of points of each contact.
    """

    times: np.ndarray
    statistics: dict[str, Any]
    status: RunStatus
    events: Mapping[str, np.ndarray]
    controllers: Mapping[str, ControllerLog]
    records: Mapping[str, Recorded]
    loops: tuple[str, ...]
    gears: Mapping[str, tuple[str, ...]]
    loads: Mapping[str, tuple[str, ...]]
    has_forces: bool

    @property
    def points(self) -> Mapping[str, int]:
        """Number of points of each contact, by its name."""
        ...

    @property
    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies of the scene."""
        ...

    @property
    def surfaces(self) -> tuple[SurfaceOutline, ...]:
        """Outlines of the surfaces of the scene."""
        ...

    def load_lines(self, rows: np.ndarray) -> tuple[LoadLine, ...]:
        """Return the lines of loads that act along one, at output times given by number."""
        ...

    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
        """Return a channel, or a part of a coupling force, time first; names are known to exist."""
        ...


class RunChannels:
    """Channels of a run in memory. Quantities of one sweep are computed together and cached.

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
        self.controllers: Mapping[str, ControllerLog] = trajectory.controllers
        self.records: Mapping[str, Recorded] = trajectory.records
        self.loops = tuple(constraint.name for constraint in model.constraints if constraint.b is not None)
        self.gears: Mapping[str, tuple[str, ...]] = {c.name: _coupled(model, c) for c in model.constraints if c.terms}
        self.loads: Mapping[str, tuple[str, ...]] = {load.name: load.columns for load in model.loads}
        self.has_forces = True
        self._kept: dict[Key, np.ndarray] = {}
        self._du = trajectory.accelerations

    @cached_property
    def points(self) -> Mapping[str, int]:
        """Number of points of each contact, by its name."""
        return {load.name: len(load.probes) for load in self.model.loads if is_contact(load.columns)}  # type: ignore[attr-defined]

    @cached_property
    def bodies(self) -> tuple[BodyShape, ...]:
        """Bodies of the scene."""
        return body_shapes(self.model)

    @cached_property
    def surfaces(self) -> tuple[SurfaceOutline, ...]:
        """Outlines of the surfaces of the scene."""
        return outlines(self.model)

    def read(self, quantity: str, body: str = "", interface: str = "", of: str = "") -> np.ndarray:
        """Return a channel, or a part of a coupling force, time first."""
        key: Key = (quantity, body, interface, of) if of else (quantity, body, interface)
        if key not in self._kept:
            if quantity == "coupling_force":
                found: dict[Key, np.ndarray] = {key: coupling_force(self, body, interface, of)}
            else:
                found = _COMPUTE[quantity](self, body, interface)
            for new, array in found.items():
                array.flags.writeable = False
                self._kept[new] = array
        return self._kept[key]

    def accelerations(self) -> np.ndarray:
        """Return du of the free speeds at all times, (T, free)."""
        if self._du is None:
            n, m = self.model.coordinate_count, self.model.free_count
            self._du = self.swept.rates[:, n : n + m]
        return self._du

    @cached_property
    def states(self) -> np.ndarray:
        """States ``y = (q, u, z)`` at the output times, (T, state)."""
        run = self.trajectory
        return np.hstack((run.coordinates, run.speeds, run.internal))

    @cached_property
    def swept(self) -> RunSweeps:
        """Quantities of all states: by compiled sweeps at once, or by the literal route, which has none."""
        return self.model.route.sweeps(self.times, self.states) or self.literal

    @cached_property
    def literal(self) -> LiteralSweeps:
        """Quantities of all states by the literal route."""
        from kanefe.results.literal_sweeps import LiteralSweeps

        return LiteralSweeps(self.model, self.times, self.states, self.accelerations)

    @property
    def is_swept(self) -> bool:
        """Whether the motion of any frame is found for all states at once."""
        return self.swept is not self.__dict__.get("literal")

    def load_lines(self, rows: np.ndarray) -> tuple[LoadLine, ...]:
        """Return the lines of loads that act along one, at output times given by number."""
        return lines_of_run(self, rows)

    def placed(self, rows: Sequence[int] | np.ndarray) -> Iterator[SceneState]:
        """Yield the positions and motions of all frames at some output times, given by number."""
        if self.is_swept:
            return placed_states(self.model, self.trajectory, self.swept, rows)
        return (self.model.route.view(float(self.times[row]), self.states[row]) for row in rows)

    def _motions(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        frame = self.swept.frame(*self._frame(body, interface))
        return {
            ("position", body, interface): frame.position.copy(),
            ("velocity", body, interface): frame.velocity.copy(),
            ("angular_velocity", body, interface): _in_axes(frame.axes, frame.angular_velocity),
        }

    def _rotations(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        return {("rotation", body, interface): self.swept.rotation(*self._frame(body, interface))}

    def _accelerated(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        frame = self.swept.frame(*self._frame(body, interface), is_accelerated=True)
        if frame.acceleration is None or frame.angular_acceleration is None:
            raise TypeError("accelerations were requested")
        return {
            ("acceleration", body, interface): frame.acceleration.copy(),
            ("angular_acceleration", body, interface): _in_axes(frame.axes, frame.angular_acceleration),
        }

    def _centres(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        """Return the centre of mass of a body; of the scene, the weighted mean over its bodies."""
        key = ("center_of_mass", body, "")
        if not body:
            masses = {shape.name: shape.mass for shape in self.bodies if shape.mass > 0.0}
            if not masses:
                raise ModelError("nothing in the scene has mass: it has no centre of mass")
            parts = [mass * self.read("center_of_mass", name) for name, mass in masses.items()]
            return {key: np.sum(parts, axis=0) / sum(masses.values())}
        frame = self.swept.frame(*self._frame(body, ""))
        local = self._local_centres(self.model.index(body))
        return {key: frame.position + np.einsum("tij,tj->ti", frame.axes, local)}

    def _local_centres(self, number: int) -> np.ndarray:
        """Return the centre of mass of a body in its frame, (T, 3)."""
        terms = self.model.bodies[number].flexible
        if terms is None:
            return np.broadcast_to(self.bodies[number].com, (len(self.times), 3))
        if isinstance(terms.free_moments, (MassMoments, BeamInertia)):
            eta = self.trajectory.coordinates[:, terms.eta]
            return terms.free_moments.first_moments(eta) / float(terms.free_moments.mass)
        # without loads, the states of an unreduced body do not have its mass in its frames
        literal = self.literal
        states = (state for state, _ in literal.acting()) if self.model.has_unreduced else literal.views()
        return np.array([_local_centre(state, number) for state in states])

    def _frame(self, body: str, interface: str) -> tuple[int, InterfaceFrame | None]:
        number = self.model.index(body)
        return number, self.model.flexible_terms(body).body.interface(interface) if interface else None

    def _joint(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        terms = self.model.bodies[self.model.index(body)]
        run, T = self.trajectory, len(self.times)
        q, u = np.empty((T, len(terms.coordinates))), np.empty((T, len(terms.speeds)))
        if not terms.is_driven:
            q[:], u[:] = run.coordinates[:, terms.coordinates], run.speeds[:, terms.speeds]
        else:  # as many coordinates as speeds, one by one
            for i, motion in enumerate(terms.joint.motions):
                if motion is None:
                    q[:, i], u[:, i] = run.coordinates[:, terms.coordinates[i]], run.speeds[:, terms.speeds[i]]
                else:
                    q[:, i], u[:, i] = motion.over(self.times, of_body(body))[:, :2].T
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
        found, run = self.swept.balances, self.trajectory
        of_states = {(name, "", ""): found[:, i].copy() for i, name in enumerate(ENERGIES) if i < 3}
        return of_states | {
            ("dissipated_energy", "", ""): np.array(run.dissipated),
            ("work", "", ""): np.array(run.work),
            ("impact_energy", "", ""): self._given_by_impacts(),
        }

    def _given_by_impacts(self) -> np.ndarray:
        """Return the energy that impacts of rigid contacts have given, (T,)."""
        model, run = self.model, self.trajectory
        if not model.rigid_contacts:
            return np.zeros(len(run.times))
        from kanefe.contact.rigid.rigid_contact import TAKEN

        return np.asarray(
            -run.internal[:, [model.load_states[i].start + TAKEN for i in model.rigid_contacts]].sum(axis=1)
        )

    def _momenta(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        found = self.swept.balances
        return {("linear_momentum", "", ""): found[:, 3:6].copy(), ("angular_momentum", "", ""): found[:, 6:].copy()}

    def _reactions(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        return {("joint_reaction", body, ""): self.forces.reactions[:, self.model.index(body)].copy()}

    @property
    def forces(self) -> RunForces:
        """All forces at all times, from one pass."""
        return self.swept.forces

    def _drives(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        """Return all driving forces."""
        kept: dict[Key, np.ndarray] = {}
        for terms in self.model.bodies:
            if terms.is_driven:
                driving = self.forces.driving[:, terms.speeds[list(terms.driven)] - self.model.free_count]
                kept["driving_force", terms.name, ""] = driving[:, 0].copy() if driving.shape[1] == 1 else driving
        return kept

    def _loop_forces(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        wrenches = self.forces.loops
        return {("loop_force", name, ""): wrenches[:, i].copy() for i, name in enumerate(self.loops)}

    def _gear_forces(self, body: str, interface: str) -> dict[Key, np.ndarray]:
        ends = np.cumsum([len(columns) for columns in self.gears.values()])[:-1]
        forces = np.split(self.forces.gears, ends, axis=1)
        return {("gear_force", name, ""): own.copy() for name, own in zip(self.gears, forces, strict=True)}

    def _told(self, quantity: str) -> dict[int, np.ndarray]:
        """Return outputs of loads at all times by compiled functions, of those that have one, by their numbers."""
        found = {i: output_function(load, quantity) for i, load in enumerate(self.model.loads)}
        functions = {i: function for i, function in found.items() if function is not None}
        return self.swept.outputs_of_loads(functions) if functions else {}

    def _points(self, name: str, interface: str) -> dict[Key, np.ndarray]:
        from kanefe.contact.contact import compliant_contacts
        from kanefe.contact.contact_point_outputs import POINT_OUTPUTS, contact_point_outputs

        number = next(i for i, load in enumerate(self.model.loads) if load.name == name)
        if number in self.model.rigid_contacts:
            told = {number: self.forces.contact_points(self.model.rigid_contacts.index(number))}
        else:
            told = self._told("contact_points")
        if number not in told:
            contact = dict(compliant_contacts(self.model.loads))[number]
            states = self.placed(range(len(self.times)))
            told[number] = np.array(
                [contact_point_outputs(contact, state.load_ends(number), state.load_states(number)) for state in states]
            )
        shape = len(self.times), -1, POINT_OUTPUTS
        return {("contact_points", self.model.loads[i].name, ""): in_columns(x.reshape(shape)) for i, x in told.items()}

    def _loads(self, name: str, interface: str) -> dict[Key, np.ndarray]:
        loads, told = self.model.loads, self._told("load")
        told |= {i: self.forces.contact(number) for number, i in enumerate(self.model.rigid_contacts)}
        rest = [i for i in range(len(loads)) if i not in told]
        told |= {i: np.empty((len(self.times), len(loads[i].columns))) for i in rest}
        for row, state in enumerate(self.placed(range(len(self.times))) if rest else ()):
            for i in rest:
                told[i][row] = loads[i].tell(state.time, state.load_ends(i), state.load_states(i))
        return {("load", load.name, ""): told[i] for i, load in enumerate(loads)}


def output_function(load: Load, quantity: str) -> tuple[OutputFunction, int] | None:
    """Return the compiled function that writes outputs of a load, "load" or "contact_points", and their number."""
    kernel = load.kernel
    if kernel is None:
        return None
    if quantity == "load":
        return None if kernel.tell is None else (kernel.tell, len(load.columns))
    if not is_contact(load.columns):
        return None
    from kanefe.kernels.contact.contact_outputs import contact_point_outputs
    from kanefe.kernels.contact.output_places import POINT_OUTPUTS

    return contact_point_outputs, POINT_OUTPUTS * len(load.probes)  # type: ignore[attr-defined]


def _coupled(model: Model, constraint: Constraint) -> tuple[str, ...]:
    """Return body and coordinate, with its unit, of each term of a coupler."""
    bodies = model.bodies
    return tuple(f"{bodies[i].name} {bodies[i].joint.coordinate_names[k]}" for i, k, _ in constraint.terms)


def _in_axes(axes: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors in N (T, 3) in components of frames with the axes A_NF (T, 3, 3)."""
    return np.einsum("ti,tij->tj", vectors, axes)


def _local_centre(state: SceneState, number: int) -> np.ndarray:
    """Return the centre of mass of a flexible body in G, from its generalised mass, which has the block m c~."""
    terms = state.model.bodies[number].flexible
    if terms is None:
        raise TypeError("the centre of mass of a rigid body is given")
    eta = state.q[terms.eta]
    mass, _ = terms.free_moments.terms(eta, np.zeros_like(eta), np.zeros(3))
    return np.array((mass[5, 1], mass[3, 2], mass[4, 0])) / mass[0, 0]


_COMPUTE: dict[str, Callable[[RunChannels, str, str], dict[Key, np.ndarray]]] = {
    **dict.fromkeys(("position", "velocity", "angular_velocity"), RunChannels._motions),
    "rotation": RunChannels._rotations,
    "center_of_mass": RunChannels._centres,
    **dict.fromkeys(("acceleration", "angular_acceleration"), RunChannels._accelerated),
    **dict.fromkeys(("joint_coordinates", "joint_speeds"), RunChannels._joint),
    **dict.fromkeys(MODES, RunChannels._modes),
    **dict.fromkeys(MOMENTA, RunChannels._momenta),
    **dict.fromkeys(ENERGIES, RunChannels._energies),
    "deflection": RunChannels._deflection,
    "joint_reaction": RunChannels._reactions,
    "driving_force": RunChannels._drives,
    "loop_force": RunChannels._loop_forces,
    "gear_force": RunChannels._gear_forces,
    "load": RunChannels._loads,
    "contact_points": RunChannels._points,
}
