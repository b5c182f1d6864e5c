"""The frozen scene: immutable tables that the equations read, and the layout of the state.

All speeds of the scene are numbered: first the free ones (body by body: joint speeds, then elastic speeds), then
the driven joint speeds, then the interface components fixed in G. The equations are assembled over as many of them as
the question needs; the rows of driven and fixed speeds give driving and coupling forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kanefe.errors import ModelError
from kanefe.flexible import FlexibleBody, InterfaceFrame
from kanefe.joints import Joint
from kanefe.loads import JointLoad, PointLoad
from kanefe.mass_moments import MassMoments
from kanefe.nodal_moments import NodalMoments
from kanefe.rigid import RigidMass
from kanefe.slopes import SlopeMeasure


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
    coordinates : slice
        Of q (empty if driven).
    speeds : slice
        Of all speeds.
    rigid : RigidMass or None
    flexible : FlexibleTerms or None
    loads : tuple of (PointLoad, InterfaceFrame or None)
    joint_loads : tuple of JointLoad
    """

    name: str
    parent: int
    parent_interface: InterfaceFrame | None
    p_PoFo_P: np.ndarray
    A_PF: np.ndarray
    joint: Joint
    coordinates: slice
    speeds: slice
    rigid: RigidMass | None
    flexible: FlexibleTerms | None
    loads: tuple[tuple[PointLoad, InterfaceFrame | None], ...]
    joint_loads: tuple[JointLoad, ...]

    @property
    def exchanges_energy(self) -> bool:
        """Whether loads or damping give energy to the body or take it."""
        is_damped = self.flexible is not None and self.flexible.damping is not None
        return bool(self.loads or self.joint_loads or is_damped or self.joint.stiffness_and_damping[1])

    @property
    def has_spring(self) -> bool:
        """Whether a spring or damper acts across the joint."""
        return any(self.joint.stiffness_and_damping)

    def joint_coordinates(self, t: float, q: np.ndarray) -> np.ndarray:
        """Return the coordinates of the joint: of the state, or of its motion in time."""
        if self.joint.motion is None:
            return q[self.coordinates]
        return np.array([self.joint.motion.at("position", t, self.name)])

    @property
    def is_driven(self) -> bool:
        """Whether the joint's coordinate is a given function of time."""
        return self.joint.motion is not None


@dataclass(frozen=True, eq=False)
class Model:
    """A frozen scene.

    Attributes
    ----------
    bodies : tuple of BodyTerms
        Parents before children.
    gravity : ndarray, shape (3,)
        In N, m/s2.
    slopes : SlopeMeasure
    coordinate_count, free_count, driven_count, fixed_count : int
        Sizes of q and of the three kinds of speeds.
    initial_coordinates, initial_speeds : ndarray
        q (coordinates,) and free speeds u (free,) at the start.
    """

    bodies: tuple[BodyTerms, ...]
    gravity: np.ndarray
    slopes: SlopeMeasure
    coordinate_count: int
    free_count: int
    driven_count: int
    fixed_count: int
    initial_coordinates: np.ndarray
    initial_speeds: np.ndarray

    def __post_init__(self) -> None:
        for array in (self.gravity, self.initial_coordinates, self.initial_speeds):
            array.flags.writeable = False

    @property
    def has_power(self) -> bool:
        """Whether loads, drives or damping exchange energy, so that their work must be integrated."""
        return self.driven_count > 0 or any(body.exchanges_energy for body in self.bodies)

    def index(self, name: str) -> int:
        """Return the number of the body called `name`; raise a ModelError that lists the names."""
        for number, body in enumerate(self.bodies):
            if body.name == name:
                return number
        raise ModelError(f"the scene has no body called {name!r}. It has: {', '.join(b.name for b in self.bodies)}")

    def flexible_terms(self, name: str) -> FlexibleTerms:
        """Return the terms of a flexible body by name; raise a ModelError if it is rigid."""
        terms = self.bodies[self.index(name)].flexible
        if terms is None:
            raise ModelError(f"body {name!r} is rigid: it has no modal coordinates, mesh or interfaces")
        return terms

    def coordinate_names(self) -> tuple[str, ...]:
        """Return a name for every coordinate of q."""
        names = []
        for body in self.bodies:
            if not body.is_driven:
                names += [f"{body.name}: {name}" for name in body.joint.coordinate_names]
            if body.flexible:
                names += [f"{body.name}: eta {i}" for i in range(body.flexible.body.free_count)]
        return tuple(names)

    def advance(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return q moved by `step`, a vector in the directions of the free speeds times a time."""
        moved = np.empty_like(q)
        for body in self.bodies:
            if not body.is_driven:
                moved[body.coordinates] = body.joint.advance(q[body.coordinates], step[body.speeds])
            if body.flexible:
                moved[body.flexible.eta] = q[body.flexible.eta] + step[body.flexible.speeds]
        return moved

    def coordinate_rates(self, q: np.ndarray, u: np.ndarray) -> np.ndarray:
        """Return dq/dt from the free speeds."""
        rates = np.empty_like(q)
        for body in self.bodies:
            if not body.is_driven:
                rates[body.coordinates] = body.joint.coordinate_rates(q[body.coordinates], u[body.speeds])
            if body.flexible:
                rates[body.flexible.eta] = u[body.flexible.speeds]
        return rates

    def driven_speeds(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the driven joint speeds and their rates at time t, each (driven,)."""
        driven = [(b.joint.motion, b.name) for b in self.bodies if b.joint.motion is not None]
        speeds = np.array([motion.at("velocity", t, name) for motion, name in driven])
        return speeds, np.array([motion.at("acceleration", t, name) for motion, name in driven])
