"""Generalised forces of unit loads at a state, and how the scene answers to them.

The accelerations are linear in the forces, so that these columns are exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import all_speeds, constrained_solver, mass_matrix
from kanefe.kane.constraints import constraint_rates
from kanefe.kane.interactions import interaction_wrenches
from kanefe.kane.kinematics import (
    FrameMotion,
    elastic_partial_rates,
    elastic_state,
    interface_motion,
    sweep_outward,
)
from kanefe.loads import Bushing, FieldLoad, JointLoad, PointLoad, SpringDamper
from kanefe.loads.functions import Constant

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.equations.model import Model
    from kanefe.tree.model_data import BodyTerms

SPACE = 3


def answers(model: Model, t: float, q: Vector, u: Vector, F: Matrix) -> Matrix:
    """Return the accelerations of the free speeds (free, k) that forces on them (free, k) add; loops hold."""
    n, full = model.free_count, all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full)
    rows = constraint_rates(model, motions, q, full).over(slice(n))
    solver = constrained_solver(model, mass_matrix(model, motions, q, full)[:n, :n], rows)
    none = np.zeros(len(rows.J))
    return np.column_stack([np.zeros((n, 0)), *(solver.solve(column, none)[0] for column in F.T)])


def load_values(model: Model, t: float, q: Vector, u: Vector) -> Vector:
    """Return what the functions of the user give that look at the state, in the order of `load_columns`."""
    order_n = model.order_n
    if order_n is None:
        return np.zeros(0)
    values = order_n.values(t, q, u)
    parts = [values[where] for where, _ in (*order_n.inputs.of_state, *order_n.inputs.laws)]
    return np.concatenate([np.zeros(0), *parts])


def load_columns(model: Model, t: float, q: Vector, u: Vector) -> Matrix:
    """Return the generalised forces (free, k) of units of what `load_values` returns."""
    if model.order_n is None:
        return np.zeros((model.free_count, 0))
    full = all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full)
    columns = [np.zeros((model.free_count, 0))]
    for _, load in model.order_n.inputs.of_state:
        columns.append(scene_load_columns(model, load, motions, q, full))
    for _, item in model.order_n.inputs.laws:
        columns += [_law_column(model, item, unit, motions, t, q, full) for unit in _unit_laws(item)]
    return np.column_stack(columns)


def scene_load_columns(
    model: Model, load: PointLoad | JointLoad | FieldLoad, motions: list[FrameMotion], q: Vector, u: Vector
) -> Matrix:
    """Return the generalised forces (free, values) of unit values of a load of the scene.

    Parameters
    ----------
    model : Model
    load : PointLoad, JointLoad or FieldLoad
    motions : list of FrameMotion
        The outward sweep.
    q, u : ndarray
        Coordinates, and all speeds.
    """
    n = model.free_count
    number, interface = carrier(model, load)
    body, G = model.bodies[number], motions[number]
    if isinstance(load, JointLoad):
        column = np.zeros((n, 1))
        column[body.speeds[load.coordinate]] = 1.0
        return column
    frame = frame_of(model, body, interface, G, q, u)
    if isinstance(load, PointLoad):
        wrenches = [replace(load, **_unit(axis)).wrench(0.0, frame) for axis in np.eye(SPACE)]
        return np.column_stack([(frame.V.T @ f + frame.W.T @ m)[:n] for f, m in wrenches])
    eta, _ = elastic_state(body.flexible, q, u, False)  # type: ignore[arg-type]  # field loads are on flexible bodies
    rates = elastic_partial_rates(body.flexible, G.V.shape[1])  # type: ignore[arg-type]
    units = [1.0] if load.is_pressure else list(np.eye(SPACE))
    parts = [replace(load, **_unit(unit)).forces(0.0, G.A_NF, eta) for unit in units]
    return np.column_stack([(G.V.T @ f + G.W.T @ m + rates.T @ e)[:n] for f, m, e in parts])


def scene_loads(model: Model) -> Iterator[PointLoad | JointLoad | FieldLoad]:
    """Yield the loads of a scene that have values: forces, torques, motors, tractions and pressures."""
    for body in model.bodies:
        yield from (load for load, _ in body.loads)
        yield from body.joint_loads
        yield from body.field_loads


def carrier(model: Model, load: PointLoad | JointLoad | FieldLoad) -> tuple[int, InterfaceFrame | None]:
    """Return the body of a load, and the interface it acts on."""
    for number, body in enumerate(model.bodies):
        for other, interface in body.loads:
            if other is load:
                return number, interface
        if any(other is load for other in (*body.joint_loads, *body.field_loads)):
            return number, None
    raise TypeError("the load belongs to another model")


def frame_of(
    model: Model, body: BodyTerms, interface: InterfaceFrame | None, G: FrameMotion, q: Vector, u: Vector
) -> FrameMotion:
    """Return the motion of a body's frame, or of one of its interfaces."""
    if interface is None or body.flexible is None:
        return G
    return interface_motion(G, interface, body.flexible, q, u, model.slopes)


def _unit(value: object) -> dict[str, Any]:
    """Return what makes a load give this value."""
    return {"function": Constant(value), "takes_state": False}


def _unit_laws(item: SpringDamper | Bushing) -> list[SpringDamper | Bushing]:
    """Return springs or bushings that give one unit of the law each, and nothing else."""
    if isinstance(item, SpringDamper):
        return [replace(item, stiffness=0.0, damping=0.0, function=lambda length, rate: 1.0)]
    none = np.zeros(6)
    return [replace(item, stiffness=none, damping=none, function=partial(_constant, unit)) for unit in np.eye(6)]


def _constant(value: Vector, displacement: Vector, rate: Vector) -> Vector:
    return value


def _law_column(
    model: Model,
    item: SpringDamper | Bushing,
    unit: SpringDamper | Bushing,
    motions: list[FrameMotion],
    t: float,
    q: Vector,
    u: Vector,
) -> Matrix:
    alone = replace(
        model,
        springs=(unit,) if isinstance(unit, SpringDamper) else (),
        bushings=(unit,) if isinstance(unit, Bushing) else (),
    )
    column = np.zeros((model.free_count + model.driven_count, 1))
    for _, frame, wrench in interaction_wrenches(alone, motions, t, q, u, len(column)):
        column[:, 0] += frame.V.T @ wrench[:3] + frame.W.T @ wrench[3:]
    return column[: model.free_count]
