"""Outputs of a linearised scene: motions of frames, joint and modal coordinates, deflections."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.equations.model import Model
from kanefe.errors import ModelError
from kanefe.frames import Matrix, Vector
from kanefe.linear.small_motions import Directions, Moved, SmallMotions
from kanefe.linear.tangents import difference
from kanefe.scene.targets import AXES, Named, Target, asked_for, axis_vector, joint_entry, target_of
from kanefe.states.kinematics import FrameMotion
from kanefe.states.state import State

KINDS = {
    "position": "m",
    "rotation": "rad",
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "acceleration": "m/s2",
    "angular_acceleration": "rad/s2",
    "joint_coordinates": "",
    "joint_speeds": "",
    "modal_coordinates": "",
    "modal_speeds": "",
    "deflection": "",
}

Measure = Callable[["Sweep"], float]

Tangent = Callable[["SmallMotions", "Directions"], Vector]
"""The derivatives of an output along directions, one number per direction."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """A state near the one of the analysis, and the rates of its free and driven speeds."""

    state: State
    rates: Vector

    def frame(self, target: Target) -> FrameMotion:
        """Return the motion of the frame of a target."""
        return self.state.motion(target.body, target.interface)


def swept(moved: Moved, t: float) -> Sweep:
    """Return a state with the rates of its speeds."""
    state = State(moved.model, t, moved.q, moved.u)
    return Sweep(state, np.concatenate((moved.du, state.driven_rates)))


@dataclass(frozen=True, eq=False)
class Output:
    """One output: its name, its unit, the function that evaluates it, and its derivatives where they are known."""

    name: str
    unit: str
    measure: Measure
    tangent: Tangent | None = None

    @property
    def label(self) -> str:
        """Name with the unit in brackets."""
        return f"{self.name} [{self.unit}]"


def outputs_of(small: SmallMotions, named: Named | None) -> list[Output]:
    """Return the requested outputs; None: free coordinates and speeds of joints, and positions of floating bodies.

    Raises
    ------
    ModelError
        If there is no such output; the message lists what there is.
    """
    model = small.model
    found: list[Output] = []
    if named is None:
        named = [
            f"{what} {body.name}"
            for what in ("joint_coordinates", "joint_speeds")
            for body in model.bodies
            if any(motion is None for motion in body.joint.motions) and body.joint.rotation_at is None
        ]
        named += [
            f"{what} {body.name}"
            for body in model.bodies
            if body.joint.rotation_at is not None
            for what in ("position", "rotation")
        ]
    here = swept(Moved(model, small.q, small.u, small.du), small.t)
    for name, text in asked_for(named):
        target = target_of(model.bodies, name, text, KINDS, "output")
        found += _outputs(model, here, target)
    return found


def _outputs(model: Model, here: Sweep, target: Target) -> list[Output]:
    if target.what in ("joint_coordinates", "joint_speeds"):
        return _joint_outputs(model, target)
    if target.what in ("modal_coordinates", "modal_speeds"):
        return _modal_outputs(model, target)
    if target.what == "deflection":
        return _deflections(model, target)
    frame = here.frame(target)
    A = frame.A_NF if target.interface is None else frame.A_NF @ target.interface.axes
    return [
        Output(
            name, KINDS[target.what], _measure_of(target, direction, frame.A_NF), _tangent_of(target, frame, direction)
        )
        for name, direction in axis_vector(target, A, "output")
    ]


def _tangent_of(target: Target, frame: FrameMotion, direction: Vector) -> Tangent | None:
    """Return the derivatives of a component of the position or the rotation of a frame: its partial velocities."""
    partial = {"position": frame.V, "rotation": frame.W}.get(target.what)
    if partial is None:
        return None
    row = direction @ frame.A_NF @ partial
    return lambda small, along: np.asarray(row[small.columns] @ along.z)


def _measure_of(target: Target, direction: Vector, A_0: Matrix) -> Measure:
    """Return the function for a component of the motion of a frame along a direction in N."""

    def turn(sweep: Sweep) -> Vector:
        R = sweep.frame(target).A_NF @ A_0.T
        return 0.5 * np.array((R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]))

    def acceleration(sweep: Sweep) -> Vector:
        F = sweep.frame(target)
        return F.A_NF @ (F.V @ sweep.rates + F.Z)

    def angular_acceleration(sweep: Sweep) -> Vector:
        F = sweep.frame(target)
        return F.A_NF @ (F.W @ sweep.rates + F.Y)

    vectors: dict[str, Callable[[Sweep], Vector]] = {
        "position": lambda sweep: sweep.frame(target).p_NoFo_N,
        "rotation": turn,
        "velocity": lambda sweep: sweep.frame(target).A_NF @ sweep.frame(target).v,
        "angular_velocity": lambda sweep: sweep.frame(target).A_NF @ sweep.frame(target).w,
        "acceleration": acceleration,
        "angular_acceleration": angular_acceleration,
    }
    vector = vectors[target.what]
    return lambda sweep: float(direction @ vector(sweep))


def _joint_outputs(model: Model, target: Target) -> list[Output]:
    body = model.bodies[target.body]
    found = []
    for name, i, unit in joint_entry(model.bodies, target, "output"):
        if target.what == "joint_coordinates":
            found.append(_coordinate(name, unit, int(body.coordinates[i])))
        else:
            found.append(_speed(name, f"{unit}/s", int(body.speeds[i])))
    return found


def _coordinate(name: str, unit: str, at: int) -> Output:
    """Return the output of one of the coordinates q."""

    def tangent(small: SmallMotions, along: Directions) -> Vector:
        return np.asarray(small.coordinate_map[at] @ along.z[: small.model.free_count])

    return Output(name, unit, lambda sweep: float(sweep.state.q[at]), tangent)


def _speed(name: str, unit: str, at: int) -> Output:
    """Return the output of one of the free speeds u."""
    return Output(name, unit, lambda sweep: float(sweep.state.u[at]), lambda _, along: along.du[at])


def _modal_outputs(model: Model, target: Target) -> list[Output]:
    terms = model.flexible_terms(model.bodies[target.body].name)
    count = terms.body.free_count
    numbers = [str(i) for i in range(count)]
    if target.axis not in ("", *numbers):
        raise ModelError(f"output {target.name!r}: the body has the modes 0 to {count - 1}, not {target.axis!r}")
    found = []
    for i in range(count):
        if target.axis in ("", str(i)):
            name = target.name if target.axis else f"{target.name} {i}"
            if target.what == "modal_coordinates":
                found.append(_coordinate(name, "modal", terms.eta.start + i))
            else:
                found.append(_speed(name, "modal/s", terms.speeds.start + i))
    return found


def _deflections(model: Model, target: Target) -> list[Output]:
    """Return the displacement of an interface in G, along the axes of G."""
    terms = model.flexible_terms(model.bodies[target.body].name)
    frame = target.interface
    if frame is None:
        listed = ", ".join(f.name for f in terms.body.interfaces) or "none"
        raise ModelError(f"output {target.name!r}: a deflection is that of an interface. There are: {listed}")
    if target.axis not in ("", *AXES):
        raise ModelError(f"output {target.name!r}: {target.axis!r} is not an axis of the mesh frame. Remedy: x, y or z")
    return [
        Output(
            target.name if target.axis else f"{target.name} {axis}",
            "m",
            lambda sweep, i=i: float(frame.moved(sweep.state.q[terms.eta])[0][i]),  # type: ignore[misc]
            lambda small, along, i=i: frame.moved(small.q[terms.eta])[1][i] @ along.z[terms.speeds],  # type: ignore[misc]
        )
        for axis, i in AXES.items()
        if target.axis in ("", axis)
    ]


def output_rows(small: SmallMotions, outputs: Sequence[Output], along: Directions) -> Matrix:
    """Return the derivatives of the outputs along directions, shape (outputs, directions).

    Those of velocities and accelerations by differences: they change with the position in ways that only a sweep of
    the whole scene tells.
    """
    rows = np.zeros((len(outputs), along.z.shape[1]))
    differed = []
    for i, output in enumerate(outputs):
        if output.tangent is None:
            differed.append(i)
        else:
            rows[i] = output.tangent(small, along)
    if not differed:
        return rows
    steps = small.steps(along)

    def measured(h: float, column: int) -> Vector:
        sweep = swept(small.moved(along, column, h), small.t)
        return np.array([outputs[i].measure(sweep) for i in differed])

    for column in range(rows.shape[1]):
        rows[differed, column] = difference(lambda h, column=column: measured(h, column), steps[column])  # type: ignore[misc]
    return rows


def output_values(small: SmallMotions, outputs: Sequence[Output]) -> Vector:
    """Return the outputs in the state itself."""
    here = swept(Moved(small.model, small.q, small.u, small.du), small.t)
    return np.array([output.measure(here) for output in outputs])
