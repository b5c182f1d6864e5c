"""Kinematics of the chain of frames N - R - G - n (Eq. 3, 13-16 and 24-26).

Every frame carries its partial velocities V and W and its remainder accelerations Z and Y, in its own components:

    v = V u,   w = W u,   a = V du + Z,   alpha = W du + Y
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kanefe.bodies.slopes import SlopeMeasure
from kanefe.frames import Matrix, Vector, cross, skew
from kanefe.tree.body_terms import BodyTerms, FlexibleTerms
from kanefe.tree.model_data import ModelData
from kanefe.tree.placed import Placed, fixed_in, moving_in

if TYPE_CHECKING:
    from kanefe.bodies.flexible import InterfaceFrame


@dataclass(slots=True)
class FrameMotion(Placed):
    """Motion of a frame F seen from N, in components of F; `columns` speeds wide.

    Attributes
    ----------
    A_NF, p_NoFo_N, v, w : ndarray
        See `Placed`.
    V, W : ndarray, shape (3, columns)
        Partial velocities.
    Z, Y : ndarray, shape (3,)
        Remainder accelerations, m/s2 and rad/s2.
    """

    V: Matrix
    W: Matrix
    Z: Vector
    Y: Vector

    def shifted(self, p: Vector) -> tuple[Matrix, Vector]:
        """Return V and Z of the point of the frame at p (frame components, m) (Eq. 13, 15)."""
        w = self.w
        return self.V - skew(p) @ self.W, self.Z + cross(self.Y, p) + cross(w, cross(w, p))

    def turned(self, A_FM: Matrix) -> FrameMotion:
        """Return the motion of a frame M with the same origin and other axes, fixed in this one."""
        v, w, V, W, Z, Y = (A_FM.T @ part for part in (self.v, self.w, self.V, self.W, self.Z, self.Y))
        return FrameMotion(self.A_NF @ A_FM, self.p_NoFo_N, v, w, V, W, Z, Y)


@dataclass(slots=True)
class RelativeMotion:
    """Motion of a frame M seen from F, in components of F: position, rotation, rates and remainder accelerations.

    `columns` says which speeds the narrow V and W belong to.
    """

    p: Vector
    A: Matrix
    v: Vector
    w: Vector
    V: Matrix
    W: Matrix
    Z: Vector
    Y: Vector
    columns: slice | np.ndarray


def inertial_frame(columns: int, p: Vector | None = None, A: Matrix | None = None) -> FrameMotion:
    """Return the motion of N, or of a frame fixed in it at p with orientation A: none."""
    zero = np.zeros(3)
    V, W = np.zeros((3, columns)), np.zeros((3, columns))
    return FrameMotion(np.eye(3) if A is None else A, zero if p is None else p, zero, zero, V, W, zero, zero)


def compose(F: FrameMotion, relative: RelativeMotion) -> FrameMotion:
    """Return the motion of M from that of F and the motion of M seen from F (Eq. 3, 13-16).

    Differentiation of ``p_NoMo_N = p_NoFo_N + A_NF p`` with Eq. 8 gives velocities and, once more, the Coriolis and
    centripetal parts of the remainders.
    """
    p, A, w = relative.p, relative.A, F.w
    V = F.V - skew(p) @ F.W
    W = F.W.copy()
    V[:, relative.columns] += relative.V
    W[:, relative.columns] += relative.W
    At = A.T
    place = moving_in(F, p, A, relative.v, relative.w)
    return FrameMotion(
        place.A_NF,
        place.p_NoFo_N,
        place.v,
        place.w,
        V=At @ V,
        W=At @ W,
        Z=At @ (F.Z + cross(F.Y, p) + cross(w, cross(w, p) + 2.0 * relative.v) + relative.Z),
        Y=At @ (F.Y + cross(w, relative.w) + relative.Y),
    )


def placed(P: FrameMotion, p: Vector, A: Matrix) -> FrameMotion:
    """Return the motion of a frame fixed in P at p with orientation A_PF."""
    V, Z = P.shifted(p)
    At, M = A.T, fixed_in(P, p, A)
    return FrameMotion(M.A_NF, M.p_NoFo_N, M.v, M.w, At @ V, At @ P.W, At @ Z, At @ P.Y)


def joint_motion(body: BodyTerms, t: float, q: Vector, u: Vector) -> RelativeMotion:
    """Return the motion across a joint; a driven one takes position and rate from its function of time."""
    joint = body.joint
    q_joint, u_joint = body.joint_coordinates(t, q), u[body.speeds]
    p, A = joint.pose(q_joint)
    V, W = joint.partial_velocities(q_joint)
    Z, Y = joint.remainders(q_joint, u_joint)
    return RelativeMotion(p, A, V @ u_joint, W @ u_joint, V, W, Z, Y, body.speeds)


def elastic_state(terms: FlexibleTerms, q: Vector, u: Vector, is_extended: bool) -> tuple[Vector, Vector]:
    """Return eta and deta; with the fixed components, which are zero, if `is_extended`."""
    eta, deta = q[terms.eta], u[terms.speeds]
    if is_extended and terms.body.fixed_count:
        padding = np.zeros(terms.body.fixed_count)
        return np.concatenate((eta, padding)), np.concatenate((deta, padding))
    return eta, deta


def elastic_partial_rates(terms: FlexibleTerms, columns: int) -> Matrix:
    """Return the partial derivatives of deta by the speeds, shape (coordinates, columns)."""
    free = terms.body.free_count
    is_extended = columns > terms.fixed.start
    E = np.zeros((terms.body.count if is_extended else free, columns))
    E[range(free), range(terms.speeds.start, terms.speeds.stop)] = 1.0
    if is_extended:
        E[:, terms.fixed] = terms.fixed_elastic
    return E


def interface_motion(
    G: FrameMotion, frame: InterfaceFrame, terms: FlexibleTerms, q: Vector, u: Vector, slopes: SlopeMeasure
) -> FrameMotion:
    """Return the motion of an interface frame n of a flexible body (Eq. 22, 24-26)."""
    columns = G.V.shape[1]
    is_extended = columns > terms.fixed.start
    inner = frame.inner_motion(*elastic_state(terms, q, u, is_extended), slopes)
    partial = inner.motion @ elastic_partial_rates(terms, columns)
    relative = RelativeMotion(
        inner.p, inner.A, inner.v, inner.w, partial[:3], partial[3:], inner.Z, inner.Y, columns=slice(None)
    )
    return compose(G, relative)


def sweep_outward(model: ModelData, t: float, q: Vector, u: Vector, columns: int | None = None) -> list[FrameMotion]:
    """Return the motion of every body's frame (R or G), parents before children.

    Parameters
    ----------
    model : ModelData
    t : float
        s.
    q : ndarray, shape (coordinates,)
    u : ndarray, shape (all speeds,)
        Free, driven and fixed.
    columns : int, optional
        How many of the speeds the partial velocities span; default: free and driven.
    """
    columns = model.free_count + model.driven_count if columns is None else columns
    motions: list[FrameMotion] = []
    for body in model.bodies:
        if body.parent < 0:
            F = inertial_frame(columns, body.p_PoFo_P, body.A_PF)
        else:
            F = placed(parent_frame(model, body, motions, q, u), body.p_PoFo_P, body.A_PF)
        M = F if not len(body.speeds) else compose(F, joint_motion(body, t, q, u))
        if body.flexible is not None and columns > body.flexible.fixed.start:
            M.V[:, body.flexible.fixed] = body.flexible.fixed_rigid[:3]
            M.W[:, body.flexible.fixed] = body.flexible.fixed_rigid[3:]
        motions.append(M)
    return motions


def parent_frame(model: ModelData, body: BodyTerms, motions: list[FrameMotion], q: Vector, u: Vector) -> FrameMotion:
    """Return the motion of the frame that carries a body: its parent's R, or an interface n of a flexible parent."""
    parent = motions[body.parent]
    if body.parent_interface is None:
        return parent
    terms = model.bodies[body.parent].flexible
    if terms is None:
        raise TypeError("an interface belongs to a flexible body")  # the model's builder guarantees it
    return interface_motion(parent, body.parent_interface, terms, q, u, model.slopes)
