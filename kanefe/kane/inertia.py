"""Generalised inertia of rigid and flexible bodies (Eq. 12, 17, 29, 37, 38).

Each function returns the body's part of ``M_sys`` and of ``F_sys`` in ``M_sys du = F_sys``. Gravity is an acceleration
field: it is taken from the remainder acceleration of the frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.rigid import RigidMass
from kanefe.bodies.wet_moments import WetMoments
from kanefe.fe_model.model import COMPONENTS
from kanefe.frames import Matrix, Vector, cross, skew, skews
from kanefe.states.kinematics import FrameMotion, elastic_partial_rates
from kanefe.tree.body_terms import FlexibleTerms

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody


def rigid_inertia(body: RigidMass, R: FrameMotion, gravity_R: Vector) -> tuple[Matrix, Vector]:
    """Return M and F of a rigid body (Eq. 12, 17, 20, 37), about its centre of mass.

    The paper prints the gyroscopic moment as ``w~ I w~``; it is ``w~ I w``. Rotors add ``w x h``.
    """
    V, Z = R.shifted(body.com)
    w = R.w
    M = body.mass * (V.T @ V) + R.W.T @ body.inertia @ R.W
    F = -body.mass * (V.T @ (Z - gravity_R)) - R.W.T @ (body.inertia @ R.Y + cross(w, body.inertia @ w + body.rotor))
    return M, F


def rigid_masses(bodies: Sequence[tuple[RigidMass, FrameMotion]]) -> Matrix | None:
    """Return M of all rigid bodies of a scene at once, the sum of those of `rigid_inertia`; None of none."""
    if not bodies:
        return None
    columns = bodies[0][1].V.shape[1]
    if not columns:  # driven all through
        return np.zeros((0, 0))
    W = np.array([R.W for _, R in bodies])
    V = np.array([R.V for _, R in bodies]) - np.array([skew(body.com) for body, _ in bodies]) @ W
    moved = np.array([body.mass for body, _ in bodies])[:, None, None] * V
    turned = np.array([body.inertia for body, _ in bodies]) @ W
    V, W, moved, turned = (part.reshape(-1, columns) for part in (V, W, moved, turned))
    return np.asarray(V.T @ moved + W.T @ turned)


def body_partial_velocities(terms: FlexibleTerms, G: FrameMotion) -> Matrix:
    """Return the partial velocities of (translation of G, rotation of G, eta), shape (6 + coordinates, columns)."""
    return np.vstack((G.V, G.W, elastic_partial_rates(terms, G.V.shape[1])))


def inertia_in_frame(
    terms: FlexibleTerms, G: FrameMotion, gravity_G: Vector, eta: Vector, deta: Vector
) -> tuple[Matrix, Vector]:
    """Return mass and bias of a flexible body: ``mass (a_G - gravity, alpha, ddeta) + bias`` is what moves it (Eq. 38).

    Rows are (translation of G, rotation of G, coordinates), in components of G; those of a fluid around it included.
    """
    moments = terms.free_moments if len(eta) == terms.body.free_count else terms.all_moments
    mass, bias = moments.terms(eta, deta, G.w)
    if isinstance(moments, WetMoments):
        return moments.with_fluid(mass, bias, deta, G.v, G.w, gravity_G)
    return mass, bias


def flexible_inertia(
    terms: FlexibleTerms, G: FrameMotion, gravity_G: Vector, eta: Vector, deta: Vector
) -> tuple[Matrix, Vector]:
    """Return M and F of a flexible body from its mass moments (Eq. 12, 20, 38), summed over the mesh once."""
    mass, bias = inertia_in_frame(terms, G, gravity_G, eta, deta)
    J = body_partial_velocities(terms, G)
    weighted = J.T @ mass
    return weighted @ J, -(weighted[:, :3] @ (G.Z - gravity_G) + weighted[:, 3:6] @ G.Y + J.T @ bias)


def nodal_partial_velocities(
    body: FlexibleBody, J: Matrix, G: FrameMotion, eta: Vector, deta: Vector
) -> tuple[Matrix, Vector]:
    """Return V^n and Z_n of all mass points or nodes (Eq. 24-26), in components of G.

    Rows are the translations of every mass point; in the nodal form they are the components of every node, with
    ``Y_n = Y_G + w x dtheta`` for the rotations.
    """
    count = len(eta)
    basis = body.inertia_basis[:, :count]
    components = ("x", "y", "z") if body.is_exact else body.components
    rows = [COMPONENTS.index(c) for c in components]
    points = len(body.inertia_points)
    full = np.zeros((points, 6, count))
    full[:, rows] = basis.reshape(points, len(components), count)
    psi, slope = full[:, :3], full[:, 3:]
    r = body.inertia_points + psi @ eta
    dr = psi @ deta
    w2 = skew(G.w) @ skew(G.w)
    V = np.zeros((points, 6, J.shape[1]))
    V[:, :3] = G.V + psi @ J[6:] - np.einsum("jab,bc->jac", skews(r), G.W)
    V[:, 3:] = G.W + slope @ J[6:]
    Z = np.zeros((points, 6))
    Z[:, :3] = G.Z + np.cross(G.Y, r) + r @ w2.T + 2.0 * np.cross(G.w, dr)
    Z[:, 3:] = G.Y + np.cross(G.w, slope @ deta)
    return V[:, rows].reshape(points * len(rows), -1), Z[:, rows].ravel()


def flexible_inertia_from_nodes(
    terms: FlexibleTerms, G: FrameMotion, gravity_G: Vector, eta: Vector, deta: Vector
) -> tuple[Matrix, Vector]:
    """Return M and F of a flexible body from V^n and Z_n of all its nodes: Eq. 38 as written, the oracle."""
    body = terms.body
    V, Z = nodal_partial_velocities(body, body_partial_velocities(terms, G), G, eta, deta)
    if body.is_exact:
        Z = Z - np.tile(gravity_G, len(body.inertia_points))
        points = len(body.inertia_points)
        weighted = (body.inertia_mass @ V.reshape(points, -1)).reshape(V.shape)
    else:
        field = np.zeros((len(body.nodes), len(body.components)))
        for column, component in enumerate(body.components):
            if component in ("x", "y", "z"):
                field[:, column] = gravity_G[COMPONENTS.index(component)]
        Z = Z - field.ravel()
        weighted = body.inertia_mass @ V
    return V.T @ weighted, -(weighted.T @ Z)
