"""Cross-sections of beams: area, second moments, torsion constant and shear factors.

Local axes: x along the beam, y and z in the section, from its centroid, along the principal directions. Hence
``I_y = int z^2 dA`` resists bending in the x-z plane and ``I_z = int y^2 dA`` bending in the x-y plane, the plane of
a planar model. The polar inertia of a unit length is ``rho (I_y + I_z)``; the torsion constant `J` is
Saint-Venant's and equals ``I_y + I_z`` for round sections only.

Shear factors kappa (shear stiffness ``kappa G A``) are those of Cowper, "The shear coefficient in Timoshenko's beam
theory", J. Appl. Mech. 33 (1966) 335-340. They depend on Poisson's ratio `nu`; the default 0 gives the classical 5/6
of a rectangle (and 6/7 of a circle), so pass the material's nu for Cowper's own value.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import numpy as np

from kanefe.arguments import checked, plain_numbers
from kanefe.errors import ModelError
from kanefe.frames import numbers
from kanefe_fem.beams.beam_section import BeamSection, LineMass
from kanefe_fem.beams.section_shapes import box_shear_factor, box_torsion, circle, rectangle, rectangle_torsion

if TYPE_CHECKING:
    from kanefe_fem.beams.stiffness_section import StiffnessSection


LARGEST = 1e60
"""Largest number of a section, in SI units: fourth powers of lengths stay within the range of floats."""


@dataclass(frozen=True)
class CrossSection(BeamSection):
    """Section whose stiffness and mass are those of a material; the base of the shapes below.

    Attributes
    ----------
    A : float
        Area in m2.
    I_y, I_z : float
        Second moments of area ``int z^2 dA`` and ``int y^2 dA`` in m4.
    J : float
        Saint-Venant's torsion constant in m4.
    shear_y, shear_z : float
        Shear factors of a shear force along y and along z.
    """

    A: float = field(init=False, repr=False)
    I_y: float = field(init=False, repr=False)
    I_z: float = field(init=False, repr=False)
    J: float = field(init=False, repr=False)
    shear_y: float = field(init=False, repr=False)
    shear_z: float = field(init=False, repr=False)

    @property
    def needs_material(self) -> bool:
        """True."""
        return True

    @property
    def turns_freely(self) -> bool:
        """Whether both directions across are equal."""
        return bool(np.isclose(self.I_y, self.I_z, rtol=1e-12) and np.isclose(self.shear_y, self.shear_z, rtol=1e-12))

    def stiffness_of(self, material: Any, *, planar: bool) -> np.ndarray:
        """Return EA, kappa G A, GJ and EI on the diagonal, shape (6, 6)."""
        E, G = material.E, material.shear_modulus
        shear_y, shear_z = self.shear_y * G * self.A, self.shear_z * G * self.A
        return np.diag([E * self.A, shear_y, shear_z, G * self.J, E * self.I_y, E * self.I_z])

    def mass_of(self, material: Any) -> LineMass:
        """Return the mass, whose centre is on the axis."""
        rho = material.rho
        return LineMass(rho * self.A, np.zeros(2), np.diag([rho * self.I_z, rho * self.I_y]))

    def fibres_of(self, material: Any) -> np.ndarray | None:
        """Return the fibres of the outline, all of one material."""
        outline = self._outline()
        return None if outline is None else np.column_stack((outline, np.full(len(outline), float(material.E))))

    def _outline(self) -> np.ndarray | None:
        """Return points around the outline, y and z in m, (FIBRES, 2); None if it has no shape."""
        return None

    def _set(self, A: float, I_y: float, I_z: float, J: float, shear_y: float, shear_z: float) -> None:
        """Store the numbers of a frozen shape."""
        numbers = {"A": A, "I_y": I_y, "I_z": I_z, "J": J, "shear_y": shear_y, "shear_z": shear_z}
        for name, value in numbers.items():
            object.__setattr__(self, name, float(value))

    def _require_positive(self, *names: str) -> None:
        for name in names:
            value = getattr(self, name)
            if numbers(value).shape != () or not 0.0 < numbers(value) < LARGEST:
                raise ModelError(
                    f"{type(self).__name__}: {name} = {value!r} must be a positive number below {LARGEST:g}. "
                    "Remedy: give it in SI units"
                )
        plain_numbers(self)

    def _require_poisson(self, nu: float) -> None:
        if numbers(nu).shape != () or not -1.0 < numbers(nu) <= 0.5:
            raise ModelError(
                f"{type(self).__name__}: nu = {nu!r} is outside (-1, 0.5]. Remedy: Poisson's ratio, or leave it out"
            )


class Stiffnesses(TypedDict, total=False):
    """Stiffnesses of a section: keywords of `Section.from_stiffness`."""

    EA: float | None
    EI_y: float | None
    EI_z: float | None
    GJ: float | None
    GA_y: float | None
    GA_z: float | None


@dataclass(frozen=True)
class Section(CrossSection):
    """Section given by its numbers.

    Attributes
    ----------
    A, I_y, I_z, J, shear_y, shear_z : float
        As in `CrossSection`. The shear factors default to the rectangle's 5/6; Euler-Bernoulli beams ignore them.

    Raises
    ------
    ModelError
        If a number is not positive and finite, or a shear factor is above 1.

    Examples
    --------
    >>> Section(A=1e-3, I_y=2e-7, I_z=4e-7, J=3e-7).I_z
    4e-07
    """

    A: float
    I_y: float
    I_z: float
    J: float
    shear_y: float = 5.0 / 6.0
    shear_z: float = 5.0 / 6.0

    def __post_init__(self) -> None:
        self._require_positive("A", "I_y", "I_z", "J", "shear_y", "shear_z")
        for name in ("shear_y", "shear_z"):
            # a mean square is not below the square of the mean, so the energy of shear is at least V^2/2GA
            if getattr(self, name) > 1.0:
                raise ModelError(
                    f"Section: {name} = {getattr(self, name):g}, but a shear factor is at most 1. "
                    "Remedy: give the factor kappa (5/6 for a rectangle), not the shear area"
                )

    @classmethod
    @checked
    def from_stiffness(
        cls,
        stiffness: Sequence[Sequence[float]] | np.ndarray | None = None,
        *,
        rho_A: float | None = None,
        rho_I: float | Sequence[float] | None = None,
        centre_of_mass: Sequence[float] = (0.0, 0.0),
        mass: Sequence[Sequence[float]] | np.ndarray | None = None,
        **stiffnesses: Unpack[Stiffnesses],
    ) -> StiffnessSection:
        """Return a section given by stiffness and mass per unit length; beams with it have no material.

        Parameters
        ----------
        stiffness : array_like, shape (6, 6), optional
            All stiffnesses with their coupling (such as bend-twist of a blade), instead of the numbers below: the
            forces N, V_y, V_z in N and moments T, M_y, M_z in N m from stretch, shear strains and, in 1/m, twist and
            curvatures; x is along the beam. Signs are those of `kanefe_fem.recovery.section_forces.SectionForces`. From
            the order of BeamDyn (x and y across, z along) by ``K[np.ix_(p, p)]``, p = [2, 0, 1, 5, 3, 4].
        rho_A : float
            Mass in kg/m.
        rho_I : float or (float, float), optional
            ``int rho z^2 dA`` (of bending about y) and ``int rho y^2 dA`` (about z) in kg m about the centre of mass,
            or one number for both; the inertia of twisting is their sum. Default: that of a section of one material,
            ``rho_A EI / EA``.
        centre_of_mass : array_like, shape (2,)
            Its y and z from the axis in m.
        mass : array_like, shape (6, 6), optional
            Mass matrix over velocities and rates of rotation along x, y, z, instead of `rho_A`, `rho_I` and
            `centre_of_mass`.
        **stiffnesses
            The other parameters below.

        Other Parameters
        ----------------
        EA : float
            Axial stiffness in N.
        EI_y, EI_z : float
            Bending stiffnesses in N m2, as `I_y` and `I_z`; a planar beam needs `EI_z` only.
        GJ : float
            Torsional stiffness in N m2; a planar beam needs none.
        GA_y, GA_z : float, optional
            Shear stiffnesses kappa G A in N. Default: rigid in shear.

        Raises
        ------
        ModelError
            If numbers are missing, given twice, not positive and finite, a matrix is not symmetric and positive, or
            `mass` is not that of a rigid section.

        Examples
        --------
        >>> blade = Section.from_stiffness(EA=1e9, EI_y=2e6, EI_z=8e6, GJ=1e6, rho_A=40.0, rho_I=(0.1, 0.4))
        >>> float(blade.stiffness_of(None, planar=False)[4, 4])
        2000000.0
        """
        from kanefe_fem.beams.stiffness_section import StiffnessSection

        numbers = {name: stiffnesses.get(name) for name in ("EA", "GA_y", "GA_z", "GJ", "EI_y", "EI_z")}
        return StiffnessSection.of(numbers, stiffness, rho_A, rho_I, centre_of_mass, mass)


@dataclass(frozen=True)
class SolidCircle(CrossSection):
    """Solid round bar, by its diameter.

    Attributes
    ----------
    diameter : float
        In m.
    nu : float
        Poisson's ratio, for the shear factor only.

    Raises
    ------
    ModelError
        If the diameter is not positive or nu is no Poisson's ratio.

    Examples
    --------
    >>> round(SolidCircle(0.02).A * 1e6, 3)
    314.159
    """

    diameter: float
    nu: float = 0.0

    def __post_init__(self) -> None:
        self._require_positive("diameter")
        self._require_poisson(self.nu)
        second_moment = math.pi * self.diameter**4 / 64.0
        shear = 6.0 * (1.0 + self.nu) / (7.0 + 6.0 * self.nu)
        area = math.pi * self.diameter**2 / 4.0
        self._set(area, second_moment, second_moment, 2.0 * second_moment, shear, shear)

    def _outline(self) -> np.ndarray:
        return circle(self.diameter)


@dataclass(frozen=True)
class Tube(CrossSection):
    """Round tube.

    Attributes
    ----------
    outer_diameter, thickness : float
        In m.
    nu : float
        Poisson's ratio, for the shear factor only.

    Raises
    ------
    ModelError
        If a length is not positive, the wall leaves no hole, or nu is no Poisson's ratio.

    Examples
    --------
    >>> tube = Tube(outer_diameter=0.05, thickness=0.002)
    >>> tube.J == 2 * tube.I_y
    True
    """

    outer_diameter: float
    thickness: float
    nu: float = 0.0

    def __post_init__(self) -> None:
        self._require_positive("outer_diameter", "thickness")
        self._require_poisson(self.nu)
        outer, inner = self.outer_diameter, self.outer_diameter - 2.0 * self.thickness
        if inner <= 0.0:
            raise ModelError(
                f"Tube: thickness {self.thickness:g} m leaves no hole in an outer diameter of {outer:g} m. "
                "Remedy: a thickness below half the diameter, or SolidCircle"
            )
        # products, since differences of powers would lose the digits of a thin wall
        area = math.pi * self.thickness * (outer - self.thickness)
        second_moment = area * (outer**2 + inner**2) / 16.0
        ratio = (inner / outer) ** 2
        square = (1.0 + ratio) ** 2
        shear = 6.0 * (1.0 + self.nu) * square
        shear /= (7.0 + 6.0 * self.nu) * square + (20.0 + 12.0 * self.nu) * ratio
        self._set(area, second_moment, second_moment, 2.0 * second_moment, shear, shear)

    def _outline(self) -> np.ndarray:
        return circle(self.outer_diameter)


@dataclass(frozen=True)
class Rectangle(CrossSection):
    """Solid rectangle. A planar model bends in its plane, across the `width`.

    Attributes
    ----------
    width, height : float
        Extent along local y and along local z in m.
    nu : float
        Poisson's ratio, for the shear factor only; 0 gives 5/6.

    Raises
    ------
    ModelError
        If a length is not positive or nu is no Poisson's ratio.

    Examples
    --------
    >>> round(Rectangle(width=1.0, height=1.0).J, 6)
    0.140577
    """

    width: float
    height: float
    nu: float = 0.0

    def __post_init__(self) -> None:
        self._require_positive("width", "height")
        self._require_poisson(self.nu)
        b, h = self.width, self.height
        shear = 10.0 * (1.0 + self.nu) / (12.0 + 11.0 * self.nu)
        self._set(b * h, b * h**3 / 12.0, h * b**3 / 12.0, rectangle_torsion(max(b, h), min(b, h)), shear, shear)

    def _outline(self) -> np.ndarray:
        return rectangle(self.width, self.height)


@dataclass(frozen=True)
class Box(CrossSection):
    """Rectangular hollow section of one wall thickness, with sharp corners.

    The area and the second moments are exact. The torsion constant is Bredt's with the walls' own torsion and the
    sharp corners accounted for: within 1e-4 of the exact value for walls up to a tenth of the smaller side, within
    1 % up to 0.4 of it (Bredt's alone is 2 to 6 % low). The shear factor is Cowper's thin-walled box on the mid-line.

    Attributes
    ----------
    width, height : float
        Outer extent along local y and along local z in m.
    thickness : float
        Wall in m.
    nu : float
        Poisson's ratio, for the shear factor only.

    Raises
    ------
    ModelError
        If a length is not positive, the walls leave no hole, or nu is no Poisson's ratio.

    Examples
    --------
    >>> round(Box(width=0.1, height=0.1, thickness=0.001).shear_y, 4)
    0.4167
    """

    width: float
    height: float
    thickness: float
    nu: float = 0.0

    def __post_init__(self) -> None:
        self._require_positive("width", "height", "thickness")
        self._require_poisson(self.nu)
        t, b, h = self.thickness, self.width, self.height
        hole_b, hole_h = b - 2.0 * t, h - 2.0 * t
        if min(hole_b, hole_h) <= 0.0:
            raise ModelError(
                f"Box: thickness {t:g} m leaves no hole in {b:g} m x {h:g} m. "
                "Remedy: a thickness below half the smaller side, or Rectangle"
            )
        mid_b, mid_h = b - t, h - t
        self._set(
            A=2.0 * (mid_b + mid_h) * t,
            I_y=(b * h**3 - hole_b * hole_h**3) / 12.0,
            I_z=(h * b**3 - hole_h * hole_b**3) / 12.0,
            J=box_torsion(mid_b, mid_h, t),
            shear_y=box_shear_factor(mid_b, mid_h, self.nu),
            shear_z=box_shear_factor(mid_h, mid_b, self.nu),
        )

    def _outline(self) -> np.ndarray:
        return rectangle(self.width, self.height)
