"""Rigid bodies: mass, centre of mass, inertia, and checks that they are physically possible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kanefe.errors import ModelError
from kanefe.frames import numbers, skew


@dataclass(frozen=True, eq=False)
class RigidMass:
    """Mass properties of a rigid body.

    Attributes
    ----------
    mass : float
        kg.
    com : ndarray, shape (3,)
        Centre of mass from the origin of the body's frame, in its components, m.
    inertia : ndarray, shape (3, 3)
        About the centre of mass, kg m2.
    rotor : ndarray, shape (3,)
        Angular momentum of rotors by their spin relative to the body, in its components, kg m2/s.
    is_as_given : bool
        Whether the inertia is taken from a file unchecked, even if it is not physically possible.
    """

    mass: float
    com: np.ndarray
    inertia: np.ndarray
    rotor: np.ndarray = field(default_factory=lambda: np.zeros(3))
    is_as_given: bool = False

    @property
    def spatial(self) -> np.ndarray:
        """Generalised mass about the origin of the frame, (6, 6): translation first."""
        c = skew(self.com)
        full = np.zeros((6, 6))
        full[:3, :3] = self.mass * np.eye(3)
        full[3:, :3] = self.mass * c
        full[:3, 3:] = -self.mass * c
        full[3:, 3:] = self.inertia - self.mass * c @ c
        return full


NO_MOMENT = 1e-12
"""Principal moment, relative to the largest, below which it is zero."""


def rigid_mass(name: str, mass: float, inertia: object, com: Sequence[float]) -> RigidMass:
    """Return checked mass properties.

    Parameters
    ----------
    name : str
        Name of the body, for messages.
    mass : float
        kg, zero or more.
    inertia : float, (3,) or (3, 3)
        About the centre of mass, kg m2: one number for all axes, the diagonal, or the matrix. ``(0, 0, I)`` is enough
        for bodies that rotate about z only.
    com : array_like, shape (3,)
        m.

    Raises
    ------
    ModelError
        If the mass is negative, or the inertia is not symmetric, not positive or breaks the triangle inequality.
    """
    if numbers(mass).shape != () or not (np.isfinite(numbers(mass)) and mass >= 0):
        raise ModelError(f"mass of body {name!r} must be finite and >= 0 kg, not {mass!r}")
    center = numbers(com)
    if center.shape != (3,) or not np.isfinite(center).all():
        raise ModelError(f"com of body {name!r} must be three finite numbers in m, not {com!r}")
    array = numbers(inertia)
    is_diagonal = array.shape in ((), (3,))
    if is_diagonal:
        array = np.eye(3) * array
    if array.shape != (3, 3) or not np.isfinite(array).all():
        raise ModelError(f"inertia of body {name!r} must be one number, three or a 3 x 3 matrix, not {inertia!r}")
    largest = abs(array).max()
    if abs(array - array.T).max() > 1e-9 * largest:
        raise ModelError(f"inertia of body {name!r} is not symmetric. Remedy: pass 0.5 * (I + I.T) if that is meant")
    moments = sorted(array.diagonal().tolist()) if is_diagonal else np.linalg.eigvalsh(array).tolist()
    if moments[0] < -1e-12 * largest:
        raise ModelError(
            f"inertia of body {name!r} has a negative principal moment ({moments[0]:.6g} kg m2). "
            "Remedy: moments about the centre of mass"
        )
    # the tolerance accepts round-off in exports of CAD programs, but not a wrong column
    is_planar = moments[1] <= NO_MOMENT * moments[2]  # (0, 0, I): freezing checks that it stays in its plane
    if not is_planar and moments[2] > (moments[0] + moments[1]) * (1 + 1e-6) + 1e-12 * largest:
        raise ModelError(
            f"inertia of body {name!r} breaks the triangle inequality: principal moments {moments[0]:.6g}, "
            f"{moments[1]:.6g}, "
            f"{moments[2]:.6g} kg m2, and no mass distribution has one larger than the sum of the others. "
            "Remedy: check units and that it is taken about the centre of mass"
        )
    if mass == 0 and largest > 0:
        raise ModelError(f"body {name!r} has inertia but no mass. Remedy: give it a mass, or no inertia")
    return RigidMass(float(mass), center, 0.5 * (array + array.T))
