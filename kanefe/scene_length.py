"""Sizes of a scene, against which displacements are small or large."""

from __future__ import annotations

import math
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.flexible import FlexibleBody
from kanefe.model import Model

_extents: WeakKeyDictionary[FlexibleBody, float] = WeakKeyDictionary()


def largest_extent(body: FlexibleBody) -> float:
    """Return the longest side of the box around a mesh in m; kept: short runs take less time than large meshes."""
    if body not in _extents:
        _extents[body] = float(np.ptp(body.nodes, axis=0).max())
    return _extents[body]


def scene_length(model: Model) -> float:
    """Return a length of the scene in m: of its flexible bodies and the offsets in it.

    Where there are none, bodies are as large as their radius of gyration, points as far as they are from their origin;
    1 m if nothing has a size.
    """
    lengths = [largest_extent(b.flexible.body) for b in model.bodies if b.flexible]
    lengths += [float(np.linalg.norm(b.p_PoFo_P)) for b in model.bodies]
    lengths += [float(np.linalg.norm(b.rigid.com)) for b in model.bodies if b.rigid]
    lengths += [float(np.linalg.norm(m.point)) for c in model.constraints for m in (c.a, c.b) if m is not None]
    lengths += [float(np.linalg.norm(m.point)) for s in model.springs for m in (s.a, s.b) if m.body >= 0]
    largest = max(lengths, default=0.0)
    return largest or _radius_of_gyration(model) or _distance_at_start(model) or 1.0


def scene_energy(model: Model, length: float) -> float:
    """Return an energy of the scene in J: its kinetic one where all moves by its length, or a radian, in a second."""
    mass = sum(part.mass for part in _masses(model))
    return (mass * length**2 + _inertia(model)) or 1.0


def _masses(model: Model) -> list[Any]:
    return [body.flexible.body if body.flexible else body.rigid for body in model.bodies if body.flexible or body.rigid]


def _inertia(model: Model) -> float:
    return sum(float(np.trace(body.rigid.inertia)) for body in model.bodies if body.rigid)


def _radius_of_gyration(model: Model) -> float:
    mass = sum(body.rigid.mass for body in model.bodies if body.rigid)
    return math.sqrt(_inertia(model) / mass) if mass > 0.0 else 0.0


def _distance_at_start(model: Model) -> float:
    ranges = joint_scales(model, 0.0)
    distances = [0.0]
    for body in model.bodies:
        for at, speed in zip(*body.free_coordinates(), strict=False):
            if ranges[speed] == 0.0:
                distances.append(abs(float(model.initial_coordinates[at])))
    return max(distances)


def joint_scales(model: Model, length: float) -> np.ndarray:
    """Return a large displacement along every free speed: 1 rad, or `length` in m; infinite for elastic coordinates."""
    scales = np.full(model.free_count, np.inf)
    for body in model.bodies:
        for where, name in zip(body.speeds, body.joint.speed_names, strict=True):
            if where < model.free_count:
                scales[where] = 1.0 if "rad" in name else length
    return scales


def displacement_scales(model: Model) -> np.ndarray:
    """Return the size of a large displacement along every free speed, shape (free,): rad, m, or modal units."""
    length = scene_length(model)
    scales = joint_scales(model, length)
    for body in model.bodies:
        if body.flexible:
            flexible = body.flexible.body
            extent = largest_extent(flexible) or length
            # kinetic energy 1/2 m_i deta^2: eta = sqrt(m / m_i) L moves the body by about its length
            modal = np.diag(flexible.moments.elastic_mass)[: flexible.free_count]
            scales[body.flexible.speeds] = extent * np.sqrt(flexible.mass / np.maximum(modal, 1e-300))
    return scales
