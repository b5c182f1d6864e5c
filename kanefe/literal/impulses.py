"""What forces and impulses on a state bring: accelerations and jumps of the speeds, loops held."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.assemble import mass_matrix
from kanefe.states.constrained_solver import constrained_solver
from kanefe.states.constraints import constraint_rates

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.states.state import State


def unit_responses(state: State, F: Matrix) -> Matrix:
    """Return the accelerations of the free speeds (free, k) that forces on them (free, k) add; loops hold."""
    model, n = state.model, state.model.free_count
    rows = constraint_rates(state).over(slice(n))
    solver = constrained_solver(model, mass_matrix(state)[:n, :n], rows)
    none = np.zeros(len(rows.J))
    return np.column_stack([np.zeros((n, 0)), *(solver.solve(column, none)[0] for column in F.T)])


def struck_speeds(
    state: State, number: int, interface: InterfaceFrame | None, point: Vector, impulse: Vector, moment: Vector
) -> Vector:
    """Return the free speeds right after an impulse, ``u + M^-1 (V^T p + W^T l)``, shape (free,).

    The equations of motion integrated over a moment in which nothing moves (Kane & Levinson, "Dynamics: Theory and
    Applications", section 7.9).

    Parameters
    ----------
    state : State
    number : int
        The body.
    interface : InterfaceFrame or None
        Of the body; None: its own frame.
    point : ndarray, shape (3,)
        Where it is struck, from the frame's origin in its axes, m.
    impulse, moment : ndarray, shape (3,)
        p and l in components of N, N s and N m s.
    """
    frame, n = state.motion(number, interface), state.model.free_count
    p, about = frame.A_NF.T @ impulse, frame.A_NF.T @ moment
    F = frame.V.T @ p + frame.W.T @ (about + np.cross(point, p))
    return np.asarray(state.u + unit_responses(state, F[:n, None])[:, 0])
