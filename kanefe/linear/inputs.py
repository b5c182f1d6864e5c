"""Inputs of a linearised scene: forces, torques, motors, loads of the scene, gravity, and driven motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Vector
from kanefe.linear.displaced_drives import Drive
from kanefe.linear.unit_forces import carrier, scene_load_columns
from kanefe.scene.targets import AXES, Named, Target, asked_for, axis_vector, joint_entry, target_of
from kanefe.states.state import State
from kanefe.tree.load_names import named_loads

if TYPE_CHECKING:
    from kanefe.tree.load_names import SceneLoad

KINDS = {"force": "N", "torque": "N m", "motor": "", "drive": "", "gravity": "m/s2", "load": ""}


@dataclass(frozen=True, eq=False)
class Input:
    """One input: a generalised force (free,) per unit, or the acceleration of a drive.

    Attributes
    ----------
    name, unit : str
    force : ndarray, shape (free,), or None
    drive : Drive or None
    """

    name: str
    unit: str
    force: Vector | None
    drive: Drive | None = None

    @property
    def label(self) -> str:
        """Name with the unit in brackets."""
        return f"{self.name} [{self.unit}]"


def inputs_of(model: Model, t: float, q: Vector, u: Vector, named: Named | None) -> list[Input]:
    """Return the requested inputs; None: all loads of the scene.

    Raises
    ------
    ModelError
        If there is no such input; the message lists what there is.
    """
    state, loads = State(model, t, q, u), named_loads(model)
    if named is None:
        return [found for label, load in loads.items() for found in _of_load(state, load, label)]
    found: list[Input] = []
    for name, text in asked_for(named):
        what, _, rest = text.strip().partition(" ") if isinstance(text, str) else ("", "", "")
        if what == "gravity":
            found += _gravity(model, t, q, u, name or text, rest.strip())
        elif what == "load":
            if rest not in loads:
                raise ModelError(f"input {text!r}: the scene has no such load. It has: {', '.join(loads) or 'none'}")
            found += _of_load(state, loads[rest], name or rest)
        else:
            found += _at(state, target_of(model.bodies, name, text, KINDS, "input"))
    return found


def _of_load(state: State, load: SceneLoad, name: str) -> list[Input]:
    """Return the components of a load of the scene."""
    columns = scene_load_columns(state, load)
    units = load.unit(state.model.bodies[carrier(state.model, load)[0]].joint.units)
    names = [name] if columns.shape[1] == 1 else [f"{name} {axis}" for axis in AXES]
    return [Input(label, units, column) for label, column in zip(names, columns.T, strict=True)]


def _at(state: State, target: Target) -> list[Input]:
    """Return forces or torques on a body or an interface, or forces or motions along coordinates of a joint."""
    bodies, n = state.model.bodies, state.model.free_count
    if target.what == "drive":
        return [
            Input(name, f"{unit}/s2", None, Drive(target.body, i))
            for name, i, unit in joint_entry(bodies, target, "input", driven=True)
        ]
    if target.what == "motor":
        return [
            Input(name, "N m" if unit == "rad" else "N", np.eye(n)[bodies[target.body].speeds[i]])
            for name, i, unit in joint_entry(bodies, target, "input")
        ]
    frame = state.motion(target.body, target.interface)
    axes = frame.A_NF if target.interface is None else frame.A_NF @ target.interface.axes
    wide = frame.V if target.what == "force" else frame.W
    return [
        Input(name, KINDS[target.what], ((frame.A_NF.T @ direction) @ wide)[:n])
        for name, direction in axis_vector(target, axes, "input")
    ]


def _gravity(model: Model, t: float, q: Vector, u: Vector, name: str, axis: str) -> list[Input]:
    """Return uniform gravity along axes of N, which is equivalent to the opposite acceleration of the ground."""
    if axis not in ("", *AXES):
        raise ModelError(f"input {name!r}: {axis!r} is not an axis. Remedy: gravity x, gravity y or gravity z")
    n = model.free_count
    _, still = model.literal.system(State(replace(model, gravity=np.zeros(3)), t, q, u))
    found = []
    for letter, i in AXES.items():
        if axis in ("", letter):
            _, pulled = model.literal.system(State(replace(model, gravity=np.eye(3)[i].copy()), t, q, u))
            found.append(Input(name if axis else f"{name} {letter}", KINDS["gravity"], (pulled - still)[:n]))
    return found
