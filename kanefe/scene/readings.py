"""What controllers and compiled functions read, from texts of the user."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kanefe.errors import ModelError
from kanefe.loads.functions import CompiledCallback
from kanefe.loads.offered_function import CompiledByNumba
from kanefe.scene.targets import Named, asked_for, axes_of, joint_entry, target_of

if TYPE_CHECKING:
    from kanefe.loads.controller import Reading
    from kanefe.scene.scene import BodyEntry

READS = {
    "position": "m",
    "rotation": "rad",
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "acceleration": "m/s2",
    "angular_acceleration": "rad/s2",
    "joint_coordinates": "",
    "joint_speeds": "",
    "modal_coordinates": "modal",
    "modal_speeds": "modal/s",
    "deflection": "m",
}
OF_LOADS = "joint_coordinates", "joint_speeds", "modal_coordinates", "modal_speeds", "deflection"
"""Quantities that compiled functions of loads can read: sums of entries of the state."""


def readings_of(
    entries: Sequence[BodyEntry], named: Named, label: str, kinds: Sequence[str] = tuple(READS)
) -> tuple[Reading, ...]:
    """Return what is read, of the bodies of a scene so far; a ModelError with the label says what is wrong."""
    known = {kind: READS[kind] for kind in kinds}
    texts = texts_of(named, "reads", label)
    return tuple(found for pair in texts for found in _readings(entries, f"{label} reads", *pair, known))


def texts_of(named: Named, what: str, label: str) -> Sequence[tuple[str, str]]:
    """Return pairs of a name and a text; a ModelError with the label if there are none."""
    try:
        found = asked_for(named)
    except TypeError:
        found = []
    if not found or not all(isinstance(text, str) for _, text in found):
        raise ModelError(f"{what} of {label} must be one or more texts such as 'motor hub', not {named!r}")
    return found


def with_reads(entries: Sequence[BodyEntry], load: Any, label: str) -> Any:
    """Return what a load is given, a function of `kanefe.compiled` with what it reads of the bodies so far."""
    if not isinstance(load, CompiledByNumba):
        return load
    if load.is_controller:
        raise ModelError(
            f"{label} takes f(t) or f(t, reads), not f(t, reads, memory), which is a sampled controller. Remedy: "
            "add_controller(..., every=...)"
        )
    return CompiledCallback(load.function, True, label, readings_of(entries, load.reads, label, OF_LOADS))


def _readings(entries: Sequence[BodyEntry], role: str, name: str, text: str, kinds: Mapping[str, str]) -> list[Reading]:
    """Return the readings of one text."""
    from kanefe.loads.controller import Reading

    target = target_of(entries, name, text, kinds, role)
    entry = entries[target.body]

    def reading(title: str, unit: str, component: int, is_own: bool = False) -> Reading:
        interface = target.interface.name if target.interface is not None else ""
        return Reading(f"{title} [{unit}]", target.what, entry.name, interface, component, is_own)

    if target.what in ("joint_coordinates", "joint_speeds"):
        rate = "/s" if target.what == "joint_speeds" else ""
        return [reading(title, f"{unit}{rate}", i) for title, i, unit in joint_entry(entries, target, role, None)]
    if target.what in ("modal_coordinates", "modal_speeds"):
        count = entry.flexible.free_count if entry.flexible is not None else 0
        chosen = [i for i in range(count) if target.axis in ("", str(i))]
        if not chosen:
            raise ModelError(f"{role} {target.name!r}: {entry.name!r} has {count} modes, not {target.axis!r}")
        return [reading(target.name if target.axis else f"{target.name} {i}", READS[target.what], i) for i in chosen]
    if target.what == "deflection" and target.interface is None:
        listed = ", ".join(frame.name for frame in entry.interfaces) or "none"
        raise ModelError(f"{role} {target.name!r}: a deflection is that of an interface. There are: {listed}")
    unit = READS[target.what]
    return [reading(title, unit, i, is_own) for title, i, is_own in axes_of(target, role)]
