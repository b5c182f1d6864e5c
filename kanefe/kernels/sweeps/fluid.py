"""A fluid around a flexible body: Kirchhoff's equations, by an added mass that is constant in G (Eq. 12, 37, 38).

Its equations are those of `kanefe.bodies.wet_moments`. The mass of the modes has the fluid already.
"""

from kanefe.kernels.bodies import ModalBody
from kanefe.kernels.language import Vector, congruent, cross, dot, inlined, kernel
from kanefe.kernels.sweeps.body_inertia import first_moment
from kanefe.kernels.sweeps.elastic import combination
from kanefe.kernels.tree import Frame


@kernel
def add_fluid(body: ModalBody, frame: Frame, fall: Vector) -> None:
    """Add the fluid to inertia and force of the link of a body, and to coupling and forces of its modes.

    It has no weight: `fall`, the gravity that is part of Z, is taken from its acceleration.
    """
    G, M, H, J, deta = frame.R, body.fluid_mass, body.fluid_lever, body.fluid_inertia, body.deta
    v, w, alpha = G.T @ frame.v, G.T @ frame.w, G.T @ frame.Y
    a = G.T @ (frame.Z + fall) - cross(w, v)  # dv/dt in G
    P = M @ v + H @ w + combination(body.fluid_linear, deta)
    L = H.T @ v + J @ w + combination(body.fluid_angular, deta)
    force = M @ a + H @ alpha + cross(w, P)
    moment = H.T @ a + J @ alpha + cross(w, L) + cross(v, P)
    frame.M += congruent(G, M)
    frame.H += G @ H @ G.T
    frame.J += congruent(G, J)
    frame.f += G @ force
    frame.n += G @ moment
    _couple_fluid(body, a, alpha)


@kernel
def _couple_fluid(body: ModalBody, a: Vector, alpha: Vector) -> None:
    """Add what the fluid does between G and the modes: the modes meet it, and it is moved by their rates."""
    p, linear, angular = body.p, body.linear, body.angular
    own, turning = body.fluid_linear, body.fluid_angular
    for i in range(len(p)):
        p[i] -= dot(a, own[i]) + dot(alpha, turning[i])
        linear[i] += own[i]
        angular[i] += turning[i]


@inlined
def weighed(body: ModalBody, frame: Frame) -> Vector:
    """Return mass times centre of mass of a body without its fluid, from N's origin, before anything is eliminated."""
    lever = frame.R @ body.fluid_lever @ frame.R.T
    return body.mass * frame.p + first_moment(frame.H - lever)
