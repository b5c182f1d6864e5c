"""Tables of the forces that are told of a scene: see `kanefe.kernels.evaluation.force_tables`."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kanefe.kernels.constraints.loop_tables import exerted_size
from kanefe.kernels.contact.output_places import CONTACT_OUTPUTS, POINT_OUTPUTS
from kanefe.kernels.contact.rigid_points import CONTACT
from kanefe.kernels.evaluation.force_tables import (
    CONTACTS,
    DRIVING,
    GEAR_FORCES,
    LOOP_FORCES,
    OF_CARRIER,
    OF_CHILD,
    OF_LOAD,
    OF_LOOP,
    OF_POINT_LOAD,
    PARTS,
    POINTS,
    REACTIONS,
    WRENCH,
    ForceTables,
    ForceWork,
)
from kanefe.kernels.loads.acting import BetweenLoads
from kanefe.kernels.tables import LoadsBetween, Loops
from kanefe.kernels.values.records import laid_out
from kanefe.order_n.tables.frame_offsets import FrameOffsets
from kanefe.tree.body_terms import FlexibleTerms
from kanefe.tree.model_data import QUADRATURES, ModelData
from kanefe.tree.neighbours import BODY, LOAD, LOOP, InterfacePart, Source, parts_of

DIRECTIONS = 3
"""Number of rows of a contact point: along the normal, and in both directions along the surface."""

DETERMINED = 1e-9
"""Smallest singular value, relative to the largest, with which fixed components count as statically determined."""


class ForceTableBuilder:
    """Writes the tables.

    Parameters
    ----------
    builder : FrameOffsets
        Of tables in which every body and every interface has a row.
    between : LoadsBetween
    order : list of int
        Numbers in the model of its loads.
    loops : Loops

    Attributes
    ----------
    tables : ForceTables
    first_ends : dict of int to int
        Number of the first end of each load, by its number in the model.
    first_points : list of int
        Number of the first point of each rigid contact, and of all points.
    undetermined : set of int
        Numbers of parts that the tables do not have: of components fixed in G that share forces in several ways.
    """

    def __init__(self, builder: FrameOffsets, between: LoadsBetween, order: list[int], loops: Loops) -> None:
        self._builder = builder
        self._model = model = builder.model
        self.first_ends = {n: load.first_end for n, load in zip(order, BetweenLoads(between.loads), strict=True)}
        self._rows_of_loops = _rows_of_loops(model)
        self._first_contact_row = len(loops.rows) - DIRECTIONS * len(loops.points.places)
        contacts = range(len(model.rigid_contacts) + 1)
        self.first_points = np.searchsorted(loops.points.places[:, CONTACT], contacts).tolist()
        self._components: dict[tuple[int, str], tuple[int, int]] = {}
        self.undetermined: set[int] = set()
        self.by_reaction: dict[int, tuple[int, np.ndarray]] = {}
        held = self._held()
        parts, sources = self._parts(parts_of(model))
        frames = builder.frame_offsets
        two_ended = [self._rows_of_loops[c.name] for c in model.constraints if c.b is not None]
        gears = list(_gear_terms(model))
        sizes = (
            model.coordinate_count + model.free_count + model.state_count + QUADRATURES,
            WRENCH * len(frames),
            model.driven_count,
            WRENCH * len(two_ended),
            len(gears),
            WRENCH * len(parts),
            WRENCH * len(between.ends),
            CONTACT_OUTPUTS * len(model.rigid_contacts),
            POINT_OUTPUTS * len(loops.points.places),
        )
        self.tables = ForceTables(
            bodies=np.array([frame.row for frame in frames], dtype=np.int64),
            frames=np.array([(*frame.place, *frame.axes.ravel()) for frame in frames]).reshape(-1, 12),
            loops=np.array(two_ended, dtype=np.int64).reshape(-1, 2),
            gear_rows=np.array([self._rows_of_loops[name][0] for name, _ in gears], dtype=np.int64),
            coefficients=np.array([coefficient for _, coefficient in gears], dtype=float),
            **held,
            parts=np.array(parts, dtype=np.int64).reshape(-1, 3),
            sources=np.array(sources, dtype=np.int64).reshape(-1, 4),
            places=np.array((0, *np.cumsum(sizes)), dtype=np.int64),
            work=laid_out(
                ForceWork,
                state_count=model.state_count,
                end_count=len(between.ends),
                component_count=len(held["components"]),
                exerted_size=exerted_size(loops),
            ),
        )

    def numbers_of_parts(self, body: str, interface: str) -> list[int]:
        """Return the numbers of the parts of the force at an interface, which are one after the other."""
        parts = enumerate(parts_of(self._model))
        return [i for i, part in parts if (self._model.bodies[part.body].name, part.interface) == (body, interface)]

    def place(self, quantity: str, name: str, interface: str, component: int) -> tuple[int, int]:
        """Return where a component of a force is in a row of what is told, and how many wrenches are added up.

        Of points of rigid contacts: the component of all, point by point.
        """
        model, places = self._model, self.tables.places.tolist()
        if quantity == "joint_reaction":
            return places[REACTIONS] + WRENCH * model.index(name) + component, 1
        if quantity == "driving_force":
            body = model.bodies[model.index(name)]
            return places[DRIVING] + int(body.speeds[body.driven[component]]) - model.free_count, 1
        if quantity == "loop_force":
            number = [constraint.name for constraint in model.constraints if constraint.b is not None].index(name)
            return places[LOOP_FORCES] + WRENCH * number + component, 1
        if quantity == "gear_force":
            first = [gear for gear, _ in _gear_terms(model)].index(name)
            return places[GEAR_FORCES] + first + component, 1
        if quantity in ("load", "contact_points"):
            number = [model.loads[i].name for i in model.rigid_contacts].index(name)
            if quantity == "load":
                return places[CONTACTS] + CONTACT_OUTPUTS * number + component, 1
            return places[POINTS] + POINT_OUTPUTS * self.first_points[number] + component, 1
        numbers = self.numbers_of_parts(name, interface)
        first = numbers[0] if numbers else 0
        return places[PARTS] + WRENCH * first + component, len(numbers)

    def _held(self) -> dict[str, np.ndarray]:
        """Return the tables of components fixed in G."""
        held: list[tuple[int, int, int, int]] = []
        components: list[tuple[int, int]] = []
        axes: list[np.ndarray] = []
        pool: list[float] = []
        for number, body in enumerate(self._model.bodies):
            terms = body.flexible
            if terms is None or not terms.body.fixed_count or not _is_determined(terms):
                continue
            k, first = terms.body.free_count, len(components)
            held.append((self._builder.frame_offsets[number].row, first, terms.body.fixed_count, len(pool)))
            transform = self._builder.modes[number].transform
            elastic = terms.fixed_elastic[:k] if transform is None else transform[0].T @ terms.fixed_elastic[:k]
            columns: list[int] = []
            for frame in terms.body.interfaces:
                if frame.fixed_components:
                    self._components[number, frame.name] = len(components), len(frame.fixed_components)
                    row = self._builder.interfaces[number, frame.name]
                    components += [(row, component) for component in frame.fixed_components]
                    axes += [frame.axes[:, component % 3] for component in frame.fixed_components]
                    columns += [column - k for column in frame.fixed_columns]
            pool += np.vstack((terms.fixed_rigid, elastic))[:, columns].T.ravel().tolist()
        return {
            "held": np.array(held, dtype=np.int64).reshape(-1, 4),
            "components": np.array(components, dtype=np.int64).reshape(-1, 2),
            "axes": np.array(axes, dtype=float).reshape(-1, 3),
            "pool": np.array(pool, dtype=float),
        }

    def _parts(self, wanted: tuple[InterfacePart, ...]) -> tuple[list[tuple[int, ...]], list[tuple[int, ...]]]:
        parts: list[tuple[int, ...]] = []
        sources: list[tuple[int, ...]] = []
        for number, part in enumerate(wanted):
            own = [row for source in part.sources for row in self._source(part, source)]
            parts.append((self._builder.interfaces[part.body, part.interface], len(sources), len(own)))
            sources += own
            if (
                any(source.kind == BODY and source.end == 0 for source in part.sources)
                and (part.body, part.interface) not in self._components
            ):
                self.undetermined.add(number)
                body = self._model.bodies[part.body]
                frame = self._model.flexible_terms(body.name).body.interface(part.interface)
                if not frame.fixed_components:
                    self.by_reaction[number] = part.body, frame.position
        return parts, sources

    def _source(self, part: InterfacePart, source: Source) -> list[tuple[int, int, int, int]]:
        model = self._model
        if source.kind == BODY and source.end == 0:
            return [(OF_CARRIER, *self._components.get((part.body, part.interface), (0, 0)), 0)]
        if source.kind == BODY:
            return [(OF_CHILD, model.index(source.name), 0, 0)]
        if source.kind == LOOP:
            return [(OF_LOOP, *self._rows_of_loops[source.name], source.end)]
        if source.kind == LOAD:
            number = next(i for i, load in enumerate(model.loads) if load.name == source.name)
            if number in model.rigid_contacts:
                return self._points_on(model.rigid_contacts.index(number), source.end)
            return [(OF_LOAD, self.first_ends[number] + source.end, 1, 0)]
        before = sum(len(body.loads) for body in model.bodies[: part.body])
        return [(OF_POINT_LOAD, before + source.end, 1, 0)]

    def _points_on(self, number: int, end: int) -> list[tuple[int, int, int, int]]:
        """Return the rows of the points of a rigid contact that act on one of its ends; all do on its surface."""
        ends = enumerate(probe_end for probe_end, _ in self._model.rigid_contact(number).probes)
        points = [self.first_points[number] + i for i, probe_end in ends if end in (0, probe_end)]
        return [(OF_LOOP, self._first_contact_row + DIRECTIONS * p, DIRECTIONS, int(end > 0)) for p in points]


def _rows_of_loops(model: ModelData) -> dict[str, tuple[int, int]]:
    """Return the first row of each constraint, and the number of its rows."""
    found: dict[str, tuple[int, int]] = {}
    first = 0
    for constraint in model.constraints:
        found[constraint.name] = first, len(constraint.rows)
        first += len(constraint.rows)
    return found


def _gear_terms(model: ModelData) -> Iterator[tuple[str, float]]:
    """Yield name and coefficient of each coordinate that a gear, rack or other coupler couples."""
    for constraint in model.constraints:
        for _, _, coefficient in constraint.terms:
            yield constraint.name, coefficient


def _is_determined(terms: FlexibleTerms) -> bool:
    """Return whether the wrench on a body determines the forces along its fixed components."""
    values = np.linalg.svd(terms.fixed_rigid, compute_uv=False)
    fixed = terms.body.fixed_count
    return len(values) >= fixed and bool(values[fixed - 1] > DETERMINED * values[0])
