"""Laminates as one solid material: the effective moduli of a stack of bonded plies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.materials.damping import refuse_losses
from kanefe_fem.materials.oriented import SolidMaterial, axes_at_angle
from kanefe_fem.materials.voigt import IN_PLANE, check_numbers, rotated

ACROSS = (2, 3, 4)
"""Indices of the stresses zz, yz, xz that act between plies."""


@dataclass(frozen=True)
class Ply:
    """One layer of a laminate.

    Parameters
    ----------
    material : SolidMaterial
        In the ply's axes: 1 along the fibres, 3 across the ply.
    thickness : float
        In m, > 0.
    angle : float
        From the laminate's axis 1 to the fibres, about its normal 3, in rad.

    Raises
    ------
    ModelError
        If the material is not one, the thickness is not positive, or the angle is not finite.
    """

    material: SolidMaterial
    thickness: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.material, SolidMaterial):
            raise ModelError(f"ply: {self.material!r} is not a material. Remedy: Orthotropic(...), Material(...)")
        label = f"ply of {self.material.name!r}" if self.material.name else "ply"
        thickness = check_numbers(label, ("thickness",), (self.thickness,), "give it in m")[0]
        object.__setattr__(self, "thickness", thickness)
        if numbers(self.angle).shape != () or not np.isfinite(numbers(self.angle)):
            raise ModelError(f"{label}: angle = {self.angle!r} is not finite. Remedy: give it in rad")
        refuse_losses(self.material, label, "a group of cells for each ply, or damping= of the body")
        object.__setattr__(self, "angle", float(self.angle))


@checked
@dataclass(frozen=True)
class Laminate:
    """Stack of bonded plies as one homogeneous material, axis 3 across the plies.

    Parameters
    ----------
    plies : sequence of Ply
        From bottom to top.
    name : str, optional
        Used in messages only.

    Raises
    ------
    ModelError
        If there is no ply.

    Notes
    -----
    Strains in the plane (i) and stresses across it (o) are the same in all plies. From the averages of the others over
    the thickness, with ``A = <C_oo^-1>``, ``B = <C_oo^-1 C_oi>`` and ``Q = <C_ii - C_io C_oo^-1 C_oi>``,

        ``C*_oo = A^-1,   C*_oi = A^-1 B,   C*_ii = Q + B^T A^-1 B``

    (Pagano, J. Composite Materials 8 (1974) 225; Sun & Li, J. Composite Materials 22 (1988) 629). It is exact for
    strains that vary slowly over the whole stack. The order of the plies is lost: the bending stiffness of a stack as
    thick as the body is wrong, since outer and inner plies have the same weight. Remedy: several stacks through the
    thickness, or a group of cells for each ply (or for each side of a sandwich) with its own `Oriented` material.

    Examples
    --------
    >>> from kanefe_fem.materials.orthotropic import Orthotropic
    >>> carbon = Orthotropic.transversely_isotropic(E1=140e9, E2=9e9, nu12=0.3, nu23=0.4, G12=5e9, rho=1600.0)
    >>> skin = Laminate([Ply(carbon, 0.25e-3, np.radians(a)) for a in (0, 45, -45, 90)])
    """

    plies: Sequence[Ply]
    name: str | None = None

    def __post_init__(self) -> None:
        plies = tuple(self.plies)
        if not plies or not all(isinstance(ply, Ply) for ply in plies):
            raise ModelError(f"laminate: plies={self.plies!r}. Remedy: at least one Ply(material, thickness, angle)")
        object.__setattr__(self, "plies", plies)

    @property
    def thickness(self) -> float:
        """Thickness of the stack in m."""
        return sum(ply.thickness for ply in self.plies)

    @property
    def rho(self) -> float:
        """Mean density in kg/m3."""
        return sum(ply.thickness * ply.material.rho for ply in self.plies) / self.thickness

    @property
    def stiffness(self) -> np.ndarray:
        """Effective stresses from strains in the laminate's axes, shape (6, 6), Pa."""
        A, B, Q = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
        for ply in self.plies:
            share = ply.thickness / self.thickness
            C = rotated(ply.material.stiffness, axes_at_angle(ply.angle))
            oo, oi, ii = C[np.ix_(ACROSS, ACROSS)], C[np.ix_(ACROSS, IN_PLANE)], C[np.ix_(IN_PLANE, IN_PLANE)]
            soft = np.linalg.inv(oo)
            A += share * soft
            B += share * soft @ oi
            Q += share * (ii - oi.T @ soft @ oi)
        stiff = np.linalg.inv(A)
        effective = np.zeros((6, 6))
        effective[np.ix_(ACROSS, ACROSS)] = stiff
        effective[np.ix_(ACROSS, IN_PLANE)] = stiff @ B
        effective[np.ix_(IN_PLANE, ACROSS)] = (stiff @ B).T
        effective[np.ix_(IN_PLANE, IN_PLANE)] = Q + B.T @ stiff @ B
        return np.asarray(0.5 * (effective + effective.T))

    def describe(self) -> dict[str, object]:
        """Return the plies (json-able)."""
        plies = [
            {"material": p.material.describe(), "thickness_m": p.thickness, "angle_rad": p.angle} for p in self.plies
        ]
        return {"kind": "laminate", "plies": plies, "name": self.name}
