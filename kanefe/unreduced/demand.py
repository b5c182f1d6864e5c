"""Forces of an unreduced body on G and its coordinates at a state: inertia, stiffness and damping, minus loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector
from kanefe.storage.scipy_later import spla
from kanefe.tree.scene_state import SceneState
from kanefe.unreduced.condensed import FrozenMoments, Substructure

if TYPE_CHECKING:
    from kanefe.states.kinematics import FrameMotion

Own = tuple[Vector, Vector, Vector]
"""Coordinates of a substructure, their rates and their accelerations, each (k,)."""


def demand(
    substructure: Substructure, own: Own, a: Vector, alpha: Vector, G: FrameMotion, t: float, state: SceneState | None
) -> tuple[Vector, Vector, Vector]:
    """Return force and moment about the origin of G, in its components, and forces on the free coordinates (k,).

    Parameters
    ----------
    substructure : Substructure
    own : tuple of ndarray
        eta, deta, ddeta.
    a, alpha : ndarray, shape (3,)
        Acceleration of the origin of G less gravity, and angular acceleration.
    G : FrameMotion
    t : float
        s.
    state : SceneState
        For field loads.
    """
    eta, deta, ddeta = own
    body = substructure.body
    force, moment, elastic = body.inertia_field.forces(eta, deta, ddeta, a, alpha, G.w)
    of_mass, of_stiffness = body.damping_factors
    elastic += body.free_stiffness @ (eta + of_stiffness * deta if of_stiffness else eta)
    if of_mass:
        elastic += of_mass * (body.free_mass @ deta)
    if body.damping.nnz:
        elastic += body.damping @ deta
    for load in substructure.field_loads:
        known = load.forces(t, G.A_NF, eta, state)
        force, moment = force - known[0], moment - known[1]
        elastic -= known[2]
    return force, moment, elastic


def equivalent_moments(
    substructure: Substructure, own: Own, a: Vector, alpha: Vector, G: FrameMotion, t: float, state: SceneState
) -> FrozenMoments:
    """Return moments of a body of the complete twin with the same forces at this state."""
    eta, _, ddeta = own
    force, moment, elastic = demand(substructure, own, a, alpha, G, t, state)
    held = _held_demand(substructure, own, a, alpha, G, t, state)
    generalised = some_inertia(substructure, eta)
    bias = np.concatenate((force, moment, _carried_forces(substructure, elastic), held))
    bias -= generalised @ np.concatenate((a, alpha, substructure.carried @ ddeta, np.zeros(len(held))))
    return FrozenMoments(generalised, bias)


def some_inertia(substructure: Substructure, eta: Vector) -> Matrix:
    """Return a metric: rigid inertia of the deformed body, and an inertia of realistic size for carried coordinates.

    Over (translation of G, rotation of G, carried coordinates, fixed ones); zero for the fixed ones.
    """
    body, p = substructure.body, substructure.carried_count
    metric = np.zeros((6 + p + body.fixed_count,) * 2)
    metric[:6, :6] = body.inertia_field.rigid_inertia(eta)[0]
    at = range(6, 6 + p)
    masses = body.free_mass.diagonal()
    masses[body.massless] = np.delete(masses, body.massless).mean()
    metric[at, at] = 1.0 / (substructure.carried.multiply(substructure.carried) @ (1.0 / masses))
    return metric


def _carried_forces(substructure: Substructure, elastic: Vector) -> Vector:
    """Return the forces on d in ``elastic = Q^T force + (mean motions)^T reaction``."""
    if not substructure.carried_count:
        return np.zeros(0)
    rows = np.vstack((substructure.carried.toarray(), substructure.body.mean_motions))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    found = np.linalg.solve(rows @ rows.T, rows @ elastic)[: substructure.carried_count]
    return np.asarray(found / spla.norm(substructure.carried, axis=1))


def _held_demand(
    substructure: Substructure, own: Own, a: Vector, alpha: Vector, G: FrameMotion, t: float, state: SceneState
) -> Vector:
    """Return the forces on the components fixed in G; damping is transferred to them statically."""
    body = substructure.body
    k, held = body.free_count, body.fixed_count
    if not held:
        return np.zeros(0)
    eta, deta, ddeta = own
    padding = np.zeros(held)
    eta_all, deta_all, ddeta_all = (np.concatenate((x, padding)) for x in (eta, deta, ddeta))
    found = body.moments.forces(eta_all, deta_all, ddeta_all, a, alpha, G.w)[2][k:]
    of_mass, of_stiffness = body.damping_factors
    moved = eta + of_stiffness * deta
    if of_mass or body.damping.nnz:
        moved = moved + body.held_factors.solve(of_mass * (body.free_mass @ deta) + body.damping @ deta)
    found = found + body.stiffness[k:, :k] @ moved
    for load in substructure.field_loads:
        found = found - load.forces(t, G.A_NF, eta_all, state)[2][k:]
    return np.asarray(found)
