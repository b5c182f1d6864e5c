"""Sources of the forces at interfaces of flexible bodies, by name: parents and children, loops, loads, given forces.

The paper has known forces and unknown coupling forces at the nodes, ``F_n = F_k + F_u`` (Eq. 30). Unknown are those
that follow from the equations: forces of joints, loops and rigid contacts. Known are functions of positions, speeds and
time.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.bodies.marker import CoordinateMarker
from kanefe.errors import ModelError
from kanefe.tree.load_names import named_loads

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
    from kanefe.bodies.marker import Marker
    from kanefe.tree.model_data import ModelData

F_U, F_K = "F_u", "F_k"
"""Names of the unknown and the known forces at an interface."""

BODY, LOOP, LOAD, FORCE = "body", "loop", "load", "force"
"""Kinds of sources: bodies by their joints, constraints, loads between frames, and given forces and torques."""

GROUND = "ground"

MOVES_ALONG = 1e-9
"""Largest deviation of a node's motion from that of an interface moved as a rigid body, relative to it."""


class Source(NamedTuple):
    """A source of force at an interface.

    Attributes
    ----------
    kind, name : str
    end : int
        Number of its end at the interface; for given forces their number among those of the body, for bodies 0 if it is
        the parent and 1 if it is a child.
    """

    kind: str
    name: str
    end: int


class Neighbours(NamedTuple):
    """Names of the sources of force at an interface.

    Attributes
    ----------
    unknown, known : tuple of str
    """

    unknown: tuple[str, ...]
    known: tuple[str, ...]

    def parts(self, of: str, where: str) -> tuple[str, ...]:
        """Return the names of the sources whose sum is a part of the force; "" is the whole.

        Raises
        ------
        ModelError
            If there is no such part; the message lists the parts.
        """
        everything = self.unknown + self.known
        for group, names in (("", everything), (F_U, self.unknown), (F_K, self.known)):
            if of == group:
                return names
        if of not in everything:
            there = ", ".join(map(repr, (F_U, F_K, *everything)))
            raise ModelError(f"of={of!r}: nothing of this name acts at {where}. Remedy: one of {there}")
        return (of,)


class Sources(NamedTuple):
    """The sources of force at an interface; several ends of one source have one name.

    Attributes
    ----------
    neighbours : Neighbours
    named : dict of str to tuple of Source
    """

    neighbours: Neighbours
    named: dict[str, tuple[Source, ...]]


class InterfacePart(NamedTuple):
    """A part of the force at an interface.

    Attributes
    ----------
    body : int
        Number of the flexible body.
    interface, name : str
        Of the interface, and of the part as `Neighbours` has it.
    sources : tuple of Source
    """

    body: int
    interface: str
    name: str
    sources: tuple[Source, ...]


def interface_at(body: FlexibleBody, frame: InterfaceFrame) -> InterfaceFrame | None:
    """Return the interface that is this frame, or that it moves with as a node of a rigid patch."""
    for n in body.interfaces:
        if n is frame:
            return n
    found = next((n for n in body.interfaces if _moves_along(n, frame)), None)
    if found is None or not len(body.components) or not isinstance(body.basis, np.ndarray):
        return found
    farthest = body.node_frame(int(np.linalg.norm(body.nodes - found.position, axis=1).argmax()))
    return None if _moves_along(found, farthest) else found  # if the whole body moves rigidly, it is no patch


def _moves_along(n: InterfaceFrame, frame: InterfaceFrame) -> bool:
    motion, turns = n.motion[:3], n.motion[3:]
    carried = motion + np.cross(turns, frame.position - n.position, axis=0) if len(turns) else motion
    size = float(np.abs(n.motion).max(initial=0.0))
    return size > 0.0 and bool(np.abs(frame.motion[:3] - carried).max(initial=0.0) <= MOVES_ALONG * size)


_found: WeakKeyDictionary[ModelData, dict[tuple[int, str], Sources]] = WeakKeyDictionary()


def sources_of(model: ModelData) -> dict[tuple[int, str], Sources]:
    """Return the sources at each interface of a scene, by the number of the body and the name of the interface.

    Cached for each scene, since a stepped simulation calls it at each step.
    """
    if model not in _found:
        _found[model] = _sources_of(model)
    return _found[model]


def parts_of(model: ModelData) -> tuple[InterfacePart, ...]:
    """Return all parts of the forces at interfaces of a scene, interface by interface."""
    found = sources_of(model).items()
    return tuple(InterfacePart(*place, name, own) for place, of in found for name, own in of.named.items())


def _sources_of(model: ModelData) -> dict[tuple[int, str], Sources]:
    unknown: dict[tuple[int, str], list[Source]] = {}
    known: dict[tuple[int, str], list[Source]] = {}
    for number, body in enumerate(model.bodies):
        for n in body.interfaces:
            unknown[number, n.name], known[number, n.name] = [], []
            if n.is_held:
                carrier = model.bodies[body.parent].name if body.parent >= 0 else GROUND
                unknown[number, n.name].append(Source(BODY, carrier, 0))
    for body in model.bodies:
        if body.parent_interface is not None:
            place = _place(model, body.parent, body.parent_interface)
            if place is not None:
                unknown[place].append(Source(BODY, body.name, 1))
    for source, marker, is_known in _between(model):
        place = None if marker.interface is None else _place(model, marker.body, marker.interface)
        if place is not None and not isinstance(marker, CoordinateMarker):
            (known if is_known else unknown)[place].append(source)
    labels = {id(load): label for label, load in named_loads(model).items()} if known else {}
    for number, body in enumerate(model.bodies):
        for i, (load, frame) in enumerate(body.loads):
            place = None if frame is None else _place(model, number, frame)
            if place is not None:
                known[place].append(Source(FORCE, labels[id(load)], i))
    return {place: _named(unknown[place], known[place]) for place in unknown}


def _between(model: ModelData) -> Iterator[tuple[Source, Marker, bool]]:
    for constraint in model.constraints:
        for end, marker in enumerate(constraint.ends):
            yield Source(LOOP, constraint.name, end), marker, False
    for number, load in enumerate(model.loads):
        for end, marker in enumerate(load.ends):
            yield Source(LOAD, load.name, end), marker, number not in model.rigid_contacts


def _place(model: ModelData, number: int, frame: InterfaceFrame) -> tuple[int, str] | None:
    terms = model.bodies[number].flexible
    found = None if terms is None else interface_at(terms.body, frame)
    return None if found is None else (number, found.name)


def _named(unknown: list[Source], known: list[Source]) -> Sources:
    """Return sources by name; the kind is prefixed if several sources or a group have the name."""
    sides: dict[str, set[tuple[str, str]]] = {F_U: {("", "")}, F_K: {("", "")}}
    for source in (*unknown, *known):
        sides.setdefault(source.name, set()).add(_owner(source))
    named: dict[str, tuple[Source, ...]] = {}
    groups: list[tuple[str, ...]] = []
    for sources in (unknown, known):
        labels = []
        for source in sources:
            label = source.name if len(sides[source.name]) == 1 else f"{_owner(source)[0]} {source.name}"
            named[label] = (*named.get(label, ()), source)
            labels.append(label)
        groups.append(tuple(dict.fromkeys(labels)))
    return Sources(Neighbours(*groups), named)


def _owner(source: Source) -> tuple[str, str]:
    """Return kind and name; the ground as a parent has a kind of its own."""
    is_ground = source.kind == BODY and source.end == 0 and source.name == GROUND
    return "carrier" if is_ground else source.kind, source.name
