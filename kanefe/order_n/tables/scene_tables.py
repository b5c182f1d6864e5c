"""From the frozen model to the rows of the kernels: links, interfaces, constants of flexible bodies.

This is where it is decided what a scene needs. Joints of several coordinates become chains of links with one axis,
which is z; rigid bodies fixed to rigid bodies melt into them; interfaces have rows only where something is attached.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kernels.beams import ExactBeam
from kanefe.kernels.bodies import BorderedBody, ModalBody
from kanefe.kernels.compiler.addresses import addresses
from kanefe.kernels.links.places import SIGNATURE
from kanefe.kernels.loads.point_and_field_loads import Traction
from kanefe.kernels.sweeps.slopes import Slopes
from kanefe.kernels.tables import FlexibleTables, Tables
from kanefe.kernels.tree import LINK_INTEGERS, GivenLink, InterfaceLink, Kind, Link
from kanefe.kernels.values import tensors
from kanefe.kernels.values.filled import filled_rows, room
from kanefe.order_n.tables.exact_beam_tables import (
    BEAM_LENGTHS,
    beam_numbers,
    constants_of_beam,
    place_of_motion,
    put_beam,
)
from kanefe.order_n.tables.frame_offsets import FrameOffset, FrameOffsets
from kanefe.order_n.tables.load_tables import attached_interfaces, joint_force_tables, point_load_tables
from kanefe.order_n.tables.modal_constants import modal_constants
from kanefe.tree.body_terms import BodyTerms
from kanefe.tree.model_data import ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame

UPPER = np.triu_indices(3)
"""Indices of the six kept values of a symmetric matrix, row by row."""

SLOPE_CODES = {"rotation-vector": Slopes.ROTATION_VECTOR, "tait-bryan": Slopes.TAIT_BRYAN}


@dataclass(eq=False)
class _Pool:
    """Numbers that flexible bodies or given links bring, one after the other."""

    parts: list[np.ndarray] = field(default_factory=list)
    size: int = 0

    def add(self, *arrays: Any) -> int:
        start = self.size
        for array in arrays:
            flat = np.asarray(array, dtype=float).ravel()
            self.parts.append(flat)
            self.size += len(flat)
        return start


class TableBuilder(FrameOffsets):
    """Writes the tables of a model and remembers where its frames went.

    Parameters
    ----------
    model : ModelData
    is_complete : bool
        Whether every body has a row of its own, and interfaces have rows to which nothing is attached.
    """

    def __init__(self, model: ModelData, is_complete: bool = False) -> None:
        super().__init__(model)
        self._rows: list[tuple[np.ndarray, np.ndarray]] = []
        self._links: list[Link] = []
        self._bodies: list[np.ndarray] = []
        self._pool = _Pool()
        self._of_links = _Pool()
        self._carrying: list[int] = []
        self._fields: list[dict[str, int]] = []
        self._modal = self._border = 0
        self._is_complete = is_complete
        wanted = attached_interfaces(model, self.point_bodies, is_complete)
        for number, body in enumerate(model.bodies):
            self._add_body(number, body, wanted[number])

    def tables(self) -> tuple[Tables, FlexibleTables]:
        """Return the tables, and those of flexible bodies, which are empty where there are none."""
        model = self.model
        point_loads, joint_forces = point_load_tables(self), joint_force_tables(self)
        tables = Tables(
            rows=np.array([integers for integers, _ in self._rows]).reshape(-1, LINK_INTEGERS),
            geometry=np.array([numbers for _, numbers in self._rows]).reshape(-1, Link.number_count),
            gravity=np.array(model.gravity),
            loads=point_loads[0],
            points=point_loads[1],
            joint_forces=joint_forces[0],
            laws=joint_forces[1],
            sizes=np.array((model.coordinate_count, model.free_count, model.driven_count, model.state_count)),
            numbers=np.concatenate((*self._of_links.parts, np.zeros(0))),
        )
        return tables, FlexibleTables(
            bodies=np.array(self._bodies, dtype=np.int64).reshape(-1, ExactBeam.integer_count),
            pool=np.concatenate((*self._pool.parts, np.zeros(0))),
            carrying=np.array(self._carrying, dtype=np.int64),
            fields=filled_rows(Traction, self._fields)[0],
            sizes=np.array((self._modal, self._border, SLOPE_CODES[model.slopes.name])),
        )

    def _add_body(self, number: int, body: BodyTerms, attached: dict[str, tuple[InterfaceFrame, bool]]) -> None:
        parent = self.frame_offset(body.parent, body.parent_interface)
        place = parent.place + parent.axes @ body.p_PoFo_P
        axes = parent.axes @ body.A_PF
        if self._melts(body, parent.row):
            frame_offset = FrameOffset(parent.row, axes, place)
        else:
            frame_offset = self._add_links(body, parent.row, place, axes)
        if body.rigid is not None:
            self._add_mass(body, frame_offset)
        elif body.flexible is not None:
            if not np.array_equal(frame_offset.axes, np.eye(3)):
                frame_offset = FrameOffset(
                    self._add_row(Kind.FIXED, frame_offset.row, frame_offset.place, frame_offset.axes),
                    np.eye(3),
                    np.zeros(3),
                )
            self._add_flexible(number, body, frame_offset.row, attached)
        self.frame_offsets.append(frame_offset)

    def _melts(self, body: BodyTerms, row: int) -> bool:
        """Return whether a body is a rigid part of the row it is fixed to."""
        if self._is_complete or row < 0 or body.rigid is None or not body.joint.is_fixed:
            return False
        link = self._links[row]
        is_rigid = link.kind != Kind.INTERFACE and link.flexible < 0
        return is_rigid and link.has_gravity == body.has_gravity

    def _add_links(self, body: BodyTerms, parent: int, place: Vector, axes: Matrix) -> FrameOffset:
        row, speed, coordinate = parent, 0, 0
        for joint_link in body.joint.links() or ():
            turn, kernel = joint_link.turn, joint_link.kernel
            row = self._add_row(joint_link.kind, row, place, axes @ turn, joint_link.along, joint_link.about)
            link = self._links[row]
            if kernel is not None:
                given = GivenLink(link)
                given.function, given.complex_function = addresses(kernel.real, kernel.complex_, SIGNATURE)
                given.first_number = self._of_links.add(kernel.numbers)
            if not joint_link.is_fixed:
                link.speed = body.speeds[speed]
                if body.speeds[speed] >= self.model.free_count:
                    link.drive = body.speeds[speed] - self.model.free_count
                else:
                    link.coordinate = body.coordinates[coordinate]
                link.armature = self.model.armatures[link.speed]
            speed, coordinate = speed + joint_link.speed_count, coordinate + joint_link.coordinate_count
            place, axes = np.zeros(3), turn.T
        return FrameOffset(row, axes, place)

    def _add_row(
        self, kind: int, parent: int, place: Vector, axes: Matrix, along: float = 0.0, about: float = 0.0
    ) -> int:
        arrays = np.full(LINK_INTEGERS, -1, dtype=np.int64), np.zeros(Link.number_count)
        link = Link(*arrays)
        link.parent, link.kind, link.has_gravity, link.carries = parent, kind, True, False
        link.place, link.axes = tensors.Vector(*place), tensors.Matrix(*axes.ravel())
        link.along, link.about = along, about
        self._rows.append(arrays)
        self._links.append(link)
        return len(self._links) - 1

    def _add_mass(self, body: BodyTerms, frame_offset: FrameOffset) -> None:
        rigid, link = body.rigid, self._links[frame_offset.row]
        if rigid is None:
            return
        com = frame_offset.place + frame_offset.axes @ rigid.com
        about_origin = frame_offset.axes @ rigid.inertia @ frame_offset.axes.T + rigid.mass * (
            com @ com * np.eye(3) - np.outer(com, com)
        )
        link.mass += rigid.mass
        link.first += tensors.Vector(*(rigid.mass * com))
        link.second += tensors.Symmetric(*about_origin[UPPER])
        link.rotor += tensors.Vector(*(frame_offset.axes @ rigid.rotor))
        link.has_gravity = body.has_gravity

    def _add_flexible(
        self, number: int, body: BodyTerms, row: int, attached: dict[str, tuple[InterfaceFrame, bool]]
    ) -> None:
        terms = body.flexible
        if terms is None:
            return
        k = terms.body.free_count
        line = terms.body.line
        modes = modal_constants(terms) if line is None else constants_of_beam(terms)
        integers, none = np.full(ExactBeam.integer_count, -1, dtype=np.int64), np.zeros(0)
        own = ExactBeam(integers, none, none, none)
        own.k, own.link, own.is_exact = k, row, line is not None
        self._links[row].has_gravity = body.has_gravity
        own.first_eta, own.first_deta = terms.eta.start, terms.speeds.start
        own.constants = self._pool.add(*modes.constants)
        if modes.transform is not None:
            own.transform = self._pool.add(*modes.transform)
        if modes.damping is not None:
            own.damped = self._pool.add(modes.damping)
        own.work = self._modal_space(room(ModalBody, "work", k=k))
        if line is not None:
            put_beam(own, line)
            own.line = self._pool.add(*beam_numbers(line, terms.body.stiffness))
            own.moving = self._modal_space(room(ExactBeam, "moving", **{n: getattr(own, n) for n in BEAM_LENGTHS}))
        if modes.quadratic is not None:
            own.bends_twice = self._pool.add(modes.quadratic)
            own.bending = self._modal_space(room(ModalBody, "bending", k=k))
        if modes.fluid is not None:
            own.wet = self._pool.add(*modes.fluid)
        own.arm_count = 0
        for arms in (arms for load, arms in self.arms.items() if self.model.loads[load].ends[0].body == number):
            own.arm_count, own.springs = len(arms), self._pool.add(arms)
        flexible = len(self._bodies)
        self.modes[number], self.flexible_numbers[number] = modes, flexible
        self._links[row].flexible = flexible
        own.carried = len(self._carrying)
        self._add_interfaces(number, own, attached)
        own.carried_count = len(self._carrying) - own.carried
        own.border = self._border
        self._border += room(BorderedBody, "border", k=k, carried_count=own.carried_count)
        self._add_field_loads(body, flexible, modes, k)
        self._bodies.append(integers)

    def _add_interfaces(self, number: int, own: ExactBeam, attached: dict[str, tuple[InterfaceFrame, bool]]) -> None:
        """Add a row for each interface of a flexible body to which something is attached."""
        from kanefe.bodies.exact.beam import SectionFrame

        modes, k = self.modes[number], own.k
        for name, (frame, carries) in attached.items():
            axes = frame.at_rest.T if isinstance(frame, SectionFrame) else np.eye(3)
            at = self._add_row(Kind.INTERFACE, own.link, frame.position, axes)
            link = InterfaceLink(self._links[at])
            link.flexible, link.carries = self.flexible_numbers[number], carries
            if not isinstance(frame, SectionFrame):
                link.basis = self._pool.add(modes.of_interface(frame.motion[:, :k]))
            else:
                link.basis, link.bent = frame.station, place_of_motion(own, frame.station)
            if frame.quadratic is not None and k:
                link.bending = self._pool.add(modes.of_bending(frame.quadratic[:, :k, :k]))
                link.bent = self._modal_space(12 * k)
            self.interfaces[number, name] = at
            if carries:
                self._carrying.append(at)

    def _add_field_loads(self, body: BodyTerms, flexible: int, modes: Any, k: int) -> None:
        """Add the distributed loads on a flexible body, by its number among these."""
        for load in body.field_loads:
            constants = self._pool.add(*modes.of_field(load, k))
            quadratic, change, changes, bent = load.pattern.quadratic_first, load.pattern.pressure_change, -1, -1
            if load.is_pressure and load.follows and change is not None and k:
                changes = self._pool.add(*modes.of_following(change, k))
            elif quadratic is not None and k and not load.is_pressure:
                changes, bent = self._pool.add(modes.of_bending(quadratic[:, :k, :k])), self._modal_space(3 * k)
            kinds = {"is_pressure": load.is_pressure, "follows": load.follows, "first_input": self.inputs.of(load)}
            places = {"constants": constants, "changes": changes, "bent": bent}
            self._fields.append({"body": flexible, "mode_count": k} | kinds | places)

    def _modal_space(self, size: int) -> int:
        """Return where so many numbers are in the modal work."""
        start = self._modal
        self._modal += size
        return start
