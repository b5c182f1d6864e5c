"""The data of each body for the equations: its place in the tree, its joint, and the indices of its coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeGuard

import numpy as np

from kanefe.bodies.rigid import RigidMass
from kanefe.joints import Joint
from kanefe.joints.motion import of_body

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
    """The data of a flexible body for the equations, computed when the scene is frozen.

    Attributes
    ----------
    body : FlexibleBody
    free_moments, all_moments : MassMoments or NodalMoments
        Moments of the free coordinates, and of all (for coupling forces).
    damping : ndarray or None, shape (K, k)
        C of the deformation rate over all rows; None: undamped. The rows of fixed components have the statically
        transferred part, K_cf K_ff^-1 C_ff, so that damping is internal: it has no resultant.
    eta : slice
        Indices of the free coordinates in q.
    speeds : slice
        Indices of their rates in the free speeds.
    fixed : slice
        Indices of the fixed components in all speeds.
    fixed_rigid : ndarray, shape (6, fixed)
        Motion of G (translation, rotation) for unit motion of each fixed component.
    fixed_elastic : ndarray, shape (K, fixed)
        Coordinates for this motion. Together they are the constraint mode at zero deformation; the rigid part rotates
        the *deformed* body, so that coupling forces balance the body exactly and not only to first order.
    given_eta, given_deta : ndarray or None, shape (k,)
        Coordinates and their rates as given for the start; None: they follow.
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
    given_eta: np.ndarray | None = None
    given_deta: np.ndarray | None = None

    @cached_property
    def transfer(self) -> np.ndarray:
        """What internal forces on the free coordinates are on the fixed ones: see `static_transfer`."""
        return static_transfer(self.body)


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
        Position (m) and orientation of the joint's fixed frame F in the parent frame P.
    joint : Joint
    coordinates : ndarray of int
        Index of each coordinate of the joint in q; -1: it is driven.
    speeds : ndarray of int
        Index of each speed of the joint among all speeds.
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
        """Its interfaces; a rigid body has none."""
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

    @cached_property
    def is_driven(self) -> bool:
        """Whether a coordinate of the joint is a given function of time."""
        return any(motion is not None for motion in self.joint.motions)

    @property
    def driven(self) -> tuple[int, ...]:
        """Numbers of the coordinates of the joint that are given functions of time."""
        return tuple(i for i, motion in enumerate(self.joint.motions) if motion is not None)

    def joint_coordinates(self, t: float, q: np.ndarray) -> np.ndarray:
        """Return the coordinates of the joint, from the state or from their motions in time."""
        if not self.is_driven:
            return q[self.coordinates]
        pairs, what = zip(self.joint.motions, self.coordinates, strict=True), of_body(self.name)
        return np.array([q[at] if motion is None else motion.at("position", t, what) for motion, at in pairs])

    def free_coordinates(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices in q and in the free speeds of what is not driven; pairwise if some coordinate is."""
        if not self.is_driven:
            return self.coordinates, self.speeds
        is_free = self.coordinates >= 0
        return self.coordinates[is_free], self.speeds[is_free]


def static_transfer(body: FlexibleBody) -> np.ndarray:
    """Return what internal forces on the free coordinates are on the fixed ones, K_cf K_ff^-1, (fixed, k)."""
    k = body.free_count
    return np.asarray(np.linalg.solve(body.stiffness[:k, :k], body.stiffness[:k, k:]).T)


def is_unreduced(body: FlexibleBody) -> TypeGuard[UnreducedBody]:
    """Return whether a body has all degrees of freedom of its mesh; does not import `UnreducedBody`."""
    return not isinstance(body.stiffness, np.ndarray)
