"""Tables of the forces that are told of a scene: see `kanefe.kernels.evaluation.force_tables`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from kanefe.kernels.constraints.loop_tables import exerted_size
from kanefe.kernels.contact.output_places import CONTACT_OUTPUTS, POINT_OUTPUTS
from kanefe.kernels.contact.rigid_points import given_points
from kanefe.kernels.evaluation.force_tables import (
    FixedComponent,
    ForceTables,
    ForceWork,
    HeldBody,
    SourceKind,
    ToldForces,
    ToldGear,
    ToldLoop,
    ToldPart,
    ToldSource,
)
from kanefe.kernels.force_elements.places import WRENCH
from kanefe.kernels.loads.acting import BetweenLoads
from kanefe.kernels.loads.markers import Marker
from kanefe.kernels.tables import LoadsBetween, Loops
from kanefe.kernels.values.filled import filled_rows, laid_out, place
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
        self.first_points = np.searchsorted([one.contact for one in given_points(loops.points)], contacts).tolist()
        self._components: dict[tuple[int, str], tuple[int, int]] = {}
        self.undetermined: set[int] = set()
        self.by_reaction: dict[int, tuple[int, np.ndarray]] = {}
        self.tables = self._put_down(between, loops)
        self.told = ToldForces(self.tables.told, np.zeros(0))

    def _put_down(self, between: LoadsBetween, loops: Loops) -> ForceTables:
        """Return the tables for compiled code."""
        model = self._model
        bodies = [{"row": one.row, "point": one.place, "axes": one.axes} for one in self._builder.frame_offsets]
        loops_told = [self._rows_of_loops[c.name] for c in model.constraints if c.b is not None]
        gears = [(self._rows_of_loops[name][0], coefficient) for name, coefficient in _gear_terms(model)]
        held, components, pool = self._held()
        parts, sources = self._parts(parts_of(model))
        told = laid_out(
            ToldForces,
            rate_count=model.coordinate_count + model.free_count + model.state_count + QUADRATURES,
            body_count=len(bodies),
            drive_count=model.driven_count,
            loop_count=len(loops_told),
            gear_count=len(gears),
            part_count=len(parts),
            end_count=len(between.ends),
            contact_count=len(model.rigid_contacts),
            point_count=len(loops.points.places),
        )
        return ForceTables._make(
            (
                *filled_rows(Marker, bodies),
                *filled_rows(ToldLoop, [{"first": first, "count": count} for first, count in loops_told]),
                *filled_rows(ToldGear, [{"row": row, "coefficient": coefficient} for row, coefficient in gears]),
                *filled_rows(HeldBody, held),
                np.array(pool, dtype=float),
                *filled_rows(FixedComponent, components),
                *filled_rows(ToldPart, parts),
                *filled_rows(ToldSource, sources),
                told,
                laid_out(
                    ForceWork,
                    state_count=model.state_count,
                    end_count=len(between.ends),
                    component_count=len(components),
                    exerted_size=exerted_size(loops),
                ),
            )
        )

    def numbers_of_parts(self, body: str, interface: str) -> list[int]:
        """Return the numbers of the parts of the force at an interface, which are one after the other."""
        parts = enumerate(parts_of(self._model))
        return [i for i, part in parts if (self._model.bodies[part.body].name, part.interface) == (body, interface)]

    def begins(self, forces: str) -> int:
        """Return where some of the forces begin in a row of what is told."""
        return place(self.told, forces)

    def block(self, found: np.ndarray, forces: str) -> np.ndarray:
        """Return some of the forces of all rows, (T, numbers)."""
        size = self.told.fields[forces].kind.size(self.told.__getattribute__)
        return found[:, self.begins(forces) : self.begins(forces) + size]

    def place(self, quantity: str, name: str, interface: str, component: int) -> tuple[int, int]:
        """Return where a component of a force is in a row of what is told, and how many wrenches are added up.

        Of points of rigid contacts: the component of all, point by point.
        """
        model = self._model
        if quantity == "joint_reaction":
            return self.begins("reactions") + WRENCH * model.index(name) + component, 1
        if quantity == "driving_force":
            body = model.bodies[model.index(name)]
            return self.begins("driving") + int(body.speeds[body.driven[component]]) - model.free_count, 1
        if quantity == "loop_force":
            number = [constraint.name for constraint in model.constraints if constraint.b is not None].index(name)
            return self.begins("loops") + WRENCH * number + component, 1
        if quantity == "gear_force":
            first = [gear for gear, _ in _gear_terms(model)].index(name)
            return self.begins("gears") + first + component, 1
        if quantity in ("load", "contact_points"):
            number = [model.loads[i].name for i in model.rigid_contacts].index(name)
            if quantity == "load":
                return self.begins("contacts") + CONTACT_OUTPUTS * number + component, 1
            return self.begins("points") + POINT_OUTPUTS * self.first_points[number] + component, 1
        numbers = self.numbers_of_parts(name, interface)
        first = numbers[0] if numbers else 0
        return self.begins("parts") + WRENCH * first + component, len(numbers)

    def _held(self) -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[float]]:
        """Return bodies with components fixed in G, these, and the motions by them."""
        held, components, pool = list[dict[str, Any]](), list[dict[str, Any]](), list[float]()
        for number, body in enumerate(self._model.bodies):
            terms = body.flexible
            if terms is None or not terms.body.fixed_count or not _is_determined(terms):
                continue
            k, first, row = terms.body.free_count, len(components), self._builder.frame_offsets[number].row
            width, count = WRENCH + k, terms.body.fixed_count
            held.append({"row": row, "first": first, "count": count, "width": width, "constants": len(pool)})
            transform = self._builder.modes[number].transform
            elastic = terms.fixed_elastic[:k] if transform is None else transform[0].T @ terms.fixed_elastic[:k]
            columns: list[int] = []
            for frame in terms.body.interfaces:
                if frame.fixed_components:
                    self._components[number, frame.name] = len(components), len(frame.fixed_components)
                    row = self._builder.interfaces[number, frame.name]
                    components += [
                        {"row": row, "component": one, "axis": frame.axes[:, one % 3]} for one in frame.fixed_components
                    ]
                    columns += [column - k for column in frame.fixed_columns]
            pool += np.vstack((terms.fixed_rigid, elastic))[:, columns].T.ravel().tolist()
        return held, components, pool

    def _parts(self, wanted: tuple[InterfacePart, ...]) -> tuple[list[dict[str, int]], list[dict[str, int]]]:
        parts, sources = list[dict[str, int]](), list[dict[str, int]]()
        for number, part in enumerate(wanted):
            own = [row for source in part.sources for row in self._source(part, source)]
            row = self._builder.interfaces[part.body, part.interface]
            parts.append({"row": row, "first": len(sources), "count": len(own)})
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

    def _source(self, part: InterfacePart, source: Source) -> list[dict[str, int]]:
        model = self._model
        if source.kind == BODY and source.end == 0:
            return [_source(SourceKind.CARRIER, *self._components.get((part.body, part.interface), (0, 0)))]
        if source.kind == BODY:
            return [_source(SourceKind.CHILD, model.index(source.name))]
        if source.kind == LOOP:
            return [_source(SourceKind.LOOP, *self._rows_of_loops[source.name], source.end)]
        if source.kind == LOAD:
            number = next(i for i, load in enumerate(model.loads) if load.name == source.name)
            if number in model.rigid_contacts:
                return self._points_on(model.rigid_contacts.index(number), source.end)
            return [_source(SourceKind.LOAD, self.first_ends[number] + source.end)]
        before = sum(len(body.loads) for body in model.bodies[: part.body])
        return [_source(SourceKind.POINT_LOAD, before + source.end)]

    def _points_on(self, number: int, end: int) -> list[dict[str, int]]:
        """Return the rows of the points of a rigid contact that act on one of its ends; all do on its surface."""
        ends = enumerate(probe_end for probe_end, _ in self._model.rigid_contact(number).probes)
        points = [self.first_points[number] + i for i, probe_end in ends if end in (0, probe_end)]
        rows = [self._first_contact_row + DIRECTIONS * p for p in points]
        return [_source(SourceKind.LOOP, row, DIRECTIONS, int(end > 0)) for row in rows]


def _source(kind: SourceKind, first: int, count: int = 1, end: int = 0) -> dict[str, int]:
    return {"kind": kind, "first": first, "count": count, "end": end}


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
