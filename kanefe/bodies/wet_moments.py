"""Inertia of a body with the fluid around it: an added mass that turns with the mesh frame G (Kirchhoff 1870).

A fluid at rest far away adds the kinetic energy ``1/2 V^T A V``, with ``V = (v, w, deta)`` the velocity of G's origin
and the angular velocity of G, in components of G, and the rates of the coordinates. A is that of the undeformed shape:
it is constant in G, but not the same in all directions. With the impulse ``P = A V = (P_v, P_w, P_eta)``, Lagrange's
equations in these quasi-velocities are Kirchhoff's, with elastic coordinates:

    force  = dP_v/dt + w x P_v,     moment = dP_w/dt + w x P_w + v x P_v,     elastic = dP_eta/dt

so that the energy of body and fluid is conserved, and their impulse where no force acts. ``v x P_v`` is Munk's moment,
which turns a slender body across its way; of the mass of the body itself, the same in all directions, it is zero. Fluid
that is added has no weight: gravity does not act on A, and buoyancy is a load. (Lamb, Hydrodynamics, 1932, art. 124.)
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from kanefe.bodies.mass_moments import MassMoments
from kanefe.frames import Matrix, Vector, cross


@dataclass(frozen=True, eq=False)
class WetMoments(MassMoments):
    """Mass moments of a body, and the added mass of the fluid around it.

    `mass`, `first` and `second`, and with them weight, centre of mass and inertia, are those of the body alone; the
    mass of its coordinates, and with it the frequencies, includes the fluid.

    Attributes
    ----------
    fluid : ndarray, shape (6 + K, 6 + K)
        A of (translation of G, rotation of G, coordinates), in kg, kg m and kg m2; symmetric.
    """

    fluid: np.ndarray = field(kw_only=True)

    @classmethod
    def around(cls, dry: MassMoments, fluid: np.ndarray) -> WetMoments:
        """Return the moments of a body with those of its own, and an added mass (6 + K, 6 + K)."""
        own = {f.name: getattr(dry, f.name) for f in fields(MassMoments)}
        return cls(**own, fluid=np.ascontiguousarray(fluid))

    @property
    def elastic_mass(self) -> np.ndarray:
        """Constant elastic block of the mass matrix with the fluid, shape (K, K)."""
        return np.asarray(super().elastic_mass + self.fluid[6:, 6:])

    def leading(self, count: int) -> WetMoments:
        """Return the moments of the first `count` coordinates alone."""
        return WetMoments.around(super().leading(count), self.fluid[: 6 + count, : 6 + count])

    def with_fluid(
        self, mass: Matrix, bias: Vector, deta: Vector, v: Vector, w: Vector, gravity: Vector
    ) -> tuple[Matrix, Vector]:
        """Return `MassMoments.terms` with the added mass in the rows of G, and Kirchhoff's terms.

        Parameters
        ----------
        mass, bias : ndarray
            Of `terms`, whose elastic block has the fluid already. The mass multiplies ``a_G - gravity``.
        deta : ndarray, shape (K,)
        v, w : ndarray, shape (3,)
            Velocity of G's origin (m/s) and angular velocity of G (rad/s), in components of G.
        gravity : ndarray, shape (3,)
            In components of G, m/s2.
        """
        coupling = self.fluid.copy()
        coupling[6:, 6:] = 0.0
        impulse = self.fluid[:6] @ np.concatenate((v, w, deta))
        P_v, P_w = impulse[:3], impulse[3:]
        found = bias + self.fluid[:, :3] @ (gravity - cross(w, v))  # dv/dt in G is a_G - w x v
        found[:3] += cross(w, P_v)
        found[3:6] += cross(w, P_w) + cross(v, P_v)
        return mass + coupling, found
