"""Coupling forces F_u between flexible bodies and the frames that carry them (Eq. 31-34, 39).

Two forms of the same equations: the paper's, in which {du, F_u} are solved together with the rows du = 0 of the fixed
interface components; and the elimination, in which those rows are deleted and F_u is the residual of the deleted
rows, computed only when asked for. Driving forces of given motions are residuals in the same way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kanefe.frames import Matrix, Vector, skew
from kanefe.kane.assemble import equations
from kanefe.kane.contact_shares import constraint_forces
from kanefe.states.interactions import unit_wrenches
from kanefe.states.kinematics import FrameMotion, interface_motion
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame
    from kanefe.states.state import State


def coupling_matrix(A_RG: Matrix, positions_R: list[Vector], wrenches_G: list[Matrix]) -> Matrix:
    """Return [R<-G] of Eq. 34: wrench about R's origin from the nodal coupling forces, shape (6, forces).

    R feels its negative (Eq. 31-33).

    Parameters
    ----------
    A_RG : ndarray, shape (3, 3)
        From the axes of G to those of R.
    positions_R : list of ndarray
        Position of each interface from R's origin in components of R, m.
    wrenches_G : list of ndarray, shape (6, forces of the interface)
        Force and moment in axes of G of each unit coupling force: see `unit_wrenches`. The paper's columns of released
        components are zero; here they are left out: a hinge has no moment columns.
    """
    blocks = [np.zeros((6, 0))]
    for r, wrench in zip(positions_R, wrenches_G, strict=True):
        force, moment = A_RG @ wrench[:3], A_RG @ wrench[3:]
        blocks.append(np.vstack((force, skew(r) @ force + moment)))
    return np.hstack(blocks)


def carrier_frame(state: State, body: BodyTerms, terms: FlexibleTerms, G: FrameMotion) -> FrameMotion:
    """Return the frame R in which G is fixed.

    It is at the centre of mass of a rigid parent that G is fixed to, as in the paper; else it is the moving frame of
    the joint, which coincides with G and has no part in the motion of the fixed components.
    """
    rigid = state.model.bodies[body.parent].rigid if body.parent >= 0 and body.joint.is_fixed else None
    if rigid is None:
        V, W = G.V.copy(), G.W.copy()
        V[:, terms.fixed] = W[:, terms.fixed] = 0.0
        return FrameMotion(G.A_NF, G.p_NoFo_N, G.v, G.w, V, W, G.Z, G.Y)
    R = state.motions[body.parent]
    V, Z = R.shifted(rigid.com)
    p = R.p_NoFo_N + R.A_NF @ rigid.com
    return FrameMotion(R.A_NF, p, R.v, R.w, V, R.W, Z, R.Y)


def coupling_force_columns(state: State, body: BodyTerms, terms: FlexibleTerms) -> Matrix:
    """Return the generalised forces of unit coupling forces of one body, shape (columns, forces) (Eq. 35, 39).

    ``V^n^T - [V^T W^T] [R<-G]``: F_u acts on the interface nodes and, reversed, on R. In the coordinates of the chain
    the two cancel on every speed but the fixed ones.
    """
    model = state.model
    G = state.motions[model.index(body.name)]
    R = carrier_frame(state, body, terms, G)
    A_RG = R.A_NF.T @ G.A_NF
    columns, positions, wrenches = [], [], []
    for frame in fixed_interfaces(terms):
        n = interface_motion(G, frame, terms, state.q, state.full, model.slopes)
        A_Gn = G.A_NF.T @ n.A_NF
        theta = frame.moved(state.q[terms.eta])[0][3:]
        wrench = unit_wrenches(frame.fixed_components, model.slopes.tangent(theta), frame.axes)
        columns.append(np.vstack((A_Gn @ n.V, A_Gn @ n.W)).T @ wrench)
        positions.append(R.A_NF.T @ (n.p_NoFo_N - R.p_NoFo_N))
        wrenches.append(wrench)
    reaction = np.hstack((R.V.T, R.W.T)) @ coupling_matrix(A_RG, positions, wrenches)
    return np.hstack(columns) - reaction


def fixed_interfaces(terms: FlexibleTerms) -> list[InterfaceFrame]:
    """Return the interfaces of a body that have components fixed in G."""
    return [frame for frame in terms.body.interfaces if frame.fixed_components]


def _all_coupling_force_columns(state: State) -> Matrix:
    """Return the generalised forces of unit coupling forces of all bodies, shape (columns, fixed)."""
    model = state.model
    start = model.free_count + model.driven_count
    B = np.zeros((start + model.fixed_count, model.fixed_count))
    for body in model.bodies:
        if body.flexible is not None and body.flexible.body.fixed_count:
            where = slice(body.flexible.fixed.start - start, body.flexible.fixed.stop - start)
            B[:, where] = coupling_force_columns(state, body, body.flexible)
    return B


def accelerations_and_coupling_forces(state: State) -> tuple[Vector, Vector]:
    """Return du (free,) and F_u (fixed,) solved together, as the paper has it (Eq. 39 with rows du = 0).

    F_u are the forces (N) and moments (N m) on the flexible bodies at their fixed interface components, along the axes
    of the interfaces (for moments beside finite released slopes see `unit_wrenches`).
    """
    model, wide = state.model, state.wide
    M, F = equations(wide)
    F = F + constraint_forces(wide, state)
    B = _all_coupling_force_columns(wide)
    start = model.free_count + model.driven_count
    free, driven, fixed = model.free_count, model.driven_count, model.fixed_count
    unknown = np.r_[:free, start : start + fixed]
    system = np.zeros((free + 2 * fixed, free + 2 * fixed))
    right = np.zeros(free + 2 * fixed)
    system[: free + fixed, : free + fixed] = M[np.ix_(unknown, unknown)]
    system[: free + fixed, free + fixed :] = -B[unknown]
    system[free + fixed :, free : free + fixed] = np.eye(fixed)  # the fixed components have no acceleration in G
    right[: free + fixed] = F[unknown] - M[unknown, free : free + driven] @ state.driven_rates
    solution = np.linalg.solve(system, right)
    return solution[:free], solution[free + fixed :]


def recovered_forces(state: State, du: Vector) -> tuple[Vector, Vector]:
    """Return driving forces (driven,) and coupling forces F_u (fixed,) from the residuals of their rows.

    Parameters
    ----------
    state : State
    du : ndarray, shape (free,)
        Accelerations of the free speeds at this state.
    """
    model, wide = state.model, state.wide
    known = model.free_count + model.driven_count
    M, F = equations(wide)
    F = F + constraint_forces(wide, state)
    residual = M[model.free_count :, :known] @ np.concatenate((du, state.driven_rates)) - F[model.free_count :]
    driving, fixed = residual[: model.driven_count], residual[model.driven_count :]
    if not model.fixed_count:
        return driving, fixed
    # The identity at zero deformation. A partly released interface moves off its undeformed place and turns, and its
    # forces act where it is.
    B = _all_coupling_force_columns(wide)[known:]
    return driving, np.asarray(np.linalg.solve(B, fixed))
