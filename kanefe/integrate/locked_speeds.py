"""The error of joint speeds without what vibrations of flexible bodies have in it.

A flexible body that vibrates shakes its joints: their speeds have an error as large as that of the modal speeds,
although it moves nothing by more than the deflection. Elastic forces do no work on joints, so that vibrations leave the
momenta of the joints alone, ``M_rr e_r + M_re e_e = 0`` for their errors e of joint and modal speeds. Speeds with the
same momenta while no mode moves, ``e_r + M_rr^-1 M_re e_e``, are what drifts, and are compared with the tolerance of
joint speeds; modal speeds are compared with their own, which is larger by their frequency.

A controller that reads speeds sees vibrations at its samples, and holds what it makes of them until the next, a time T
later. What steps h add up to until a sample moves something by T times that, so that an error of a joint speed itself
counts with ``T max(1, T / h)``, in the place of a second.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kanefe.frames import Vector
from kanefe.integrate.dynamics import Dynamics
from kanefe.loads.controller import Held
from kanefe.tree.model_data import ModelData
from kanefe.tree.scales import modal_frequencies


class LockedSpeeds(NamedTuple):
    """How errors of speeds are measured.

    Attributes
    ----------
    every : float
        The shortest time between samples, s, 0 without any.
    joint_of_speed : ndarray, shape (free,)
        For each free speed the number of a row, from 1 on; 0 for modal ones.
    rows : ndarray, shape (joints, free)
        A row times the errors of all free speeds is to be added to the error of its joint speed.
    """

    every: float
    joint_of_speed: np.ndarray
    rows: np.ndarray


def has_locked_speeds(model: ModelData, is_damping: bool = True) -> bool:
    """Return whether a scene has joints that vibrations shake, and nothing but samples that asks for their speeds.

    Loops have momenta of their own; friction, contacts, stops and functions of the state may turn on a small speed.
    `is_damping`: whether the method damps what it steps over; one under which that may grow has to see it, where a
    body has no damping.
    """
    flexible = [body.flexible.body for body in model.bodies if body.flexible is not None]
    if not is_damping and not all(np.any(body.damping) for body in flexible):
        return False
    vibrates = modal_frequencies(model) > 0.0
    if model.constraints or model.has_stops or model.states_move or not vibrates.any() or vibrates.all():
        return False
    if any(load.acts_at_once or load.kernel is None for load in model.loads):
        return False
    own = [(*(load for load, _ in body.loads), *body.joint_loads, *body.field_loads) for body in model.bodies]
    asks = any(load.takes_state and not isinstance(load.function, Held) for loads in own for load in loads)
    return not asks and all(controller.is_sampled for controller in model.controllers)


def locked_speeds(dynamics: Dynamics, t: float, y: Vector, is_damping: bool) -> LockedSpeeds | None:
    """Return how errors of speeds are measured, with the mass matrix of a state; None: as they are.

    That is so where no joint is shaken, or joints have no inertia. `is_damping`: see `has_locked_speeds`.
    """
    model = dynamics.model
    if not has_locked_speeds(model, is_damping):
        return None
    m, vibrates = model.free_count, modal_frequencies(model) > 0.0
    joints = np.flatnonzero(~vibrates)
    M = dynamics.route.mass_matrix(t, y)[joints, :m]
    try:
        rows = np.linalg.solve(M[:, joints], np.where(vibrates, M, 0.0))
    except np.linalg.LinAlgError:
        return None
    if not np.isfinite(rows).all():
        return None
    numbers = np.zeros(m)
    numbers[joints] = 1 + np.arange(len(joints))
    return LockedSpeeds(min((controller.every for controller in model.controllers), default=0.0), numbers, rows)
