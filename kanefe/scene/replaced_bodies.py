"""A scene with other flexible bodies in the places of its own: joints, loads, contacts and constraints by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.arguments import told
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.marker import Marker
from kanefe.bodies.transfer import same_places, transferred
from kanefe.errors import ModelError
from kanefe.loads.functions import multiplied
from kanefe.scene.scene import BodyEntry, Frame, Scene

if TYPE_CHECKING:
    from kanefe.bodies.segmented import SegmentedBody
    from kanefe.loads.field_load import FieldLoad
    from kanefe.loads.point_load import PointLoad

NODE = "node "
"""First letters of the names of frames of nodes; their numbers follow."""


def replace_bodies(scene: Any, bodies: Mapping[str, FlexibleBody | SegmentedBody]) -> None:
    """Put other flexible bodies in the places of those of an open scene; see `System.with_bodies`."""
    new = _by_entry(scene, bodies)
    pairs = {i: (entry.flexible, new[entry.name]) for i, entry in enumerate(scene._entries) if entry.name in new}
    swap = _Swap(pairs, scene._entries)
    for number, (_, body) in pairs.items():
        _check_holds(scene._entries[number], body)
    scene._entries = [swap.entry(number, entry) for number, entry in enumerate(scene._entries)]
    scene._constraints = [swap.moved(constraint) for constraint in scene._constraints]
    scene._surfaces = {name: swap.moved(surface) for name, surface in scene._surfaces.items()}
    scene._loads = [_of_ends(load, swap.moved(tuple(load.ends))) for load in scene._loads]
    _check_reads(scene, [entry.name for number, entry in enumerate(scene._entries) if number in pairs])


def _of_ends(load: Any, ends: tuple[Any, ...]) -> Any:
    return load if all(one is other for one, other in zip(ends, load.ends, strict=True)) else load.with_ends(ends)


def _by_entry(scene: Any, bodies: Any) -> dict[str, FlexibleBody]:
    """Return the new flexible body of each entry of the scene, segments one by one."""
    from kanefe.bodies.segmented import SegmentedBody

    if not isinstance(bodies, Mapping) or not bodies:
        raise ModelError(f"bodies={told(bodies)}. Remedy: flexible bodies by the names of those in the scene")
    known = [entry.name for entry in scene._entries if entry.flexible is not None]
    found: dict[str, FlexibleBody] = {}
    for name, body in bodies.items():
        before = scene._segmented.get(name)
        if before is not None and isinstance(body, SegmentedBody):
            if (len(body.segments), body.base) != (len(before.segments), before.base):
                raise ModelError(
                    f"the segmented body {name!r} has {len(before.segments)} segments in the scene, and the other one "
                    f"{len(body.segments)}, or another base. Remedy: as many; for others build the scene again"
                )
            scene._segmented[name] = body
            found |= {f"{name} {i}": segment.body for i, segment in enumerate(body.segments, 1)}
        elif before is not None or not isinstance(body, FlexibleBody):
            raise ModelError(
                f"{name!r} cannot become {told(body)}. Remedy: a {'SegmentedBody' if before else 'FlexibleBody'}, as "
                "body.rebuilt(...) returns it"
            )
        elif name not in known:
            raise ModelError(
                f"the scene has no flexible body called {name!r}. It has: {', '.join([*scene._segmented, *known])}"
            )
        else:
            found[name] = body
    return found


def _check_holds(entry: BodyEntry, body: FlexibleBody) -> None:
    """Refuse a body that its joint or the axes of its interfaces do not suit."""
    if body.is_floating and not entry.joint.holds_floating:
        raise ModelError(
            f"the other body for {entry.name!r} has no interface fixed in G, so its {entry.joint.kind} joint has "
            "nothing to hold. Remedy: the same interfaces, as body.rebuilt(...) keeps them"
        )


def _check_reads(scene: Any, names: Sequence[str]) -> None:
    """Refuse controllers that read coordinates of modes, which are others now."""
    for controller in scene._controllers:
        for reading in controller.reads:
            if reading.what in ("modal_coordinates", "modal_speeds") and reading.body in names:
                raise ModelError(
                    f"{controller.label} reads {reading.label!r}, a coordinate of a mode, and the modes of the other "
                    f"body for {reading.body!r} are not the same. Remedy: it reads a deflection or a position"
                )


class _Swap:
    """Old and new bodies by the numbers of their entries, and what refers to them, rewritten."""

    def __init__(self, pairs: Mapping[int, tuple[FlexibleBody, FlexibleBody]], entries: Sequence[BodyEntry]) -> None:
        self.pairs, self.names = pairs, [entry.name for entry in entries]

    def frame(self, number: int, frame: InterfaceFrame | None) -> InterfaceFrame | None:
        """Return the frame of the new body with this name; of a node, that at the same place."""
        if frame is None or number not in self.pairs:
            return frame
        old, new = self.pairs[number]
        if all(frame is not one for one in old.interfaces) and frame.name.startswith(NODE):
            node = int(frame.name.removeprefix(NODE))
            place = same_places(old, new, np.array([node]))[0]
            if place < 0:
                raise ModelError(
                    f"something is at {frame.name} of {self.names[number]!r}, and the other body has no node at its "
                    f"place, {np.round(old.nodes[node], 9).tolist()} m. Remedy: an interface there"
                )
            return new.node_frame(int(place))
        try:
            return new.interface(frame.name)
        except ModelError as error:
            raise ModelError(f"the other body for {self.names[number]!r}: {error}") from error

    def moved(self, value: Any) -> Any:
        """Return what has markers and frames with those of the new bodies; itself if it has none of the old ones."""
        if isinstance(value, Marker):
            frame = self.frame(value.body, value.interface)
            return value if frame is value.interface else replace(value, interface=frame)
        if isinstance(value, Frame):
            frame = self.frame(value.number, value.interface_frame)
            return value if frame is value.interface_frame else replace(value, interface_frame=frame)
        if isinstance(value, tuple):
            parts = [self.moved(part) for part in value]
            if all(one is other for one, other in zip(parts, value, strict=True)):
                return value
            return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
        if not is_dataclass(value) or isinstance(value, (type, Scene)):
            return value
        changed = {f.name: self.moved(getattr(value, f.name)) for f in fields(value) if f.init}
        changed = {name: new for name, new in changed.items() if new is not getattr(value, name)}
        return replace(value, **changed) if changed else value

    def entry(self, number: int, entry: BodyEntry) -> BodyEntry:
        """Return the entry of a body with its new parent, loads and body."""
        entry = replace(entry, parent_interface=self.frame(entry.parent, entry.parent_interface))
        if number not in self.pairs:
            return entry
        old, new = self.pairs[number]
        eta, deta = (transferred(old, new, modal, entry.name) for modal in (entry.eta, entry.deta))
        field_loads = [other for load in entry.field_loads for other in _on(new, load, entry.field_loads)]
        point_loads = self._point_loads(number, entry)
        return replace(entry, flexible=new, eta=eta, deta=deta, loads=point_loads, field_loads=field_loads)

    def _point_loads(self, number: int, entry: BodyEntry) -> list[tuple[PointLoad, InterfaceFrame | None]]:
        """Return the loads at the frames of the new body; those per length of an exact beam at its Gauss points."""
        old, new = self.pairs[number]
        spread: dict[str, tuple[PointLoad, float]] = {}
        kept: list[tuple[PointLoad, InterfaceFrame | None]] = []
        for load, frame in entry.loads:
            start, _, last = load.label.rpartition(f", {NODE}")
            if old.bends_far and start.startswith("the line load on") and new.bends_far:
                spread.setdefault(start, (load, _gauss_lengths(old)[int(last)]))
            else:
                kept.append((load, self.frame(number, frame)))
        for label, (load, length) in spread.items():
            for node, own in _gauss_lengths(new).items():
                function = multiplied(load.function, own / length * np.eye(3))
                part = replace(load, label=f"{label}, {NODE}{node}", function=function)
                kept.append((part, new.node_frame(node)))
        return kept


def _on(body: FlexibleBody, load: FieldLoad, every: Sequence[FieldLoad]) -> list[FieldLoad]:
    """Return a distributed load on another body; those of one call that varies by place come with the first."""
    if load.again is None:
        return [replace(load, pattern=body.load_pattern(load.pattern.name))]
    first = next(one for one in every if one.again is load.again)
    return load.again(body) if first is load else []


def _gauss_lengths(beam: FlexibleBody) -> dict[int, float]:
    """Return the length of beam (m) that each Gauss point of an exact one stands for, by its node."""
    line: Any = beam.line
    lengths = np.outer(line.lengths, line.weights)
    return dict(zip(line.gauss_nodes.ravel().tolist(), lengths.ravel().tolist(), strict=True))
