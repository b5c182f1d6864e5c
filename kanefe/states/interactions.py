"""Forces of loads between frames, on the partial velocities of their ends (Eq. 11)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from kanefe.bodies.marker import CoordinateMarker, Marker, ModalMarker
from kanefe.frames import Matrix, Vector
from kanefe.states.kinematics import elastic_partial_rates
from kanefe.states.state import State, actions

if TYPE_CHECKING:
    from kanefe.loads.anchors import Anchor
    from kanefe.states.kinematics import FrameMotion


class MarkerWrench(NamedTuple):
    """Force and moment (6,) on a marker about its origin, in its axes, with its motion."""

    marker: Marker
    frame: FrameMotion
    wrench: Vector


def load_wrenches(state: State) -> Iterator[MarkerWrench]:
    """Yield the wrenches of all loads on their ends that are frames: what acts in a joint is part of its reaction."""
    for load, action in zip(state.model.loads, actions(state), strict=True):
        for marker, wrench in zip(load.ends, action.wrenches, strict=True):
            if isinstance(marker, CoordinateMarker):
                continue
            F = state.marker(marker)
            yield MarkerWrench(marker, F, np.concatenate((F.A_NF.T @ wrench[:3], F.A_NF.T @ wrench[3:])))


def generalised_force(state: State, ends: tuple[Marker, ...], wrenches: Matrix) -> Vector:
    """Return ``sum V^T R + W^T T`` of wrenches (ends, 6) in N on some markers (Eq. 11), shape (columns,)."""
    F = np.zeros(state.columns)
    for marker, wrench in zip(ends, wrenches, strict=True):
        if isinstance(marker, CoordinateMarker):
            F += _along(state, marker) * wrench[0]
            continue
        frame = state.marker(marker)
        F += frame.V.T @ (frame.A_NF.T @ wrench[:3]) + frame.W.T @ (frame.A_NF.T @ wrench[3:])
    return F


def _along(state: State, marker: CoordinateMarker) -> Vector:
    """Return the partial rate of a coordinate, (columns,); of a mode with what is transferred to fixed components."""
    row, (_, speed) = np.zeros(state.columns), state.model.place_of(marker)
    terms = state.model.bodies[marker.body].flexible
    if isinstance(marker, ModalMarker) and terms is not None and state.columns > terms.fixed.start:
        rates, k = elastic_partial_rates(terms, state.columns), terms.body.free_count
        return np.asarray(rates[marker.coordinate] + terms.transfer[:, marker.coordinate] @ rates[k:])
    row[speed] = 1.0
    return row


def _moves(state: State, marker: Marker) -> Matrix:
    """Return the partial velocities of an end of a load, (6, columns), in N."""
    if isinstance(marker, CoordinateMarker):
        wide = np.zeros((6, state.columns))
        wide[0] = _along(state, marker)
        return wide
    F = state.marker(marker)
    return np.vstack((F.A_NF @ F.V, F.A_NF @ F.W))


def slip_rows(state: State, number: int, anchor: Anchor) -> Matrix:
    """Return the partial rates of the slips of an anchor of a load, by its number, (r, columns)."""
    moves = np.vstack([_moves(state, marker) for marker in state.model.loads[number].ends])
    return np.asarray(anchor.rows @ moves)


def add_interactions(state: State, F: Vector) -> None:
    """Add the generalised forces of all loads between frames to F: ``V^T R + W^T T`` of their ends (Eq. 11)."""
    for _, frame, wrench in load_wrenches(state):
        F += frame.V.T @ wrench[:3] + frame.W.T @ wrench[3:]
    for load, action in zip(state.model.loads, actions(state), strict=True):
        for marker, wrench in zip(load.ends, action.wrenches, strict=True):
            if isinstance(marker, CoordinateMarker):
                F += _along(state, marker) * wrench[0]


def add_load_slopes(state: State, K: Matrix, C: Matrix) -> None:
    """Add stiffness and damping of loads between frames to K and C over the free speeds, if they provide them."""
    n = len(K)
    for i, load in enumerate(state.model.loads):
        found = load.tangent(state.t, state.load_ends(i), state.load_states(i))
        if found is None:
            continue
        moves = np.vstack([_moves(state, marker) for marker in load.ends])
        D = (found.rows @ moves)[:, :n]
        K += D.T @ (found.stiffness[:, None] * D)
        C += D.T @ (found.damping[:, None] * D)


def unit_wrenches(components: tuple[int, ...], tangent: Matrix, axes: Matrix) -> Matrix:
    """Return force and moment in axes of G of unit coupling forces of one interface, shape (6, forces).

    Forces are along the axes of the interface, columns of A. A moment holds one slope, theta_i of ``theta = A
    theta_n``, and does no work on the others: with ``w = T dtheta`` it is column i of T^-T A, the axis itself while the
    released slopes are small.
    """
    full = np.zeros((6, 6))
    full[:3, :3] = axes
    full[3:, 3:] = np.linalg.solve(tangent.T, axes)
    return full[:, list(components)]
