"""Characteristic sizes of a scene, scales of the components of a state, and the relation of coordinates and speeds."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.frames import Vector
from kanefe.tree.model_data import QUADRATURES, ModelData

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody

Size = TypeVar("Size")

_extents: WeakKeyDictionary[FlexibleBody, float] = WeakKeyDictionary()


def largest_extent(body: FlexibleBody) -> float:
    """Return the longest side of the box around a mesh in m; cached, since it takes longer than a short run."""
    if body not in _extents:
        _extents[body] = float(np.ptp(body.nodes, axis=0).max())
    return _extents[body]


def kept_of_scene(measure: Callable[[ModelData], Size]) -> Callable[[ModelData], Size]:
    """Cache a measure for each frozen scene, whatever its start is; arrays are read-only."""

    @wraps(measure)
    def kept(model: ModelData) -> Size:
        found = model.of_scene
        if measure not in found:
            size = found[measure] = measure(model)
            if isinstance(size, np.ndarray):
                size.flags.writeable = False
        return cast("Size", found[measure])

    return kept


def scene_length(model: ModelData) -> float:
    """Return a length of the scene in m: `own_length`, or 1 m if nothing has a size."""
    return own_length(model) or 1.0


def own_length(model: ModelData) -> float:
    """Return a length of the scene in m: `length_of_parts`, or else the largest joint displacement at the start.

    Without one it is the largest displacement of a limit or of a spring at rest; 0 if nothing has a size.
    """
    return length_of_parts(model) or _distance_at_start(model) or _distance_of_laws(model)


@kept_of_scene
def length_of_parts(model: ModelData) -> float:
    """Return a length in m that does not depend on the start: the largest of flexible bodies and offsets.

    If there are none, it is the radius of gyration of the bodies; 0 if they have none.
    """
    lengths = [largest_extent(b.flexible.body) for b in model.bodies if b.flexible]
    offsets = [b.p_PoFo_P for b in model.bodies]
    offsets += [b.rigid.com for b in model.bodies if b.rigid]
    offsets += [m.point for c in model.constraints for m in (c.a, c.b) if m is not None]
    offsets += [m.point for load in model.loads for m in load.ends if m.body >= 0]
    lengths += [math.sqrt(offset @ offset) for offset in offsets]
    largest = max(lengths, default=0.0)
    return largest or _radius_of_gyration(model)


@kept_of_scene
def moving_length(model: ModelData) -> float:
    """Return a length of what moves in m: as `scene_length`, but for places in N and in what is fixed in it.

    How far from the origin, or from a mark, a scene is built changes neither its motion nor how exactly it is wanted.
    """
    is_fixed = [False] * (len(model.bodies) + 1)  # the last one is N, which has the number -1
    is_fixed[-1] = True
    for i, body in enumerate(model.bodies):
        is_fixed[i] = is_fixed[body.parent] and not len(body.speeds) and body.flexible is None
    moving = [body for i, body in enumerate(model.bodies) if not is_fixed[i]]
    lengths = [largest_extent(b.flexible.body) for b in moving if b.flexible]
    lengths += [float(np.linalg.norm(b.p_PoFo_P)) for b in moving if not is_fixed[b.parent]]
    lengths += [float(np.linalg.norm(b.rigid.com)) for b in moving if b.rigid]
    markers = [m for c in model.constraints for m in (c.a, c.b) if m is not None]
    markers += [m for load in model.loads for m in load.ends]
    lengths += [float(np.linalg.norm(m.point)) for m in markers if not is_fixed[m.body]]
    largest, most = max(lengths, default=0.0), scene_length(model)
    return min(most, largest or _radius_of_gyration(model) or most)  # points alone have no size


def scene_energy(model: ModelData, length: float) -> float:
    """Return an energy of the scene in J: the kinetic one at a speed of its length, or a radian, in a second."""
    return (sum(part.mass for part in _masses(model)) * length**2 + _inertia(model)) or 1.0


def scene_weight(model: ModelData) -> float:
    """Return the weight of all bodies, N."""
    return sum(part.mass for part in _masses(model)) * float(np.linalg.norm(model.gravity))


def _masses(model: ModelData) -> list[Any]:
    return [body.flexible.body if body.flexible else body.rigid for body in model.bodies if body.flexible or body.rigid]


def _inertia(model: ModelData) -> float:
    return sum(float(np.trace(body.rigid.inertia)) for body in model.bodies if body.rigid)


def _radius_of_gyration(model: ModelData) -> float:
    mass = sum(body.rigid.mass for body in model.bodies if body.rigid)
    return math.sqrt(_inertia(model) / mass) if mass > 0.0 else 0.0


def _distance_at_start(model: ModelData) -> float:
    ranges = joint_scales(model, 0.0)
    distances = [0.0]
    for body in model.bodies:
        for at, speed in zip(*body.free_coordinates(), strict=False):
            if ranges[speed] == 0.0:
                distances.append(abs(float(model.initial_coordinates[at])))
    return max(distances)


def _distance_of_laws(model: ModelData) -> float:
    found = [0.0]
    for body in model.bodies:
        for unit, law in zip(body.joint.units, body.joint.coordinate_forces, strict=False):
            if law is not None and unit != "rad":
                found += [abs(x) for x in (*law.limits, law.rest) if x is not None and math.isfinite(x)]
    return max(found)


def joint_scales(model: ModelData, length: float) -> np.ndarray:
    """Return a large displacement along every free speed: 1 rad, or `length` in m; infinite for elastic coordinates."""
    scales = np.full(model.free_count, np.inf)
    for body in model.bodies:
        for where, unit in zip(body.speeds, body.joint.units, strict=True):
            if where < model.free_count:
                scales[where] = 1.0 if unit == "rad" else length
    return scales


@kept_of_scene
def displacement_scales(model: ModelData) -> np.ndarray:
    """Return the size of a large displacement along every free speed, shape (free,): rad, m, or modal units."""
    length = moving_length(model)
    scales = joint_scales(model, length)
    for body in model.bodies:
        if body.flexible:
            flexible = body.flexible.body
            extent = largest_extent(flexible) or length
            # kinetic energy 1/2 m_i deta^2: eta = sqrt(m / m_i) L moves the body by about its length
            modal = flexible.moments.elastic_mass.diagonal()[: flexible.free_count]
            scales[body.flexible.speeds] = extent * np.sqrt(flexible.mass / np.maximum(modal, 1e-300))
    return scales


@kept_of_scene
def coordinate_moves(model: ModelData) -> list[tuple[bool, int, int]]:
    """Return for each coordinate or rotation whether it is a rotation, and the indices of its coordinate and speed.

    A rotation has four Euler parameters from the coordinate on, and three speeds: see
    `kanefe.kernels.steppers.step_commands`.
    """
    moves = []
    for body in model.bodies:
        at, speeds = body.free_coordinates()
        turning = body.joint.rotation_at
        if turning is None:
            moves += [(False, int(q), int(u)) for q, u in zip(at, speeds, strict=True)]
        else:
            moves += [(False, int(q), int(u)) for q, u in zip(at[:turning], speeds, strict=False)]
            moves.append((True, int(at[turning]), int(speeds[turning])))
            moves += [(False, int(q), int(u)) for q, u in zip(at[turning + 4 :], speeds[turning + 3 :], strict=True)]
        if body.flexible:
            first, speed = body.flexible.eta.start, body.flexible.speeds.start
            moves += [(False, first + i, speed + i) for i in range(body.flexible.body.free_count)]
    return moves


@kept_of_scene
def tangents(model: ModelData) -> np.ndarray:
    """Return the independent directions of a state: tangents, speeds, and internal states with rates.

    Shape (2 free + states, state); those of rotations, which depend on the state, are zero among the coordinates.
    """
    n, m = model.coordinate_count, model.free_count
    moving = model.state_count if model.states_move else 0
    directions = np.eye(2 * m + moving, n + m + model.state_count + QUADRATURES, k=n - m)
    directions[:m] = 0.0
    for turns, at, speed in coordinate_moves(model):
        if not turns:
            directions[speed, at] = 1.0
    return directions


@kept_of_scene
def turning(model: ModelData) -> list[tuple[int, int]]:
    """Return the indices of the first Euler parameter and of the first speed of each rotation."""
    return [(at, speed) for turns, at, speed in coordinate_moves(model) if turns]


@kept_of_scene
def modal_frequencies(model: ModelData) -> Vector:
    """Return the frequency in rad/s of the mode of each free speed, uncoupled; zero for joint speeds."""
    frequencies = np.zeros(model.free_count)
    for body in model.bodies:
        if body.flexible:
            k = body.flexible.body.free_count
            stiffness = np.diag(body.flexible.body.stiffness)[:k]
            mass = np.diag(body.flexible.body.moments.elastic_mass)[:k]
            frequencies[body.flexible.speeds] = np.sqrt(np.maximum(stiffness, 0.0) / mass)
    return frequencies


@kept_of_scene
def state_scales(model: ModelData) -> Vector:
    """Return a large value of each component of (q, u, z, quadratures).

    These are a radian, the size of what moves in m, and the modal displacement that moves a body by its size; the same
    in a second for speeds; and the energy of such speeds. For a mode above 1 rad/s, the speed is the displacement times
    its frequency. Internal states of loads have scales of their own.
    """
    n, m = model.coordinate_count, model.free_count
    displacements = displacement_scales(model)
    scales = np.ones(n + m + model.state_count + QUADRATURES)
    for turns, at, speed in coordinate_moves(model):
        if not turns:
            scales[at] = displacements[speed]
    scales[n : n + m] = displacements * np.maximum(1.0, modal_frequencies(model))
    acceleration = float(np.linalg.norm(model.gravity)) or 1.0
    for load, states in zip(model.loads, model.load_states, strict=True):
        scales[n + m + states.start : n + m + states.stop] = load.state_scales(acceleration)
    scales[-QUADRATURES:] = scene_energy(model, moving_length(model))
    return scales
