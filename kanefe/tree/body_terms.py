"""What the equations need of each body: its place in the tree, its joint, and where its coordinates and speeds are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from kanefe.bodies.rigid import RigidMass
from kanefe.joints import Joint

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
    from kanefe.bodies.mass_moments import MassMoments
    from kanefe.bodies.nodal_moments import NodalMoments
    from kanefe.bodies.unreduced import UnreducedBody
    from kanefe.loads.field_load import FieldLoad
    from kanefe.loads.joint_load import JointLoad
    from kanefe.loads.point_load import PointLoad


@dataclass(frozen=True, eq=False)
class FlexibleTerms:
    """What the equations need of a flexible body, decided at freeze.

    Attributes
    ----------
    body : FlexibleBody
    free_moments, all_moments : MassMoments or NodalMoments
        Of the free coordinates, and of all (for coupling forces).
    damping : ndarray or None, shape (K, k)
        C of the deformation rate over all rows; None: undamped. The rows of fixed components carry what the structure
        hands on statically, K_cf K_ff^-1 C_ff, so that damping is internal: it has no resultant.
    eta : slice
        Of the coordinates q.
    speeds : slice
        Of the free speeds.
    fixed : slice
        Of all speeds.
    fixed_rigid : ndarray, shape (6, fixed)
        Motion of G (translation, rotation) that goes with unit motion of each fixed component.
    fixed_elastic : ndarray, shape (K, fixed)
        Coordinates that go with it. Together they are the constraint mode at zero deformation; the rigid share turns
        the *deformed* body, so that coupling forces balance the body exactly and not only to first order.
    """

    body: FlexibleBody
    free_moments: MassMoments | NodalMoments
    all_moments: MassMoments | NodalMoments
    damping: np.ndarray | None
    eta: slice
    speeds: slice
    fixed: slice
    fixed_rigid: np.ndarray
    fixed_elastic: np.ndarray


@dataclass(frozen=True, eq=False)
class BodyTerms:
    """One body of the tree with its joint.

    Attributes
    ----------
    name : str
    parent : int
        Index of the parent body, -1 for N.
    parent_interface : InterfaceFrame or None
        The frame of a flexible parent that carries this body.
    p_PoFo_P, A_PF : ndarray
        Where the joint's fixed frame F sits in the parent frame P, m.
    joint : Joint
    coordinates : ndarray of int
        Where each coordinate of the joint is in q; -1: it is driven.
    speeds : ndarray of int
        Where each speed of the joint is among all speeds.
    rigid : RigidMass or None
    flexible : FlexibleTerms or None
    loads : tuple of (PointLoad, InterfaceFrame or None)
    joint_loads : tuple of JointLoad
    field_loads : tuple of FieldLoad
        On surfaces and lines of a flexible body.
    has_gravity : bool
        Whether gravity acts on it.
    """

    name: str
    parent: int
    parent_interface: InterfaceFrame | None
    p_PoFo_P: np.ndarray
    A_PF: np.ndarray
    joint: Joint
    coordinates: np.ndarray
    speeds: np.ndarray
    rigid: RigidMass | None
    flexible: FlexibleTerms | None
    loads: tuple[tuple[PointLoad, InterfaceFrame | None], ...]
    joint_loads: tuple[JointLoad, ...]
    field_loads: tuple[FieldLoad, ...] = ()
    has_gravity: bool = True

    @property
    def interfaces(self) -> tuple[InterfaceFrame, ...]:
        """Its interfaces; none of a rigid body."""
        return () if self.flexible is None else tuple(self.flexible.body.interfaces)

    @property
    def exchanges_energy(self) -> bool:
        """Whether loads or damping give energy to the body or take it."""
        is_damped = self.flexible is not None and self.flexible.damping is not None
        return bool(self.loads or self.joint_loads or self.field_loads or is_damped) or any(
            force is not None and force.is_dissipative for force in self.joint.coordinate_forces
        )

    @property
    def has_coordinate_forces(self) -> bool:
        """Whether springs, dampers or limits act along coordinates of the joint."""
        return any(force is not None and force.acts for force in self.joint.coordinate_forces)

    @property
    def is_driven(self) -> bool:
        """Whether a coordinate of the joint is a given function of time."""
        return any(motion is not None for motion in self.joint.motions)

    @property
    def driven(self) -> tuple[int, ...]:
        """Which coordinates of the joint are given functions of time."""
        return tuple(i for i, motion in enumerate(self.joint.motions) if motion is not None)

    def joint_coordinates(self, t: float, q: np.ndarray) -> np.ndarray:
        """Return the coordinates of the joint: of the state, or of their motions in time."""
        if not self.is_driven:
            return q[self.coordinates]
        pairs = zip(self.joint.motions, self.coordinates, strict=True)
        return np.array([q[at] if motion is None else motion.at("position", t, self.name) for motion, at in pairs])

    def free_coordinates(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices into q and into the free speeds of what is not driven; one for one where some are."""
        if not self.is_driven:
            return self.coordinates, self.speeds
        is_free = self.coordinates >= 0
        return self.coordinates[is_free], self.speeds[is_free]


def is_unreduced(body: FlexibleBody) -> TypeGuard[UnreducedBody]:
    """Whether a body has all degrees of freedom of its mesh, in sparse matrices, without importing its class."""
    return not isinstance(body.stiffness, np.ndarray)
