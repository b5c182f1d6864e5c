"""Assembly of ``M_sys du = F_sys`` over a tree of rigid and flexible bodies (Eq. 10, 18, 39)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg

from kanefe.errors import SimulationError
from kanefe.frames import Matrix, Vector
from kanefe.kane.active import add_loads, elastic_forces
from kanefe.kane.constraints import PIVOT_TOLERANCE, ConstrainedSolver, Rates, constraint_rates
from kanefe.kane.inertia import flexible_inertia, rigid_inertia
from kanefe.kane.interactions import add_interactions
from kanefe.kane.kinematics import FrameMotion, elastic_partial_rates, elastic_state, sweep_outward
from kanefe.tree.model_data import ModelData
from kanefe.tree.scene_state import SceneState


def all_speeds(model: ModelData, t: float, u: Vector) -> Vector:
    """Return free, driven and fixed speeds: what is given by time or zero filled in."""
    if model.driven_count + model.fixed_count == 0:
        return u
    driven, _ = model.driven_speeds(t)
    return np.concatenate((u, driven, np.zeros(model.fixed_count)))


def assemble(
    model: ModelData,
    t: float,
    q: Vector,
    u: Vector,
    *,
    columns: int | None = None,
    inertia: Callable[..., tuple[Matrix, Vector]] = flexible_inertia,
    motions: list[FrameMotion] | None = None,
) -> tuple[Matrix, Vector]:
    """Return M_sys and F_sys of Kane's equations (Eq. 9, 10, 18) without unknown coupling forces.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    q : ndarray, shape (coordinates,)
    u : ndarray, shape (free,)
    columns : int, optional
        Over how many speeds; default: free and driven. All of them gives the rows of the fixed interface components.
    inertia : callable
        `flexible_inertia` (constants) or `flexible_inertia_from_nodes` (Eq. 38 as written).
    motions : list of FrameMotion, optional
        The outward sweep, if it has been made.

    Returns
    -------
    M : ndarray, shape (columns, columns)
    F : ndarray, shape (columns,)
    """
    columns = model.free_count + model.driven_count if columns is None else columns
    full = all_speeds(model, t, u)
    motions = sweep_outward(model, t, q, full, columns) if motions is None else motions
    M, F = np.zeros((columns, columns)), np.zeros(columns)
    state = SceneState(model, t, q, full, motions)
    for body, frame in zip(model.bodies, motions, strict=True):
        gravity = frame.A_NF.T @ model.gravity if body.has_gravity else np.zeros(3)
        if body.rigid is not None:
            M_body, F_body = rigid_inertia(body.rigid, frame, gravity)
            M += M_body
            F += F_body
        if body.flexible is not None:
            terms = body.flexible
            is_extended = columns > terms.fixed.start
            eta, deta = elastic_state(terms, q, full, is_extended)
            M_body, F_body = inertia(terms, frame, gravity, eta, deta)
            M += M_body
            F += F_body
            F += elastic_partial_rates(terms, columns).T @ elastic_forces(terms, eta, deta)
        add_loads(model, body, frame, t, q, full, F, state)
    if model.has_interactions:
        add_interactions(model, motions, t, q, full, F)
    return M, F


def mass_matrix(model: ModelData, motions: list[FrameMotion], q: Vector, u: Vector) -> Matrix:
    """Return M_sys alone, over the speeds that the sweep spans: no load is asked for."""
    columns = motions[0].V.shape[1]
    M = np.zeros((columns, columns))
    zero = np.zeros(3)
    for body, frame in zip(model.bodies, motions, strict=True):
        if body.rigid is not None:
            M += rigid_inertia(body.rigid, frame, zero)[0]
        if body.flexible is not None:
            is_extended = columns > body.flexible.fixed.start
            M += flexible_inertia(body.flexible, frame, zero, *elastic_state(body.flexible, q, u, is_extended))[0]
    return M


def solve_positive_definite(model: ModelData, M: Matrix, F: Vector) -> Vector:
    """Return ``M^-1 F``; a singular mass matrix is an error that names the speeds without inertia."""
    if not len(F):
        return F
    factor, solution, failed_at = scipy.linalg.lapack.dposv(M, F)  # scipy's own solve takes twice the time, for checks
    if failed_at or np.any(np.diag(factor) ** 2 <= PIVOT_TOLERANCE * np.diag(M)):
        raise singular_mass(model, M)
    return np.asarray(solution)


def singular_mass(model: ModelData, M: Matrix) -> SimulationError:
    """Return the error that a mass matrix without an inverse deserves: it names the speeds without inertia."""
    if not np.all(np.isfinite(M)):
        return SimulationError("the motion has grown without bound. Remedy: check the loads, or tighten rtol")
    _, vectors = np.linalg.eigh(M)
    names = speed_names(model)
    guilty = ", ".join(names[i] for i in np.argsort(-abs(vectors[:, 0]))[:3] if abs(vectors[i, 0]) > 0.1)
    return SimulationError(
        f"the mass matrix is singular: nothing has inertia along {guilty}. "
        "Remedy: give a body there a mass or inertia, or fix the joint"
    )


def speed_names(model: ModelData) -> tuple[str, ...]:
    """Return a name for every free speed."""
    names = [""] * model.free_count
    for body in model.bodies:
        for where, name in zip(body.speeds, body.joint.speed_names, strict=True):
            if where < model.free_count:
                names[where] = f"{body.name}: {name}"
        if body.flexible:
            for i in range(body.flexible.body.free_count):
                names[body.flexible.speeds.start + i] = f"{body.name}: deta {i}"
    return tuple(names)


def accelerations(model: ModelData, t: float, q: Vector, u: Vector) -> Vector:
    """Return du of the free speeds (Eq. 18), shape (free,): fixed rows deleted, driven ones known, loops held."""
    if model.constraints:
        return constrained_accelerations(model, t, q, u)[0]
    M, F = assemble(model, t, q, u)
    n = model.free_count
    if model.driven_count == 0:
        return solve_positive_definite(model, M, F)
    _, driven_rates = model.driven_speeds(t)
    return solve_positive_definite(model, M[:n, :n], F[:n] - M[:n, n:] @ driven_rates)


def constrained_accelerations(model: ModelData, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return du of the free speeds (free,) and the multipliers of the constraints (rows,).

    A multiplier is the force (N) or moment (N m) of its row: see `kanefe.constraints.rows`.
    """
    return held_accelerations(model, t, q, u)[:2]


def held_accelerations(model: ModelData, t: float, q: Vector, u: Vector) -> tuple[Vector, Vector, float]:
    """Return what `constrained_accelerations` returns, and `ConstrainedSolver.weakest`."""
    motions = sweep_outward(model, t, q, all_speeds(model, t, u))
    M, F = assemble(model, t, q, u, motions=motions)
    rows = constraint_rates(model, motions, q, all_speeds(model, t, u))
    n = model.free_count
    _, driven_rates = model.driven_speeds(t)
    solver = constrained_solver(model, M[:n, :n], rows.over(slice(n)))
    known = rows.remainder + rows.J[:, n:] @ driven_rates
    return *solver.solve(F[:n] - M[:n, n:] @ driven_rates, known), solver.weakest


def constraint_forces(model: ModelData, t: float, q: Vector, u: Vector, motions: list[FrameMotion]) -> Vector:
    """Return ``J^T lambda``, the generalised forces of the constraints, over the speeds that the sweep spans."""
    if not model.constraints:
        return np.zeros(motions[0].V.shape[1])
    _, multipliers = constrained_accelerations(model, t, q, u)
    return np.asarray(constraint_rates(model, motions, q, all_speeds(model, t, u)).J.T @ multipliers)


def constrained_solver(model: ModelData, M: Matrix, rates: Rates) -> ConstrainedSolver:
    """Return the solver for M and rows over the free speeds; an error names speeds that nothing has inertia along."""
    try:
        return ConstrainedSolver(M, rates)
    except np.linalg.LinAlgError:
        raise singular_mass(model, M) from None
