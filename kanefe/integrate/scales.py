"""What the components of a state are measured by, and how coordinates move with the speeds."""

from __future__ import annotations

import numpy as np

from kanefe.equations_of_motion import WORKS
from kanefe.frames import Vector
from kanefe.joints import Free, Spherical
from kanefe.model import Model
from kanefe.scene_length import displacement_scales, scene_energy, scene_length


def coordinate_moves(model: Model) -> list[tuple[bool, int, int]]:
    """Return how coordinates move with the speeds: whether they turn, coordinate, and speed.

    What turns are the four Euler parameters from the coordinate on, with three speeds: see `kanefe.kernels.stepping`.
    """
    moves = []
    for body in model.bodies:
        at, speeds = body.free_coordinates()
        straight = len(at)
        if isinstance(body.joint, (Free, Spherical)):
            straight = len(at) - 4
        moves += [(False, int(q), int(u)) for q, u in zip(at[:straight], speeds[:straight], strict=False)]
        if straight < len(at):
            moves.append((True, int(at[straight]), int(speeds[straight])))
        if body.flexible:
            first, speed = body.flexible.eta.start, body.flexible.speeds.start
            moves += [(False, first + i, speed + i) for i in range(body.flexible.body.free_count)]
    return moves


def modal_frequencies(model: Model) -> Vector:
    """Return the frequency in rad/s of the mode behind each free speed, alone; zero for what is no mode."""
    frequencies = np.zeros(model.free_count)
    for body in model.bodies:
        if body.flexible:
            k = body.flexible.body.free_count
            stiffness = np.diag(body.flexible.body.stiffness)[:k]
            mass = np.diag(body.flexible.body.moments.elastic_mass)[:k]
            frequencies[body.flexible.speeds] = np.sqrt(np.maximum(stiffness, 0.0) / mass)
    return frequencies


def state_scales(model: Model) -> Vector:
    """Return what counts as a large value of each component of (q, u, works).

    Large are a radian, the size of the scene in m and what moves a body by its size in modal units; these a second; and
    the energy of such speeds. A modal speed counts in the amplitude that it causes: against a large displacement times
    the frequency of its mode.
    """
    n, m = model.coordinate_count, model.free_count
    displacements = displacement_scales(model)
    scales = np.ones(n + m + WORKS)
    for turns, at, speed in coordinate_moves(model):
        if not turns:
            scales[at] = displacements[speed]
    scales[n : n + m] = displacements * np.maximum(1.0, modal_frequencies(model))
    scales[n + m :] = scene_energy(model, scene_length(model))
    return scales
