"""Outputs of a scene that is stepped: the quantities that controllers can read, and forces."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.instants.instant import Instant
from kanefe.integrate.sampling import reader
from kanefe.loads.controller import Reading
from kanefe.results.contact_points import COLUMNS as POINT_COLUMNS
from kanefe.results.contact_points import point_columns
from kanefe.results.quantities import QUANTITIES, resolved_parts
from kanefe.scene.controllers import READS
from kanefe.scene.targets import Named, asked_for
from kanefe.stepping.steppable import Steppable

FORCES = ("coupling_force", "joint_reaction", "driving_force", "loop_force", "load", "contact_points")
"""Further outputs of an instant; each reads more than the motion of one frame."""

WRENCH = ("force x", "force y", "force z", "moment x", "moment y", "moment z")


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


def outputs_of(scene: Steppable, model: Model, named: Named | None) -> tuple[Output, ...]:
    """Return the requested outputs; None: free coordinates and speeds of joints, and positions of floating bodies.

    Raises
    ------
    ModelError
        If there is no such output (the message lists what there is), or two have the same name.
    """
    found: list[Output] = []
    for name, text in _asked(model, named):
        what, _, rest = text.strip().partition(" ")
        if what in READS:
            for reading in scene._readings("the simulation", name, text):
                title, _, unit = reading.label.partition(" [")
                found.append(Output(title, unit.removesuffix("]"), reading))
        elif what in FORCES:
            found += _forces(model, name or text.strip(), what, rest.strip())
        else:
            near = difflib.get_close_matches(what, (*READS, *FORCES), 1)
            did = f"Did you mean {near[0]!r}? " if near else ""
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


def _forces(model: Model, name: str, what: str, rest: str) -> list[Output]:
    """Return the components of a force."""
    instant = Instant(model, model.slack_time, np.concatenate(_start(model)))
    head, _, last = rest.rpartition(" ")
    failure: ModelError | None = None
    for place, axis in ((rest, ""), (head.strip(), last)):
        of, _, interface = place.partition("/")
        try:
            values = np.atleast_1d(instant.read(what, of, interface or None))
        except ModelError as error:
            failure = failure or error
            continue
        columns = _columns(model, what, of, len(values))
        chosen = [i for i, (label, _) in enumerate(columns) if axis in ("", label, label.replace(" ", "_"), str(i))]
        if not chosen:
            listed = ", ".join(label.replace(" ", "_") for label, _ in columns)
            raise ModelError(f"output '{what} {rest}': there is no component {axis!r}. There are: {listed}")
        one = len(values) == 1 or bool(axis)
        return [
            Output(
                name if one else f"{name} {columns[i][0].replace(' ', '_')}",
                columns[i][1],
                None,
                (what, of, interface, i),
            )
            for i in chosen
        ]
    raise ModelError(f"output '{what} {rest}': {failure}")


def _start(model: Model) -> tuple[Vector, Vector, Vector]:
    return model.initial_coordinates, model.initial_speeds, model.initial_states


def _columns(model: Model, what: str, of: str, count: int) -> list[tuple[str, str]]:
    """Return name and unit of each component of a force."""
    if what == "contact_points":
        named = point_columns(count // sum(len(names) for _, names in POINT_COLUMNS))
    elif what == "load":
        named = next(load.columns for load in model.loads if load.name == of)
    elif what == "driving_force":
        joint = model.bodies[model.index(of)].joint
        named = tuple(
            title for title, motion in zip(joint.speed_names, joint.motions, strict=True) if motion is not None
        )
    else:
        named = ()
    parts = resolved_parts(what, tuple(named)) if named else QUANTITIES[what].parts
    titles = [
        (f"{label} {c}" if what not in ("load", "driving_force", "contact_points") else c, u)
        for label, u, cs in parts
        for c in cs or (label,)
    ]
    return titles if len(titles) == count else [(str(i), parts[0][1]) for i in range(count)]


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
