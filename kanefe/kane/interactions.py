"""Forces of loads between frames, on the partial velocities of their ends (Eq. 11)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from kanefe.bodies.marker import Marker
from kanefe.frames import Matrix, Vector
from kanefe.kane.kinematics import FrameMotion
from kanefe.kane.state import State, actions


class MarkerWrench(NamedTuple):
    """Force and moment (6,) on a marker about its origin, in its axes, with its motion."""

    marker: Marker
    frame: FrameMotion
    wrench: Vector


def load_wrenches(state: State) -> Iterator[MarkerWrench]:
    """Yield the wrenches of all loads between frames on their ends."""
    for load, action in zip(state.model.loads, actions(state), strict=True):
        for marker, wrench in zip(load.ends, action.wrenches, strict=True):
            F = state.marker(marker)
            yield MarkerWrench(marker, F, np.concatenate((F.A_NF.T @ wrench[:3], F.A_NF.T @ wrench[3:])))


def generalised_force(state: State, ends: tuple[Marker, ...], wrenches: Matrix) -> Vector:
    """Return ``sum V^T R + W^T T`` of wrenches (ends, 6) in N on some markers (Eq. 11), shape (columns,)."""
    F = np.zeros(state.columns)
    for marker, wrench in zip(ends, wrenches, strict=True):
        frame = state.marker(marker)
        F += frame.V.T @ (frame.A_NF.T @ wrench[:3]) + frame.W.T @ (frame.A_NF.T @ wrench[3:])
    return F


def add_interactions(state: State, F: Vector) -> None:
    """Add the generalised forces of all loads between frames to F: ``V^T R + W^T T`` of their ends (Eq. 11)."""
    for _, frame, wrench in load_wrenches(state):
        F += frame.V.T @ wrench[:3] + frame.W.T @ wrench[3:]


def add_load_slopes(state: State, K: Matrix, C: Matrix) -> None:
    """Add stiffness and damping of loads between frames, as far as they tell, to K and C over the free speeds."""
    n = len(K)
    for i, load in enumerate(state.model.loads):
        found = load.tangent(state.t, state.load_ends(i), state.load_states(i))
        if found is None:
            continue
        frames = [state.marker(marker) for marker in load.ends]
        moves = np.vstack([wide for F in frames for wide in (F.A_NF @ F.V, F.A_NF @ F.W)])
        D = (found.rows @ moves)[:, :n]
        K += D.T @ (found.stiffness[:, None] * D)
        C += D.T @ (found.damping[:, None] * D)
