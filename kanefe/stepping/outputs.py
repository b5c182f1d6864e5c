"""Outputs of a scene that is stepped: the quantities that controllers can read, and forces."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError, did_you_mean
from kanefe.frames import Vector
from kanefe.instants.instant import Instant
from kanefe.integrate.readings import reader
from kanefe.loads.controller import Reading
from kanefe.results.quantities import resolved_parts
from kanefe.results.reader import Reader
from kanefe.results.tables import Parts, channel_of
from kanefe.scene.readings import READS, readings_of
from kanefe.scene.targets import Named, asked_for
from kanefe.stepping.steppable import Steppable

FORCES = ("coupling_force", "joint_reaction", "driving_force", "loop_force", "gear_force", "load", "contact_points")
"""Further outputs of an instant; each reads more than the motion of one frame."""


class Output(NamedTuple):
    """An output of a scene, a number.

    Attributes
    ----------
    name, unit : str
    reading : Reading or None
        A quantity that controllers can read; None for a force.
    channel : (str, str, str, int) or None
        For a force: quantity, body or load, interface, and component.
    """

    name: str
    unit: str
    reading: Reading | None
    channel: tuple[str, str, str, int] | None = None

    @property
    def follows_inputs(self) -> bool:
        """Whether inputs act on it at once: on accelerations and forces, but not on the state."""
        return self.reading is None or "acceleration" in self.reading.what


def outputs_of(scene: Steppable, model: Model, named: Named | None) -> tuple[Output, ...]:
    """Return the requested outputs; None: free coordinates and speeds of joints, and positions of floating bodies.

    Raises
    ------
    ModelError
        If there is no such output (the message lists what there is), or two have the same name.
    """
    found: list[Output] = []
    for name, text in _asked(model, named):
        what = text.strip().partition(" ")[0]
        if what in READS:
            for reading in readings_of(scene._entries, {name: text}, "the simulation"):
                title, _, unit = reading.label.partition(" [")
                found.append(Output(title, unit.removesuffix("]"), reading))
        elif what in FORCES:
            found += _forces(model, name, text)
        else:
            did = did_you_mean(what, (*READS, *FORCES))
            raise ModelError(
                f"output {text!r}: there is no {what!r}. {did}Remedy: one of {', '.join((*READS, *FORCES))}"
            )
    names = [output.name for output in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ModelError(f"the output {twice[0]!r} is given twice. Remedy: give it once, or a mapping with own names")
    return tuple(found)


def _asked(model: Model, named: Named | None) -> list[tuple[str, str]]:
    if named is None:
        joints = [body for body in model.bodies if body.joint.rotation_at is None and None in body.joint.motions]
        floating = [body for body in model.bodies if body.joint.rotation_at is not None]
        texts = [f"{what} {body.name}" for what in ("joint_coordinates", "joint_speeds") for body in joints]
        texts += [f"{what} {body.name}" for body in floating for what in ("position", "rotation")]
        return [("", text) for text in texts]
    found = asked_for(named)
    if not all(isinstance(text, str) for _, text in found):
        raise ModelError(f"outputs must be texts such as 'position tip', or a mapping of names to them, not {named!r}")
    return found


def _forces(model: Model, name: str, text: str) -> list[Output]:
    """Return the components of a force."""
    start = np.concatenate((model.initial_coordinates, model.initial_speeds, model.initial_states))
    run = Instant(model, model.slack_time, start).history
    found = channel_of(run, name, text, "output", partial(_parts, model, run))
    return [
        Output(column, unit, None, (*found.place, i))
        for column, unit, i in zip(found.columns, found.units, found.numbers, strict=True)
    ]


def _parts(model: Model, run: Reader, what: str, of: str) -> Parts:
    """Return label, unit and column names of a force; those of drives are the names of their speeds."""
    if what != "driving_force":
        return run.parts(what, of)
    joint = model.bodies[model.index(of)].joint
    driven = [title for title, motion in zip(joint.speed_names, joint.motions, strict=True) if motion is not None]
    return resolved_parts(what, driven)


def readers(model: Model, outputs: tuple[Output, ...]) -> Callable[[float, Vector], list[float]]:
    """Return the function that reads all outputs from time and state y, with or without the energy quadratures."""
    reads = [
        partial(_force, *output.channel) if output.reading is None and output.channel else _reading(model, output)
        for output in outputs
    ]
    size = model.coordinate_count + model.free_count + model.state_count

    def read(t: float, y: Vector) -> list[float]:
        state = cache(lambda: model.route.state(t, y))
        instant = cache(lambda: Instant(model, t, y[:size]))
        return [one(t, y, state, instant) for one in reads]

    return read


def _reading(model: Model, output: Output) -> Callable[..., float]:
    if output.reading is None:
        raise TypeError("an output is a reading or a force")
    read = reader(model, output.reading)
    return lambda t, y, state, instant: read(t, y, state)


def _force(
    what: str, of: str, interface: str, i: int, t: float, y: Vector, state: object, instant: Callable[[], Instant]
) -> float:
    return float(np.atleast_1d(instant().read(what, of, interface or None))[i])
