"""Sections of shells: membrane, coupling, bending and shear stiffness and mass of a homogeneous or layered thickness.

First-order shear theory: strains ``e + z k`` through the thickness, plane stress in each layer, transverse shear
strains constant and weighed by a shear correction. Matrices are given per power of the thickness t,

    ``A = t A1,  B = t^2 B1,  D = t^3 D1,  S = t S1``,

so that they also hold where the thickness varies (Reddy, Mechanics of Laminated Composite Plates and Shells, ch. 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kanefe_fem.materials.laminate import Laminate
from kanefe_fem.materials.oriented import SolidMaterial, axes_at_angle
from kanefe_fem.materials.strengths import strengths_of
from kanefe_fem.materials.voigt import IN_PLANE, plane_stress, rotated

ACROSS = (4, 3)
"""Voigt indices of the transverse shears 13 and 23, in the order of the axes 1 and 2."""


@dataclass(frozen=True, eq=False)
class Layer:
    """One layer between two heights, as fractions of the thickness from the surface of the nodes.

    Attributes
    ----------
    bottom, top : float
    plane : ndarray, shape (3, 3)
        Stresses 11, 22, 12 from strains in plane stress, Pa.
    shear : ndarray, shape (2, 2)
        Stresses 13, 23 from strains, Pa.
    rho : float
        kg/m3.
    across : ndarray, shape (3,)
        Strain 33 from strains 11, 22, 12 in plane stress.
    angle : float
        From axis 1 of the shell to that of the layer, rad.
    strengths : ndarray, shape (6,)
        See `kanefe_fem.materials.strengths`; NaN if there are none.
    """

    bottom: float
    top: float
    plane: np.ndarray
    shear: np.ndarray
    rho: float
    across: np.ndarray
    angle: float
    strengths: np.ndarray


@dataclass(frozen=True, eq=False)
class ShellSection:
    """The layers of a shell, from its bottom (against the normal) to its top.

    Attributes
    ----------
    layers : tuple of Layer
    shear_factor : float or None
        Shear correction; None: that of the stack.
    """

    layers: tuple[Layer, ...]
    shear_factor: float | None = None

    def stiffness(self, power: int) -> np.ndarray:
        """Return A1, B1 or D1 (power 0, 1, 2), the moments of the plane stiffness, shape (3, 3), Pa."""
        return np.asarray(sum(layer.plane * _moment(layer, power) for layer in self.layers))

    def mass(self, power: int) -> float:
        """Return the moment of the density (power 0, 1, 2), kg/m3."""
        return float(sum(layer.rho * _moment(layer, power) for layer in self.layers))

    @cached_property
    def shear(self) -> np.ndarray:
        """S1, shear forces from transverse shear strains, shape (2, 2), Pa."""
        if self.shear_factor is not None:
            return np.asarray(self.shear_factor * sum(layer.shear * _moment(layer, 0) for layer in self.layers))
        return _shear_of_stack(self.layers)

    @property
    def shear_scale(self) -> float:
        """Shear stiffness over that of the layers without correction."""
        return float(np.trace(self.shear) / np.trace(sum(layer.shear * _moment(layer, 0) for layer in self.layers)))

    @cached_property
    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Heights of three points, as fractions of the thickness, and their shares of the mass.

        Gauss's quadrature of the density: moments of the mass up to the fifth are exact (Golub and Welsch, Math. Comp.
        23 (1969) 221).
        """
        x, w = np.polynomial.legendre.leggauss(4)
        places, shares = [], []
        for layer in self.layers:
            half = (layer.top - layer.bottom) / 2.0
            places.append(layer.bottom + half * (1.0 + x))
            shares.append(layer.rho * half * w)
        z, mass = np.concatenate(places), np.concatenate(shares)
        mass /= mass.sum()
        centre, beside, before, now = np.zeros(3), np.zeros(3), np.zeros(len(z)), np.ones(len(z))
        for k in range(3):
            centre[k] = mass @ (z * now**2)
            ahead = (z - centre[k]) * now - beside[k] * before
            if k < 2:
                beside[k + 1] = np.sqrt(mass @ ahead**2)
                before, now = now, ahead / beside[k + 1]
        heights, vectors = np.linalg.eigh(np.diag(centre) + np.diag(beside[1:], 1) + np.diag(beside[1:], -1))
        return heights, vectors[0] ** 2


def section(material: SolidMaterial, offset: float = 0.0, shear_factor: float | None = None) -> ShellSection:
    """Return the section of a material, or of the plies of a laminate.

    Parameters
    ----------
    material : SolidMaterial
        In the axes of the shell: 1 and 2 in the surface, 3 along the normal.
    offset : float
        Height of the middle of the thickness above the surface of the nodes, as a fraction of the thickness.
    shear_factor : float, optional
        Default: from the stack, 5/6 if it is homogeneous.
    """
    if not isinstance(material, Laminate):
        return ShellSection((_layer(material, offset - 0.5, offset + 0.5, 0.0),), shear_factor)
    heights = np.cumsum([0.0, *(ply.thickness for ply in material.plies)]) / material.thickness - 0.5 + offset
    layers = [
        _layer(ply.material, bottom, top, ply.angle)
        for ply, bottom, top in zip(material.plies, heights[:-1], heights[1:], strict=True)
    ]
    return ShellSection(tuple(layers), shear_factor)


def _layer(material: SolidMaterial, bottom: float, top: float, angle: float) -> Layer:
    C = rotated(material.stiffness, axes_at_angle(angle))
    compliance = np.linalg.inv(C)
    shear = np.linalg.inv(compliance[np.ix_(ACROSS, ACROSS)])
    plane = plane_stress(C)
    across = compliance[2, IN_PLANE] @ plane
    strengths = strengths_of(material)
    return Layer(float(bottom), float(top), plane, shear, float(material.rho), across, angle, strengths)


def _moment(layer: Layer, power: int) -> float:
    return _power(layer.bottom, layer.top, power)


def _shear_of_stack(layers: Sequence[Layer]) -> np.ndarray:
    """Return S1 from the energy of the shear stresses that balance bending (see `ShearStress`)."""
    stresses = ShearStress([(layer.bottom, layer.top) for layer in layers], [layer.plane for layer in layers])
    x, w = np.polynomial.legendre.leggauss(3)  # they are quadratic in a layer, so that their energy has degree 4
    compliance = np.zeros((2, 2))
    for number, layer in enumerate(layers):
        half = (layer.top - layer.bottom) / 2.0
        for place, weight in zip(x, w, strict=True):
            F = stresses.at(number, layer.bottom + half * (1.0 + place))
            compliance += half * weight * F.T @ np.linalg.solve(layer.shear, F)
    return np.asarray(np.linalg.inv(compliance))


class ShearStress:
    """Shear stresses through a stack that balance bending in two directions.

    Stresses of a moment M without forces, ``Q (b + z d) M``, grow along the plate as ``M,x = Q_x`` and ``M,y = Q_y``;
    their balance gives shear stresses ``F(z) (Q_x, Q_y) / t`` (Rohwer, Improved transverse shear stiffnesses for
    layered finite elements, DFVLR-FB 88-32, 1988). One layer has the parabola with 3/2 in the middle.

    Parameters
    ----------
    heights : sequence of (float, float)
        Bottom and top of the layers, as fractions of the thickness.
    planes : sequence of ndarray, shape (3, 3)
        Plane stiffness of the layers, Pa.
    """

    def __init__(self, heights: Sequence[Sequence[float]], planes: Sequence[np.ndarray]) -> None:
        self.heights, self.planes = heights, planes
        pairs = list(zip(heights, planes, strict=True))
        A, B, D = (sum(Q * _power(bottom, top, n) for (bottom, top), Q in pairs) for n in range(3))
        self.curvature = np.linalg.inv(D - B @ np.linalg.solve(A, B))
        self.stretch = -np.linalg.solve(A, B @ self.curvature)
        self.below = [np.zeros((2, 2))]
        for number, (_, top) in enumerate(heights):
            self.below.append(self.at(number, top))

    def at(self, number: int, z: float) -> np.ndarray:
        """Return F, stresses 13 and 23 from shear forces 1 and 2 over the thickness, in a layer at a height, (2, 2)."""
        bottom = self.heights[number][0]
        grown = self.stretch * _power(bottom, z, 0) + self.curvature * _power(bottom, z, 1)
        of = self.planes[number] @ grown
        return np.asarray(self.below[number] - np.array([[of[0, 0], of[2, 1]], [of[2, 0], of[1, 1]]]))


def _power(bottom: float, top: float, power: int) -> float:
    """Return the integral of a power of the height."""
    return (top ** (power + 1) - bottom ** (power + 1)) / (power + 1)
