"""Assembly of ``M_sys du = F_sys`` over a tree of rigid and flexible bodies (Eq. 10, 18, 39)."""

from __future__ import annotations

from collections.abc import Callable
from weakref import WeakKeyDictionary

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.kane.active import add_loads, elastic_forces
from kanefe.kane.inertia import flexible_inertia, rigid_inertia, rigid_masses
from kanefe.states.constrained_solver import ConstrainedSolver, constrained_solver, solve_positive_definite
from kanefe.states.constraints import constraint_rates, force_rows, held_rows
from kanefe.states.interactions import add_interactions
from kanefe.states.kinematics import FrameMotion, elastic_partial_rates, elastic_state
from kanefe.states.state import State, once
from kanefe.tree.body_terms import FlexibleTerms
from kanefe.tree.model_data import ModelData

Inertia = Callable[[FlexibleTerms, FrameMotion, Vector, Vector, Vector], tuple[Matrix, Vector]]


def assemble(state: State, inertia: Inertia = flexible_inertia) -> tuple[Matrix, Vector]:
    """Return M_sys and F_sys of Kane's equations (Eq. 9, 10, 18) without unknown coupling forces.

    Parameters
    ----------
    state : State
        If it is wide, the rows of the fixed interface components are there too.
    inertia : callable
        `flexible_inertia` (constants) or `flexible_inertia_from_nodes` (Eq. 38 as written).

    Returns
    -------
    M : ndarray, shape (columns, columns)
    F : ndarray, shape (columns,)
    """
    model, columns = state.model, state.columns
    M, F = np.zeros((columns, columns)), np.zeros(columns)
    for body, frame in zip(model.bodies, state.motions, strict=True):
        gravity = frame.A_NF.T @ model.gravity if body.has_gravity else np.zeros(3)
        if body.rigid is not None:
            M_body, F_body = rigid_inertia(body.rigid, frame, gravity)
            M += M_body
            F += F_body
        if body.flexible is not None:
            terms = body.flexible
            eta, deta = elastic_state(terms, state.q, state.full, columns > terms.fixed.start)
            M_body, F_body = inertia(terms, frame, gravity, eta, deta)
            M += M_body
            F += F_body
            F += elastic_partial_rates(terms, columns).T @ elastic_forces(terms, eta, deta)
        add_loads(state, body, frame, F)
    add_interactions(state, F)
    _add_armatures(state, M)
    return M, F


def _add_armatures(state: State, M: Matrix) -> None:
    """Add the inertia of rotors behind gears, each along its own speed; their rates have no remainders."""
    own = state.model.armatures[: len(M)]
    M.flat[: len(M) * len(own) : len(M) + 1] += own


@once
def equations(state: State) -> tuple[Matrix, Vector]:
    """Return M_sys and F_sys as `assemble` does, once for a state."""
    return assemble(state)


@once
def mass_matrix(state: State) -> Matrix:
    """Return M_sys alone, over the speeds that the state spans, without evaluating loads."""
    if equations in state.kept:
        return equations(state)[0]
    M = rigid_masses([(body.rigid, R) for body, R in zip(state.model.bodies, state.motions, strict=True) if body.rigid])
    M = np.zeros((state.columns, state.columns)) if M is None else M
    zero = np.zeros(3)
    for body, frame in zip(state.model.bodies, state.motions, strict=True):
        if body.flexible is not None:
            is_extended = state.columns > body.flexible.fixed.start
            own = elastic_state(body.flexible, state.q, state.full, is_extended)
            M += flexible_inertia(body.flexible, frame, zero, *own)[0]
    _add_armatures(state, M)
    return M


_starts: WeakKeyDictionary[ModelData, tuple[float, Matrix]] = WeakKeyDictionary()


def mass_at_start(model: ModelData, t: float) -> Matrix:
    """Return M_sys over the free speeds as a scene starts at a time (s), (free, free).

    Kept with the scene: the choice of a method asks for it more than once, which would take longer than a short run.
    """
    kept = _starts.get(model)
    if kept is None or kept[0] != t:
        n = model.free_count
        M = mass_matrix(State(model, t, model.initial_coordinates, model.initial_speeds))[:n, :n]
        M.flags.writeable = False
        _starts[model] = kept = t, M
    return kept[1]


@once
def accelerations(state: State) -> Vector:
    """Return du of the free speeds (Eq. 18), shape (free,): fixed rows deleted, driven ones known, loops held."""
    model = state.model
    if model.is_constrained and held_rows(state):
        return held_accelerations(state)[0]
    M, F = equations(state)
    n = model.free_count
    if model.driven_count == 0:
        return solve_positive_definite(model, M, F)
    return solve_positive_definite(model, M[:n, :n], F[:n] - M[:n, n:] @ state.driven_rates)


@once
def held_solver(state: State) -> ConstrainedSolver:
    """Return the solver of the free speeds with all rows that hold."""
    model, n, forces = state.model, state.model.free_count, force_rows(state)
    rows = constraint_rates(state).over(slice(n))
    return constrained_solver(model, equations(state)[0][:n, :n], rows, None if forces is None else forces[:, :n])


@once
def held_accelerations(state: State) -> tuple[Vector, Vector, float]:
    """Return du of the free speeds (free,), the multipliers of the constraints (rows,), `ConstrainedSolver.weakest`.

    A multiplier is the force (N) or moment (N m) of its row: see `kanefe.constraints.rows`.
    """
    n, rows, solver = state.model.free_count, constraint_rates(state), held_solver(state)
    M, F = equations(state)
    known = rows.remainder + rows.J[:, n:] @ state.driven_rates
    return *solver.solve(F[:n] - M[:n, n:] @ state.driven_rates, known), solver.weakest
