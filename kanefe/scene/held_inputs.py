"""Inputs of stepped scenes, held from step to step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import ModelError, did_you_mean
from kanefe.joints.held_motion import Course, driven_by, held_motion
from kanefe.scene.controllers import DRIVES, ControllerMethods
from kanefe.scene.scene import BodyEntry
from kanefe.scene.targets import AXES, Named, asked_for, joint_entry, target_of

KINDS = DRIVES | {"drive": "", "load": ""}


class HeldInput(NamedTuple):
    """An input that is held.

    Attributes
    ----------
    name, unit : str
    start : float
        Its initial value.
    course : Course or None
        Motion of a driven coordinate, whose acceleration the input is; None for a load.
    """

    name: str
    unit: str
    start: float
    course: Course | None = None


class HeldInputMethods(ControllerMethods):
    """The part of `System` that takes inputs."""

    def _hold_inputs(self, named: Named | None, t: float, every: float) -> list[HeldInput]:
        """Add inputs to the scene, those of loads first; return them.

        Parameters
        ----------
        named : str, sequence or mapping of str
            As for `kanefe.System.start`.
        t, every : float
            Start of the run, and approximate length of a step, s.

        Raises
        ------
        ModelError
            If there is no such input; the message lists possible ones.
        """
        from kanefe.loads.controller import INPUTS, HeldInputs

        loads: list[HeldInput] = []
        drives: list[HeldInput] = []
        taken: set[tuple[int, int] | str] = set()  # coordinates and loads whose values are replaced by an input
        for name, text in _asked(named):
            what, _, rest = text.strip().partition(" ")
            if what not in KINDS:
                did = did_you_mean(what, KINDS)
                raise ModelError(f"input {text!r}: there is no {what!r}. {did}Remedy: one of {', '.join(KINDS)}")
            if what == "drive":
                drives += self._held_drives(name, text, t, taken)
            elif what == "load":
                loads += self._held_load(name, rest.strip(), len(loads), t, taken)
            else:
                for label, target, made in self._drives("the simulation", name, text):
                    title, _, unit = label.partition(" [")
                    self._hold(INPUTS, len(loads), f"{title} of the simulation", target, made)
                    loads.append(HeldInput(title, unit.removesuffix("]"), 0.0))
        found = [*loads, *drives]
        names = [held.name for held in found]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ModelError(f"the input {twice[0]!r} is there twice. Remedy: once, or names of your own in a mapping")
        if loads:
            titles = tuple(f"{held.name} [{held.unit}]" for held in loads)
            self._controllers.append(HeldInputs(INPUTS, _not_called, every, 0.0, (), titles))
        return found

    def _held_drives(self, name: str, text: str, t: float, taken: set[tuple[int, int] | str]) -> list[HeldInput]:
        target = target_of(self._entries, name, text, KINDS, "input")
        entry = self._entries[target.body]
        motions, found = list(entry.joint.motions), []
        for title, i, unit in joint_entry(self._entries, target, "input", driven=True):
            motion = motions[i]
            if motion is None:
                raise TypeError("a driven coordinate has a motion")
            _take((target.body, i), text, taken)
            motions[i], course = held_motion(motion, t)
            found.append(HeldInput(title, f"{unit}/s2", course.acceleration(t), course))
        try:
            entry.joint = driven_by(entry.joint, motions)
        except TypeError as error:
            raise ModelError(
                f"input {text!r}: the motion of a {entry.joint.kind} joint cannot be given step by step. Remedy: a "
                "revolute or prismatic joint"
            ) from error
        return found

    def _held_load(
        self, name: str, label: str, number: int, t: float, taken: set[tuple[int, int] | str]
    ) -> list[HeldInput]:
        """Return inputs that replace the value of a load of the scene."""
        from kanefe.loads.controller import INPUTS, Held

        _take(label, f"load {label}", taken)
        places = dict(_named(self._entries))
        if label not in places:
            listed = ", ".join(map(repr, places)) or "none"
            did = did_you_mean(label, places)
            raise ModelError(f"input {f'load {label}'!r}: the scene has no such load. {did}It has: {listed}")
        entry, kind, at = places[label]
        given = getattr(entry, kind)
        load = _of_pair(given[at])
        title = name or f"load {label}"
        start = np.zeros(load.shape) if load.takes_state else load.value(t, None)
        unit = load.unit(entry.joint.units)
        if load.shape == ():
            made = [replace(load, function=Held(INPUTS, number), takes_state=True)]
            found = [HeldInput(title, unit, float(start))]
        else:
            made = [
                replace(
                    load,
                    label=f"{load.label} along {axis}",
                    function=Held(INPUTS, number + i, tuple(np.eye(3)[i].tolist())),
                    takes_state=True,
                )
                for axis, i in AXES.items()
            ]
            found = [HeldInput(f"{title} {axis}", unit, float(start[i])) for axis, i in AXES.items()]
        given[at : at + 1] = [(one, given[at][1]) for one in made] if kind == "loads" else made
        return found


def _asked(named: Named | None) -> list[tuple[str, str]]:
    found = [] if named is None else asked_for(named)
    if not all(isinstance(text, str) for _, text in found):
        raise ModelError(f"inputs must be texts such as 'motor hub', or a mapping of names to them, not {named!r}")
    return found


def _take(what: tuple[int, int] | str, text: str, taken: set[tuple[int, int] | str]) -> None:
    """Record what an input replaces; raise a ModelError if another one replaces it already."""
    if what in taken:
        raise ModelError(f"the input {text!r} is there twice. Remedy: once, by one name")
    taken.add(what)


def _not_called(t: float, reads: np.ndarray, memory: dict[str, Any]) -> None:
    raise TypeError("inputs have no function")


def _of_pair(item: Any) -> Any:
    return item[0] if isinstance(item, tuple) else item


def _named(entries: Iterable[BodyEntry]) -> list[tuple[str, tuple[BodyEntry, str, int]]]:
    """Return entry, list and index of the loads of the scene that have values, by their names as in `named_loads`."""
    seen: dict[str, int] = {}
    found = []
    for entry in entries:
        for kind in ("loads", "joint_loads", "field_loads"):
            for at, item in enumerate(getattr(entry, kind)):
                label = _of_pair(item).label
                seen[label] = seen.get(label, 0) + 1
                found.append((label if seen[label] == 1 else f"{label} #{seen[label]}", (entry, kind, at)))
    return found
